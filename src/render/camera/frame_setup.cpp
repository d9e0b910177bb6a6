#include "src/render/camera/frame_setup.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "src/render/camera/clipped_box.h"
#include "src/render/camera/index_space.h"

namespace sluice {
namespace {

struct Frustum {
  Vec3d right, up;  // world: half the picture's width and height (perspective: at depth 1)
};

Frustum frustumOf(const View& view) {
  const double aspect = view.size.aspect();
  return {view.right * (aspect * view.half_height), view.up * view.half_height};
}

// u = 2 x / width - 1 and v = 2 y / height - 1, put into the ray's formula.
RayGrid raysOf(const View& view, const VolumeLayout& layout) {
  const auto [right, up] = frustumOf(view);
  const auto direction = [&](Vec3d world) { return indexFromWorldDirection(layout, world); };
  const Vec3d corner = direction(right + up) * -1.0;  // at u = v = -1
  const Vec3d dx = direction(right) * (2.0 / view.size.width);
  const Vec3d dy = direction(up) * (2.0 / view.size.height);
  const Vec3d eye = indexFromWorld(layout, view.eye), forward = direction(view.forward);
  RayGrid rays;
  if (view.projection == Projection::kPerspective) {
    rays.origin0 = eye + (forward + corner) * view.first_depth;
    rays.origin_dx = dx * view.first_depth;
    rays.origin_dy = dy * view.first_depth;
    rays.step0 = (forward + corner) * view.step;
    rays.step_dx = dx * view.step;
    rays.step_dy = dy * view.step;
  } else {
    rays.origin0 = eye + corner + forward * view.first_depth;
    rays.origin_dx = dx;
    rays.origin_dy = dy;
    rays.step0 = forward * view.step;
  }
  return rays;
}

// A row that takes dot(world - eye, along) from an index position.
std::array<double, 4> rowOf(const View& view, const VolumeLayout& layout, Vec3d along) {
  // World = origin + axes * spacing * index, so that the dot product is linear in the index.
  std::array<double, 4> row{};
  for (size_t a = 0; a < 3; ++a)
    row[a] = dot(layout.axes[a], along) * layout.spacing[static_cast<int>(a)];
  row[3] = dot(layout.origin - view.eye, along);
  return row;
}

// The first slice in front of a perspective eye.
int64_t firstSlice(const View& view) {
  if (view.projection == Projection::kOrtho || view.first_depth > 0) return 0;
  // Slices lie at (k + 1/2) steps from the volume's corner on the eye's side. Those behind the eye
  // are left out.
  return static_cast<int64_t>(std::floor(-view.first_depth / view.step - 0.5)) + 1;
}

// FrameSetup::window. If all colours lie at one value, as those of a threshold above the range do,
// the values from there on have the last colour: the window ends at the first entry that has it and
// begins an entry before.
std::array<double, 2> windowOf(const Look& look, const ValueMap& map) {
  const std::vector<ColorPoint>& colors = look.transfer.colors;
  const double first = map.deviceOf(colors.front().value), last = map.deviceOf(colors.back().value);
  if (first != last) return {first, last};
  constexpr double kRounding = 1e-6;
  const ValueRange range = look.look_up->device_range;
  const size_t entries = look.look_up->rgba.size() / 4;
  const double entry = entries > 1 && range.hi > range.lo
                           ? (range.hi - range.lo) / static_cast<double>(entries - 1)
                           : 1;
  const double at = (last - range.lo) / entry;
  const bool ascends = map.scale > 0;
  const double end =
      range.lo + entry * (ascends ? std::ceil(at - kRounding) : std::floor(at + kRounding));
  return {ascends ? end - entry : end + entry, end};
}

// The depths between which the clip planes leave something of the cells; those of the whole box if
// they leave nothing.
std::array<double, 2> depthsOf(const FrameSetup& setup, const Box3& cells) {
  std::vector<Vec3d> corners = clippedCorners(cells, setup.clip_planes);
  if (corners.empty()) corners = clippedCorners(cells, {});
  std::array<double, 2> depths{1e300, -1e300};
  const auto& row = setup.depth_from_index;
  for (const Vec3d& corner : corners) {
    const double depth = row[3] + row[0] * corner.x + row[1] * corner.y + row[2] * corner.z;
    depths = {std::min(depths[0], depth), std::max(depths[1], depth)};
  }
  if (setup.projection == Projection::kPerspective) depths[0] = std::max(depths[0], 0.0);
  return depths;
}

// The colours of the transfer function, from the last one at the nearest depth to the first at the
// farthest, so that near things are bright and warm in most maps.
std::vector<Vec3d> depthColors(const TransferFunction& transfer) {
  constexpr int kColors = 1024;
  std::vector<Vec3d> colors;
  colors.reserve(kColors);
  const double lo = transfer.colors.front().value, hi = transfer.colors.back().value;
  for (int i = 0; i < kColors; ++i)
    colors.push_back(colorAt(transfer, std::lerp(hi, lo, i / (kColors - 1.0))));
  return colors;
}

FrameSetup setupOf(const View& view, const VolumeLayout& layout, const OpacityTable& table,
                   LookUpPtr look_up, const ValueMap& map, const FrameOptions& options) {
  FrameSetup setup = viewSetup(view, layout, options.clip_planes);
  setup.shown = cropCells(options, layout.dims);
  setup.shown_depths = shownDepths(view, layout, options);
  setup.type = map.type;
  setup.look_up = std::move(look_up);
  setup.mode = deviceMode(options.mode, map.scale);
  // The rounding of 1 / (1 / n) makes no more of n.
  setup.planes_a_voxel = std::max(
      1, static_cast<int>(
             std::ceil(setup.slice_length > 0 ? std::min(1 / setup.slice_length, 1e6) - 1e-6 : 1)));
  shiftView(setup, options.ray_shift);
  setup.opacity_threshold = rayThreshold(options);
  setup.with_depth = options.with_depth;
  setup.is_one_of_several = options.is_one_of_several;
  // Extremes and averages keep their exact values: neither fog nor jitter applies to them.
  if (traitsOf(setup.mode).has_colors) {
    setup.depth_cueing = options.depth_cueing;
    setup.jitter = options.jitter;
  }
  setup.shades_every_sample = options.skipping == Skipping::kNone;
  setup.skips = options.skipping == Skipping::kLeaps;
  setup.lighting = options.lighting;
  // Gradients are covectors: from index to world they are divided by the spacing.
  for (size_t a = 0; a < 3; ++a) {
    const Vec3d gradient = layout.axes[a] / layout.spacing[static_cast<int>(a)];
    setup.camera_gradient[a] = {dot(gradient, view.right), dot(gradient, view.up),
                                -dot(gradient, view.forward)};
  }
  const ValueRange range = table.volumeRange();
  setup.flat = options.lighting.flat_share * (range.hi - range.lo) / finestSpacing(layout);
  // Labels are no quantities: their flat places are judged by differences of opacity.
  if (table.labels()) setup.flat = kFlatOpacity / finestSpacing(layout);
  return setup;
}

}  // namespace

std::vector<ClipPlane> clipPlanes(const std::vector<WorldPlane>& planes,
                                  const VolumeLayout& layout) {
  std::vector<ClipPlane> result;
  for (const WorldPlane& plane : planes) {
    ClipPlane clip;
    for (int a = 0; a < 3; ++a)
      clip.normal[a] = dot(layout.axes[static_cast<size_t>(a)], plane.normal) * layout.spacing[a];
    clip.offset = plane.offset - dot(layout.origin, plane.normal);
    result.push_back(clip);
  }
  return result;
}

FrameSetup viewSetup(const View& view, const VolumeLayout& layout,
                     const std::vector<WorldPlane>& planes) {
  FrameSetup setup;
  setup.size = view.size;
  setup.projection = view.projection;
  setup.rays = raysOf(view, layout);
  const auto [right, up] = frustumOf(view);
  // Divided by the squared length, so that the edge of the picture is at 1.
  setup.clip_from_index[0] = rowOf(view, layout, right / dot(right, right));
  setup.clip_from_index[1] = rowOf(view, layout, up / dot(up, up));
  if (view.projection == Projection::kPerspective) {
    setup.clip_from_index[2] = rowOf(view, layout, view.forward);
    setup.tan_half_x = length(right);
    setup.tan_half_y = length(up);
  } else {
    // A parallel view has no perspective: w is 1.
    setup.clip_from_index[2] = {0, 0, 0, 1};
  }
  setup.first_slice = firstSlice(view);
  setup.first_depth = view.first_depth;
  setup.depth_step = view.step;
  setup.depth_from_index = rowOf(view, layout, view.forward);
  setup.slice_length = view.step / finestSpacing(layout);
  setup.shown = boxOf(layout.dims - Vec3i{1, 1, 1});
  setup.clip_planes = clipPlanes(planes, layout);
  return setup;
}

void shiftView(FrameSetup& setup, std::array<double, 2> pixels) {
  RayGrid& rays = setup.rays;
  rays.origin0 = rays.origin0 + rays.origin_dx * pixels[0] + rays.origin_dy * pixels[1];
  rays.step0 = rays.step0 + rays.step_dx * pixels[0] + rays.step_dy * pixels[1];
  // Clip space is 2 wide and 2 high, and x and y there are still to be divided by w.
  const std::array<int, 2> size{setup.size.width, setup.size.height};
  for (size_t axis = 0; axis < 2; ++axis)
    for (size_t i = 0; i < 4; ++i)
      setup.clip_from_index[axis][i] -= 2 * pixels[axis] / size[axis] * setup.clip_from_index[2][i];
}

FrameSetup frameSetup(const View& view, const VolumeLayout& layout, const OpacityTable& table,
                      const ValueMap& map, const FrameOptions& options) {
  return setupOf(view, layout, table,
                 std::make_shared<const LookUp>(lookUp(table, finestSpacing(layout))), map,
                 options);
}

FrameSetup frameSetup(const View& view, const VolumeLayout& layout, const Look& look,
                      const ValueMap& map, const FrameOptions& options, bool lit) {
  FrameSetup setup = setupOf(view, layout, look.table, look.look_up, map, options);
  setup.lit = lit;
  setup.window = windowOf(look, map);
  setup.attenuation = look.transfer.attenuation;
  if (traitsOf(setup.mode).codes_depth) setup.depth_colors = depthColors(look.transfer);
  // Rays or pixels may stop, or leap, so that fewer samples are taken than lie in the frame's
  // boxes.
  setup.counts_taken = options.count_samples && traitsOf(options.mode).hides &&
                       !options.with_depth && (rayThreshold(options) < 1 || options.counts_leaps);
  return setup;
}

double longestStep(const View& view, const VolumeLayout& layout, Vec3d voxel) {
  const RayGrid rays = raysOf(view, layout);
  const double width = view.size.width, height = view.size.height;
  double longest = 0;
  // A step changes linearly over the picture: its greatest part is at a corner.
  for (const double x : {0.0, width})
    for (const double y : {0.0, height}) {
      const Vec3d step = (rays.step0 + rays.step_dx * x + rays.step_dy * y) / voxel;
      longest = std::max({longest, std::abs(step.x), std::abs(step.y), std::abs(step.z)});
    }
  return longest;
}

bool stepsIntegrate(const View& view, const VolumeLayout& layout) {
  // A step of exactly the limit may come out a little longer by rounding.
  return longestStep(view, layout) <= kMostIntegratedStep * (1 + 1e-6);
}

std::array<double, 2> shownDepths(const View& view, const VolumeLayout& layout,
                                  const FrameOptions& options) {
  if (options.shown_depths) return *options.shown_depths;
  const auto corners =
      depthsOf(viewSetup(view, layout, options.clip_planes), cropCells(options, layout.dims));
  if (options.shown_points == nullptr) return corners;
  std::array<double, 2> depths{1e300, -1e300};
  for (const Vec3d& point : *options.shown_points) {
    const double depth = dot(point - view.eye, view.forward);
    depths = {std::min(depths[0], depth), std::max(depths[1], depth)};
  }
  depths = {std::max(depths[0], corners[0]), std::min(depths[1], corners[1])};
  return depths[0] < depths[1] ? depths : corners;
}

EyePosition eyePosition(const View& view, const VolumeLayout& layout) {
  if (view.projection == Projection::kOrtho)
    return {true, indexFromWorldDirection(layout, view.forward)};
  return {false, indexFromWorld(layout, view.eye)};
}

}  // namespace sluice
