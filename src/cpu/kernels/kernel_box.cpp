#include "src/cpu/kernels/kernel_box.h"

#include <algorithm>
#include <cmath>

#include "src/base/error.h"
#include "src/cpu/kernels/floats.h"
#include "src/device/pictures/depth_code.h"
#include "src/device/shading/label_shares.h"
#include "src/device/shading/rough_light.h"

namespace sluice {
namespace {

// Texels; whole numbers up to here are exact in single precision.
constexpr int64_t kMostOffset = int64_t{1} << 24;
// Pixels around the projected box that are included to cover rounding.
constexpr double kMarginPixels = 0.6;

double along(const std::array<double, 4>& row, Vec3d p) {
  return row[0] * p.x + row[1] * p.y + row[2] * p.z + row[3];
}

Vec3d cornerOf(const Box3& cells, int corner) {
  return {static_cast<double>((corner & 1) != 0 ? cells.hi.x : cells.lo.x),
          static_cast<double>((corner & 2) != 0 ? cells.hi.y : cells.lo.y),
          static_cast<double>((corner & 4) != 0 ? cells.hi.z : cells.lo.z)};
}

int clampedPixel(double at, int count) {
  return static_cast<int>(std::clamp(at, 0.0, static_cast<double>(count)));
}

// The pixels around the box's projected corners, and the slice of the nearest corner.
struct Seen {
  double x_lo = 1e300, y_lo = 1e300, x_hi = -1e300, y_hi = -1e300, near_slice = 1e300;
};

Seen seenOf(const FrameSetup& setup, const Box3& cells) {
  const RayGrid& rays = setup.rays;
  const bool perspective = setup.projection == Projection::kPerspective;
  // The slice planes of a parallel view are spanned by origin_dx and origin_dy.
  const Vec3d normal = cross(rays.origin_dx, rays.origin_dy);
  const double pace = dot(rays.step0, normal);
  Seen seen;
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3d p = cornerOf(cells, corner);
    const double w = along(setup.clip_from_index[2], p);
    seen.near_slice =
        std::min(seen.near_slice, perspective ? (w - setup.first_depth) / setup.depth_step
                                              : dot(p - rays.origin0, normal) / pace);
    if (w <= 0) {  // next to the eye: may project anywhere
      seen.x_lo = seen.y_lo = -1e300;
      seen.x_hi = seen.y_hi = 1e300;
      continue;
    }
    const double x = (along(setup.clip_from_index[0], p) / w + 1) / 2 * setup.size.width;
    const double y = (along(setup.clip_from_index[1], p) / w + 1) / 2 * setup.size.height;
    seen.x_lo = std::min(seen.x_lo, x), seen.x_hi = std::max(seen.x_hi, x);
    seen.y_lo = std::min(seen.y_lo, y), seen.y_hi = std::max(seen.y_hi, y);
  }
  return seen;
}

// The first and the last texel that the box's samples lie between, and the interval of the samples.
struct TexelSpan {
  Vec3i lo, hi;
  Vec3d from, to;
};
TexelSpan texelsOf(const BoxDraw& box, Vec3i storage) {
  // Rounding error that the map may add to a whole number.
  constexpr double kRounding = 1e-6;
  TexelSpan span{{}, {}, box.texels(toDouble(box.cells.lo)), box.texels(toDouble(box.cells.hi))};
  for (int a = 0; a < 3; ++a) {
    SLUICE_CHECK(span.from[a] >= -1 && span.to[a] <= static_cast<double>(storage[a]));
    const auto lo = static_cast<int64_t>(std::floor(span.from[a] + kRounding));
    const auto hi = static_cast<int64_t>(std::ceil(span.to[a] - kRounding));
    // The last cell begins at the last texel but one. Chunks of one texel have one cell all the
    // same.
    span.lo[a] = std::clamp<int64_t>(lo, 0, std::max<int64_t>(storage[a] - 2, 0));
    span.hi[a] = std::clamp<int64_t>(hi, span.lo[a] + 1, std::max(storage[a] - 1, span.lo[a] + 1));
  }
  return span;
}

// The values that follow from the map without a chunk. Texel coordinates keep only their fraction.
void setScale(const FrameSetup& setup, const BoxDraw& box, KernelBox& out) {
  const Vec3d from = box.texels(toDouble(box.cells.lo));
  out.texel_length = static_cast<float>(texelLength(box.texels.scale));
  out.edge_texels = static_cast<float>(edgeTexels(box.texels.scale));
  out.noise_part = static_cast<float>(noisePart(box.texels.scale));
  for (int a = 0; a < 3; ++a) {
    const auto i = static_cast<size_t>(a), axis = static_cast<size_t>(box.texels.axes[i]);
    out.texel_scale[axis] = static_cast<float>(box.texels.scale[a]);
    out.texel_start[axis] = static_cast<float>(from[a] - std::floor(from[a]));
    const Vec3d gradient = setup.camera_gradient[axis] * box.texels.scale[a];
    out.gradient[i] = asFloats(gradient);
    out.gradient_squares += static_cast<float>(dot(gradient, gradient));
  }
}

void setTexels(const BoxDraw& box, const ChunkTexels& chunk, const TexelSpan& span,
               KernelBox& out) {
  const Vec3i storage = chunk.storage_vox;
  const auto& [lo, hi, from, to] = span;
  const auto texel = static_cast<int64_t>(chunk.texelBytes());
  out.has_spread = chunk.has_spread;
  const Vec3i stride{texel, texel * storage.x, texel * storage.x * storage.y};
  out.texels = chunk.bytes.get() + lo.x * stride.x + lo.y * stride.y + lo.z * stride.z;
  out.has_margin = true;
  for (int a = 0; a < 3; ++a) {
    const auto i = static_cast<size_t>(a);
    const double last = std::min(to[a], static_cast<double>(storage[a] - 1));
    out.texel_hi[i] = static_cast<float>(last - static_cast<double>(lo[a]));
    out.last_cell[i] = static_cast<float>(hi[a] - lo[a] - 1);
    // Only boxes that reach beyond the chunk's texels need their samples clamped.
    out.clamps = out.clamps || from[a] < 0 || to[a] > last;
    out.texel_start[static_cast<size_t>(box.texels.axes[i])] =
        static_cast<float>(from[a] - static_cast<double>(lo[a]));
    out.storage_lo[i] = static_cast<float>(-lo[a]);
    out.storage_hi[i] = static_cast<float>(storage[a] - 1 - lo[a]);
    out.stride[i] = static_cast<float>(stride[a]);
    // Differences read one texel more on each side.
    out.has_margin = out.has_margin && lo[a] > 0 && hi[a] + 1 < storage[a];
  }
}

// Requires: texel_scale and texel_start are set.
void setLight(const LightVolume& light, const BoxDraw& box, KernelBox& out) {
  for (int a = 0; a < 3; ++a)
    out.light_axes[static_cast<size_t>(box.texels.axes[static_cast<size_t>(a)])] = a;
  for (int a = 0; a < 3; ++a) {
    const auto i = static_cast<size_t>(a);
    const double scale = light.scale[a] / double{out.texel_scale[i]};
    const double at_corner = static_cast<double>(box.cells.lo[a]) * light.scale[a];
    out.light_scale[i] = static_cast<float>(scale);
    out.light_start[i] =
        static_cast<float>(at_corner + light.offset[a] - double{out.texel_start[i]} * scale);
  }
}

// Requires: texel_start is set.
void setDepth(const FrameSetup& setup, const BoxDraw& box, KernelBox& out) {
  const std::array<double, 4> row = depthRow(setup);
  double start = row[3];
  for (int a = 0; a < 3; ++a) {
    const auto i = static_cast<size_t>(a), axis = static_cast<size_t>(box.texels.axes[i]);
    const double along = row[axis] / box.texels.scale[a];
    out.depth_along[i] = static_cast<float>(along);
    start += row[axis] * static_cast<double>(box.cells.lo[static_cast<int>(axis)]) -
             along * double{out.texel_start[axis]};
  }
  out.depth_start = static_cast<float>(start);
}

// Requires: texel_scale and texel_start are set.
void setFade(const BoxDraw& box, KernelBox& out) {
  out.fades = true;
  for (int a = 0; a < 3; ++a)
    for (const size_t upper : {size_t{0}, size_t{1}}) {
      const auto to = static_cast<size_t>(a);
      const auto axis = static_cast<size_t>(box.texels.axes[to]), from = axis + 3 * upper;
      const double slope = box.fade->slope[from] / double{out.texel_scale[axis]};
      const auto corner = static_cast<double>(box.cells.lo[static_cast<int>(axis)]);
      out.fade_slope[upper][to] = static_cast<float>(slope);
      out.fade_start[upper][to] =
          static_cast<float>(box.fade->start[from] + box.fade->slope[from] * corner -
                             slope * double{out.texel_start[axis]});
    }
}

void setLeaps(const LeapGrid& leaps, Vec3i lo, KernelBox& out) {
  if (volume(leaps.bricks) > kMostOffset) return;  // their numbers would not be exact
  out.distances = leaps.distances.data();
  out.brick_at = asFloats(toDouble(lo) * (1.0 / kBrickSide));
  out.brick_last = asFloats(toDouble(leaps.bricks - Vec3i{1, 1, 1}));
  out.brick_stride = asFloats(toDouble(Vec3i{1, leaps.bricks.x, leaps.bricks.x * leaps.bricks.y}));
}

void appendPart(const FrameSetup& setup, const BoxDraw& box, const ChunkTexels* chunk,
                const LeapGrid* leaps, std::vector<KernelBox>& out) {
  const auto [x_lo, y_lo, x_hi, y_hi, near_slice] = seenOf(setup, box.cells);
  KernelBox result;
  const auto [width, height] = setup.size;
  // Drawing a pixel too many costs nothing but time; the kernel finds no slice there.
  result.x_lo = clampedPixel(std::floor(x_lo - kMarginPixels), width);
  result.y_lo = clampedPixel(std::floor(y_lo - kMarginPixels), height);
  result.x_hi = clampedPixel(std::ceil(x_hi + kMarginPixels), width);
  result.y_hi = clampedPixel(std::ceil(y_hi + kMarginPixels), height);
  if (result.x_lo >= result.x_hi || result.y_lo >= result.y_hi) return;
  const RayGrid& rays = setup.rays;
  const Vec3d lo = toDouble(box.cells.lo), hi = toDouble(box.cells.hi);
  result.lo = asFloats(lo - rays.origin0);
  result.hi = asFloats(hi - rays.origin0);
  result.corner = asFloats(lo - placeBase(setup));
  result.axes = box.texels.axes;
  setScale(setup, box, result);
  result.layer = box.layer;
  result.is_beside = box.beside.has_value();
  const double first = std::max(static_cast<double>(setup.first_slice), std::floor(near_slice));
  result.first_slice = static_cast<float>(first);
  // Positions count from the box's first slice, so that single precision has digits enough far
  // away.
  const Vec3d at = rays.origin0 + rays.step0 * (first + 0.5) - lo;
  const Vec3d dx = rays.origin_dx + rays.step_dx * (first + 0.5);
  const Vec3d dy = rays.origin_dy + rays.step_dy * (first + 0.5);
  result.voxel0 = at;
  result.voxel_dx = dx;
  result.voxel_dy = dy;
  result.size = asFloats(hi - lo);
  const OuterFaces outer = outerFaces(setup, box.cells);
  for (size_t a = 0; a < 3; ++a) {
    // Faces of what is shown end the way of a ray; faces between boxes do not.
    result.inside_lo[a] = outer.lo[a] ? 0 : kInside;
    result.inside_hi[a] = outer.hi[a] ? 0 : kInside;
  }
  if (chunk != nullptr) {
    const TexelSpan span = texelsOf(box, chunk->storage_vox);
    setTexels(box, *chunk, span, result);
    if (leaps != nullptr) setLeaps(*leaps, span.lo, result);
    if (traitsOf(setup.mode).codes_depth) setDepth(setup, box, result);
    if (setup.light != nullptr) setLight(*setup.light, box, result);
    if (box.fade) setFade(box, result);
  }
  out.push_back(result);
}

// Whether the eye is on the lower side of the plane.
bool seesLowerFirst(const FrameSetup& setup, int axis, int64_t plane) {
  const RayGrid& rays = setup.rays;
  // All rays of a parallel view go the same way.
  if (setup.projection != Projection::kPerspective) return rays.step0[axis] >= 0;
  // All rays meet at the eye.
  const Vec3d eye = rays.origin0 - rays.step0 * (setup.first_depth / setup.depth_step);
  return eye[axis] < static_cast<double>(plane);
}

// Whether offsets of its texels are exact in single precision.
bool isNear(const BoxDraw& box, Vec3i storage) {
  const TexelSpan texels = texelsOf(box, storage);
  // Two more along each axis, for differences.
  const Vec3i span = texels.hi - texels.lo + Vec3i{2, 2, 2};
  return span.x + span.y * storage.x + span.z * storage.x * storage.y <= kMostOffset;
}

// The part of the boxes on one side of a plane.
std::vector<ChannelBox> partOf(std::span<const ChannelBox> boxes, int axis, int64_t plane,
                               bool lower) {
  std::vector<ChannelBox> part;
  for (ChannelBox each : boxes) {
    Box3& cells = each.box.cells;
    if (lower)
      cells.hi[axis] = std::min(cells.hi[axis], plane);
    else
      cells.lo[axis] = std::max(cells.lo[axis], plane);
    if (!cells.empty()) part.push_back(each);
  }
  return part;
}

// The first box is seen where any of them is; the others have no pixels of their own.
void join(std::span<KernelBox> boxes) {
  KernelBox& first = boxes.front();
  for (KernelBox& box : boxes.subspan(1)) {
    first.x_lo = std::min(first.x_lo, box.x_lo), first.x_hi = std::max(first.x_hi, box.x_hi);
    first.y_lo = std::min(first.y_lo, box.y_lo), first.y_hi = std::max(first.y_hi, box.y_hi);
    box.x_lo = box.y_lo = kTileSide, box.x_hi = box.y_hi = 1;
  }
  first.joined = static_cast<uint32_t>(boxes.size() - 1);
}

}  // namespace

void appendJoined(const FrameSetup& setup, std::span<const ChannelBox> boxes,
                  std::vector<KernelBox>& out) {
  if (boxes.empty()) return;
  const bool are_near = std::ranges::all_of(boxes, [](const ChannelBox& each) {
    return each.chunk == nullptr || isNear(each.box, each.chunk->storage_vox);
  });
  Box3 hull = boxes.front().box.cells;
  for (const ChannelBox& each : boxes) hull = unite(hull, each.box.cells);
  int axis = 0;
  for (int a = 1; a < 3; ++a)
    if (hull.size()[a] > hull.size()[axis]) axis = a;
  if (!are_near && hull.size()[axis] >= 2) {
    const int64_t middle = (hull.lo[axis] + hull.hi[axis]) / 2;
    const bool lower_first = seesLowerFirst(setup, axis, middle);
    appendJoined(setup, partOf(boxes, axis, middle, lower_first), out);
    appendJoined(setup, partOf(boxes, axis, middle, !lower_first), out);
    return;
  }
  const size_t first = out.size();
  for (const ChannelBox& each : boxes) {
    const size_t before = out.size();
    appendPart(setup, each.box, each.chunk, each.leaps, out);
    // A box outside the picture has no part.
    if (out.size() > before) out.back().channel = each.box.channel;
  }
  if (out.size() > first) join(std::span(out).subspan(first));
}

void appendBox(const FrameSetup& setup, const BoxDraw& box, const ChunkTexels* chunk,
               const LeapGrid* leaps, std::vector<KernelBox>& out) {
  if (chunk == nullptr) {
    appendPart(setup, box, chunk, leaps, out);
    return;
  }
  int axis = 2;
  const auto& axes = box.texels.axes;
  // Along the axis of chunks' planes first, whose stride is the largest.
  while (axis > 0 && box.cells.size()[axes[static_cast<size_t>(axis)]] < 2) --axis;
  const int cut = axes[static_cast<size_t>(axis)];
  if (isNear(box, chunk->storage_vox) || box.cells.size()[cut] < 2) {
    appendPart(setup, box, chunk, leaps, out);
    return;
  }
  const int64_t middle = (box.cells.lo[cut] + box.cells.hi[cut]) / 2;
  BoxDraw lower = box, upper = box;
  lower.cells.hi[cut] = upper.cells.lo[cut] = middle;
  const bool lower_first = seesLowerFirst(setup, cut, middle);
  appendBox(setup, lower_first ? lower : upper, chunk, leaps, out);
  appendBox(setup, lower_first ? upper : lower, chunk, leaps, out);
}

}  // namespace sluice
