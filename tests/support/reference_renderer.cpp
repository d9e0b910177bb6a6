#include "tests/support/reference_renderer.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <functional>
#include <limits>
#include <memory>
#include <thread>
#include <vector>

#include "src/base/error.h"
#include "tests/support/clipped_points.h"
#include "tests/support/reference_extinction.h"
#include "tests/support/reference_gradients.h"
#include "tests/support/reference_light.h"
#include "tests/support/reference_lighting.h"
#include "tests/support/reference_surfaces.h"
#include "tests/support/reference_values.h"

namespace sluice {
namespace {

// Faces belong to the volume if voxel planes are sampled, to this part of a voxel.
constexpr double kPlaneEdge = 1e-3;

// The most light that white reflects with the default lighting (src/device/lighting.h).
constexpr double kBrightestLit = 1.5;

// index = rows * (world - origin): the inverse of VolumeLayout's map, which may be oblique.
struct IndexFromWorld {
  std::array<Vec3d, 3> rows;
  Vec3d origin;

  explicit IndexFromWorld(const VolumeLayout& layout) : origin(layout.origin) {
    const std::array<Vec3d, 3> e = {layout.axes[0] * layout.spacing.x,
                                    layout.axes[1] * layout.spacing.y,
                                    layout.axes[2] * layout.spacing.z};
    const double determinant = dot(e[0], cross(e[1], e[2]));
    rows = {cross(e[1], e[2]) / determinant, cross(e[2], e[0]) / determinant,
            cross(e[0], e[1]) / determinant};
  }
  Vec3d operator()(Vec3d world) const {
    const Vec3d d = world - origin;
    return {dot(rows[0], d), dot(rows[1], d), dot(rows[2], d)};
  }
};

// The corners of the box through the outermost of these voxels.
std::vector<Vec3d> cornersOf(const VolumeLayout& layout, const Box3& voxels) {
  std::vector<Vec3d> corners;
  for (int corner = 0; corner < 8; ++corner) {
    Vec3d world = layout.origin;
    for (int a = 0; a < 3; ++a) {
      const int64_t voxel = (corner >> a & 1) != 0 ? voxels.hi[a] - 1 : voxels.lo[a];
      world = world + layout.axes[static_cast<size_t>(a)] *
                          (layout.spacing[a] * static_cast<double>(voxel));
    }
    corners.push_back(world);
  }
  return corners;
}

// The depths of the nearest of these points and of the farthest.
std::array<double, 2> depthsOf(const View& view, const std::vector<Vec3d>& points) {
  std::array<double, 2> depths{std::numeric_limits<double>::infinity(),
                               -std::numeric_limits<double>::infinity()};
  for (const Vec3d& world : points) {
    const double depth = dot(world - view.eye, view.forward);
    depths = {std::min(depths[0], depth), std::max(depths[1], depth)};
  }
  return depths;
}

class Renderer {
 public:
  Renderer(VolumeSource& source, const View& view, const ReferenceScene& scene)
      : layout_(source.layout()),
        view_(view),
        scene_(scene),
        values_(source, scene.time),
        gradients_(layout_, scene.transfer, values_),
        light_(layout_, view, scene, values_),
        index_from_world_(layout_),
        crop_(scene.crop ? intersect(*scene.crop, boxOf(layout_.dims)) : boxOf(layout_.dims)),
        finest_(std::min({layout_.spacing.x, layout_.spacing.y, layout_.spacing.z})),
        last_depth_(depthsOf(view, cornersOf(layout_, boxOf(layout_.dims)))[1]),
        depths_(shownDepths(view, scene)) {
    if (view.projection == Projection::kPerspective) depths_[0] = std::max(depths_[0], 0.0);
  }

  struct Pixel {
    Vec3d rgb;
    double opacity = 0, depth = 0;
    double doubt = 0;
  };

  Pixel pixel(int i, int j) const {
    const double u = 2 * (i + 0.5) / view_.size.width - 1;
    const double v = 1 - 2 * (j + 0.5) / view_.size.height;
    const double aspect = static_cast<double>(view_.size.width) / view_.size.height;
    const Vec3d aside =
        view_.right * (u * aspect * view_.half_height) + view_.up * (v * view_.half_height);
    const bool ortho = view_.projection == Projection::kOrtho;
    const Vec3d start = ortho ? view_.eye + aside : view_.eye;
    const Vec3d direction = ortho ? view_.forward : view_.forward + aside;
    const double farther = scene_.jitter > 0 ? scene_.jitter * scene_.jitterOf(i, j) : 0;
    if (scene_.integrates) return integrated(start, direction, farther);
    return scene_.mode == ReferenceMode::kComposite ? composite(start, direction, farther)
                                                    : project(start, direction);
  }

 private:
  struct Sample {
    Vec3d p;       // voxels
    double depth;  // world
    // Whether it counts, and whether rounding decides that: it lies next to a face.
    bool counts, near_face;
  };

  // The depths of what the crop and the clip planes leave, or of the points that show of it.
  std::array<double, 2> shownDepths(const View& view, const ReferenceScene& scene) const {
    const std::vector<Vec3d> whole = cornersOf(layout_, crop_);
    const std::vector<Vec3d> left = clippedPoints(whole, scene.clip_planes);
    const auto depths = depthsOf(view, left.empty() ? whole : left);
    if (scene.shown_points.empty()) return depths;
    const auto shown = depthsOf(view, scene.shown_points);
    return {std::max(depths[0], shown[0]), std::min(depths[1], shown[1])};
  }
  // The depth of the first slice, or of the first in front of a perspective eye inside the volume.
  double nearestDepth() const {
    if (view_.projection == Projection::kOrtho || view_.first_depth > 0)
      return -std::numeric_limits<double>::infinity();
    int64_t k = 0;
    while (view_.first_depth + (static_cast<double>(k) + 0.5) * view_.step <= 0) ++k;
    return view_.first_depth + (static_cast<double>(k) + 0.5) * view_.step;
  }

  // Calls sample(position, depth) at both ends of the ray's way through what is shown, grown by
  // `grown_vox`, and between them on the voxel planes of one axis.
  template <class F>
  void eachOnPlanes(Vec3d start, Vec3d direction, double grown_vox, F&& sample) const {
    const Vec3d from = index_from_world_(start);
    const Vec3d d = index_from_world_(start + direction) - from;
    double enter = nearestDepth(), leave = std::numeric_limits<double>::infinity();
    // A half-space of the shown part: depths with a + b * depth >= 0.
    const auto keep = [&](double a, double b) {
      if (b > 0)
        enter = std::max(enter, -a / b);
      else if (b < 0)
        leave = std::min(leave, -a / b);
      else if (a < 0)
        leave = -std::numeric_limits<double>::infinity();
    };
    int axis = 0;
    for (int a = 0; a < 3; ++a) {
      const double edge = kPlaneEdge + grown_vox;
      keep(from[a] - (static_cast<double>(crop_.lo[a]) - edge), d[a]);
      keep(static_cast<double>(crop_.hi[a] - 1) + edge - from[a], -d[a]);
      if (std::abs(d[a]) > (1 + 1e-4) * std::abs(d[axis])) axis = a;
    }
    for (const ReferenceClipPlane& plane : scene_.clip_planes)
      keep(plane.offset + grown_vox * finest_ * length(plane.normal) - dot(plane.normal, start),
           -dot(plane.normal, direction));
    if (enter > leave) return;
    sample(clampedTo(crop_, from + d * enter), enter);
    const auto parts = static_cast<int64_t>(std::ceil(finest_ / view_.step - 1e-6));
    const double a_voxel = static_cast<double>(std::max<int64_t>(1, parts));
    const auto count = static_cast<int64_t>(static_cast<double>(layout_.dims[axis] - 1) * a_voxel);
    for (int64_t i = 0; i <= count; ++i) {
      const double place = static_cast<double>(i) / a_voxel;
      const double depth = (place - from[axis]) / d[axis];
      if (depth < enter || depth > leave) continue;
      Vec3d p = from + d * depth;
      p[axis] = place;
      sample(clampedTo(crop_, p), depth);
    }
    sample(clampedTo(crop_, from + d * leave), leave);
  }

  // Calls sample(Sample) at the slices, each farther by so much of a slice, front to back, until it
  // returns false.
  template <class F>
  void eachSample(Vec3d start, Vec3d direction, double farther, F&& sample) const {
    const double near = scene_.rounding.face_vox;
    for (int64_t k = 0;; ++k) {
      const double place = static_cast<double>(k) + 0.5;
      const double depth = view_.first_depth + (place + farther) * view_.step;
      const double middle = view_.first_depth + place * view_.step;
      if (depth > last_depth_ + (1 + near) * view_.step) return;
      if (middle <= 0 && view_.projection == Projection::kPerspective) continue;
      const Vec3d world = start + direction * depth;
      const Vec3d p = index_from_world_(world);
      if (!counts(p, world, near)) continue;
      const bool inside = counts(p, world, 0);
      const bool near_face = near > 0 && !counts(p, world, -near);
      if (!sample(Sample{clampedTo(boxOf(layout_.dims), p), depth, inside, near_face})) return;
    }
  }

  // Whether p lies in the shown part, grown by `grown_vox` on all sides.
  bool counts(Vec3d p, Vec3d world, double grown_vox) const {
    for (int a = 0; a < 3; ++a)
      if (!(p[a] >= static_cast<double>(crop_.lo[a]) - grown_vox &&
            p[a] < static_cast<double>(crop_.hi[a] - 1) + grown_vox))
        return false;
    return std::all_of(scene_.clip_planes.begin(), scene_.clip_planes.end(),
                       [&](const auto& plane) {
                         return dot(plane.normal, world) <=
                                plane.offset + grown_vox * finest_ * length(plane.normal);
                       });
  }

  // The opacity of a sample of this length, for a gradient of `magnitude` value units a voxel
  // length.
  double opacity(double value, double magnitude, double voxel_lengths) const {
    const double whole =
        opacityAt(scene_.transfer, value) * gradientFactorAt(scene_.transfer, value, magnitude);
    return 1 - std::pow(1 - whole, voxel_lengths);
  }
  // The same with the premultiplied colour.
  std::array<double, 4> shown(double value, double magnitude, double voxel_lengths) const {
    const double a = opacity(value, magnitude, voxel_lengths);
    const Vec3d rgb = colorAt(scene_.transfer, value) * a;
    return {rgb.x, rgb.y, rgb.z, a};
  }

  // Whether a step of the list of points lies so near that rounding chooses its side.
  template <class Point>
  bool isNearStep(const std::vector<Point>& points, double value) const {
    const double reach = scene_.rounding.step_value;
    for (size_t i = 0; i + 1 < points.size(); ++i)
      if (points[i + 1].value - points[i].value <= 0.25 * reach &&
          points[i].value <= value + reach && points[i + 1].value >= value - reach)
        return reach > 0;
    return false;
  }
  bool isNearStep(double value) const {
    const auto& rows = scene_.transfer.gradients;
    return isNearStep(scene_.transfer.opacities, value) ||
           isNearStep(scene_.transfer.colors, value) ||
           std::any_of(rows.begin(), rows.end(),
                       [&](const GradientRow& row) { return isNearStep(row.factors, value); });
  }

  // By how much a channel of the sample may change if rounding moves it across a step.
  double doubtOf(double value, double magnitude, double voxel_lengths) const {
    if (!isNearStep(value)) return 0;
    const double reach = scene_.rounding.step_value;
    const auto here = shown(value, magnitude, voxel_lengths);
    double doubt = 0;
    for (const double beside : {value - reach, value + reach}) {
      const auto there = shown(beside, magnitude, voxel_lengths);
      for (size_t c = 0; c < 4; ++c) doubt = std::max(doubt, std::abs(there[c] - here[c]));
    }
    return doubt;
  }

  // A sample behind what the pixel has. `depth` holds the sum of weighted depths meanwhile.
  void blend(Pixel& out, const Sample& sample, Vec3d rgb, double a) const {
    add(out, litAt(sample.p, rgb), a, sample.depth);
  }
  void add(Pixel& out, Vec3d rgb, double a, double depth) const {
    const double weight = (1 - out.opacity) * a;
    const double place = std::clamp((depth - depths_[0]) / (depths_[1] - depths_[0]), 0.0, 1.0);
    out.rgb = out.rgb + rgb * (weight * (1 - scene_.depth_cueing * place));
    out.depth += weight * depth;
    out.opacity += weight;
  }
  Vec3d litAt(Vec3d p, Vec3d rgb) const {
    if (!scene_.lighting) return rgb;
    const Vec3d g = scene_.transfer.labels ? gradients_.ofLabels(p) : gradients_.at(p);
    return litReference(scene_, view_, flatReference(scene_, finest_), g, rgb, light_.at(p));
  }

  // The surfaces that the ray meets on the way for which the sample stands, and between them the
  // parts of what the sample shows.
  void blendSurfaces(Pixel& out, Vec3d start, Vec3d direction, const Sample& sample, Vec3d rgb,
                     double a) const {
    const Box3 all = boxOf(layout_.dims);
    const auto placeAt = [&](double part) {
      return clampedTo(
          all, index_from_world_(start + direction * (sample.depth + (part - 0.5) * view_.step)));
    };
    const double range = scene_.value_range.hi - scene_.value_range.lo;
    const ReferenceHits hits = surfaceHits(scene_.transfer.surfaces, range,
                                           [&](double part) { return values_.at(placeAt(part)); });
    out.doubt += (1 - out.opacity) * hits.doubt * kBrightestLit;
    if (a > 0) rgb = litAt(sample.p, rgb);
    double from = 0;
    for (const auto& [part, surface] : hits.hits) {
      add(out, rgb, 1 - std::pow(1 - a, part - from), sample.depth);
      Vec3d color = surface->rgb;
      if (scene_.lighting)
        color = litReference(scene_, view_, 0, gradients_.overCube(placeAt(part), surface->value),
                             color, light_.at(placeAt(part)));
      add(out, color, surface->opacity, sample.depth + (part - 0.5) * view_.step);
      from = part;
    }
    add(out, rgb, 1 - std::pow(1 - a, 1 - from), sample.depth);
  }

  Pixel composite(Vec3d start, Vec3d direction, double farther) const {
    const double voxel_lengths = view_.step * length(direction) / finest_;
    // Lit colours may be brighter than white.
    const double brightest = scene_.lighting ? kBrightestLit : 1;
    Pixel out;
    eachSample(start, direction, farther, [&](const Sample& sample) {
      const bool labels = scene_.transfer.labels;
      const ReferenceValues::Label label =
          labels ? values_.labelAt(sample.p) : ReferenceValues::Label{};
      const double value = labels ? label.value : values_.at(sample.p);
      const double magnitude =
          scene_.transfer.gradients.empty() ? 0 : length(gradients_.at(sample.p)) * finest_;
      const double a = opacity(value, magnitude, voxel_lengths);
      double doubt = sample.near_face ? a : doubtOf(value, magnitude, voxel_lengths);
      if (labels && label.lead < scene_.rounding.label_weight) doubt = 1;
      out.doubt += (1 - out.opacity) * doubt * brightest;
      if (sample.counts && !scene_.transfer.surfaces.empty())
        blendSurfaces(out, start, direction, sample, colorAt(scene_.transfer, value), a);
      else if (a > 0 && sample.counts)
        blend(out, sample, colorAt(scene_.transfer, value), a);
      return out.opacity < scene_.opacity_threshold;
    });
    if (out.opacity > 0) out.depth /= out.opacity;
    return out;
  }

  Pixel integrated(Vec3d start, Vec3d direction, double farther) const {
    const double voxel_lengths = view_.step * length(direction) / finest_;
    const double brightest = scene_.lighting ? kBrightestLit : 1;
    const auto valueAt = [&](double depth) {
      return values_.at(
          clampedTo(boxOf(layout_.dims), index_from_world_(start + direction * depth)));
    };
    Pixel out;
    eachSample(start, direction, farther, [&](const Sample& sample) {
      double front = valueAt(sample.depth - view_.step / 2);
      double back = valueAt(sample.depth + view_.step / 2);
      if (std::isnan(front)) front = back;
      if (std::isnan(back)) back = front;
      if (std::isnan(front)) return true;
      const auto mean = meanExtinction(scene_.transfer, front, back);
      const double magnitude =
          scene_.transfer.gradients.empty() ? 0 : length(gradients_.at(sample.p)) * finest_;
      const double whole = (1 - std::exp2(-mean[3])) *
                           gradientFactorAt(scene_.transfer, (front + back) / 2, magnitude);
      const double a = 1 - std::pow(1 - whole, voxel_lengths);
      if (sample.near_face) out.doubt += (1 - out.opacity) * a * brightest;
      if (a > 0 && sample.counts) blend(out, sample, Vec3d{mean[0], mean[1], mean[2]} / mean[3], a);
      return out.opacity < scene_.opacity_threshold;
    });
    if (out.opacity > 0) out.depth /= out.opacity;
    return out;
  }

  // The maximum, minimum or mean of some samples, or their attenuated maximum.
  struct Projected {
    double value = 0, depth = 0;
    double in_front = 0;  // sum of the places of the samples so far
    int64_t taken = 0;
    // `attenuation`: of a sample's length.
    void take(ReferenceMode mode, double v, double attenuation, double at_depth) {
      if (mode == ReferenceMode::kMaximumByDepth) {
        if (taken == 0 || v > value || (v == value && at_depth < depth)) depth = at_depth;
        value = taken == 0 ? v : std::max(value, v);
      } else if (mode == ReferenceMode::kAttenuatedMaximum) {
        value = std::max(value, v * std::exp(-attenuation * in_front));
        in_front += v;
      } else if (taken == 0)
        value = v;
      else if (mode == ReferenceMode::kMaximum)
        value = std::max(value, v);
      else if (mode == ReferenceMode::kMinimum)
        value = std::min(value, v);
      else
        value += v;
      ++taken;
    }
  };
  Pixel pixelOf(const Projected& projected) const {
    if (projected.taken == 0) return {};
    const bool mean = scene_.mode == ReferenceMode::kAverage;
    const double taken = mean ? static_cast<double>(projected.taken) : 1;
    double value = projected.value / taken;
    if (scene_.mode == ReferenceMode::kMaximumByDepth) {
      const auto [near, far] = depths_;
      const double nearness = 1 - std::clamp((projected.depth - near) / (far - near), 0.0, 1.0);
      const auto& colors = scene_.transfer.colors;
      return {
          colorAt(scene_.transfer, std::lerp(colors.front().value, colors.back().value, nearness)) *
              std::min(value / kPlaceSteps, 1.0),
          1, 0};
    }
    if (scene_.mode == ReferenceMode::kAttenuatedMaximum) {
      const auto& colors = scene_.transfer.colors;
      value = std::lerp(colors.front().value, colors.back().value, value);
    }
    return {colorAt(scene_.transfer, value), 1, 0};
  }
  // The number by which values are compared: in the attenuated mode their place between the ends of
  // the colours, from 0 to 1.
  static constexpr double kPlaceSteps = 4094;
  double counted(double value) const {
    const auto& colors = scene_.transfer.colors;
    const double lo = colors.front().value, hi = colors.back().value;
    if (scene_.mode == ReferenceMode::kMaximumByDepth)
      return std::floor(std::clamp((value - lo) / (hi - lo), 0.0, 1.0) * kPlaceSteps + 0.618);
    if (scene_.mode != ReferenceMode::kAttenuatedMaximum) return value;
    return std::clamp((value - lo) / (hi - lo), 0.0, 1.0);
  }

  Pixel project(Vec3d start, Vec3d direction) const {
    // The result exactly; without the samples that rounding may leave out; with those that it may
    // add.
    Projected exact, least, most;
    std::vector<Projected> of_depths;  // kMaximumByDepth: each sample alone
    const double attenuation = scene_.attenuation * view_.step * length(direction) / finest_;
    const auto take = [&](Vec3d p, double depth, bool surely, bool exactly, bool perhaps) {
      const double value = values_.at(p);
      const double reach = scene_.rounding.end_value;
      const bool shows = opacityAt(scene_.transfer, value) > 0;
      const bool shows_below = opacityAt(scene_.transfer, value - reach) > 0;
      const bool shows_above = opacityAt(scene_.transfer, value + reach) > 0;
      const auto takeInto = [&](Projected& projected) {
        projected.take(scene_.mode, counted(value), attenuation, depth);
      };
      if (exactly && shows) takeInto(exact);
      if (scene_.mode == ReferenceMode::kMaximumByDepth && perhaps && shows)
        takeInto(of_depths.emplace_back());
      if (surely && shows && shows_below && shows_above) takeInto(least);
      if (perhaps && (shows || shows_below || shows_above)) takeInto(most);
    };
    if (scene_.mode == ReferenceMode::kAverage ||
        scene_.mode == ReferenceMode::kAttenuatedMaximum) {
      eachSample(start, direction, 0, [&](const Sample& sample) {
        take(sample.p, sample.depth, !sample.near_face, sample.counts, true);
        return true;
      });
    } else {
      const double near = scene_.rounding.face_vox;
      eachOnPlanes(start, direction, 0,
                   [&](Vec3d p, double depth) { take(p, depth, false, true, false); });
      eachOnPlanes(start, direction, -near,
                   [&](Vec3d p, double depth) { take(p, depth, true, false, false); });
      eachOnPlanes(start, direction, near,
                   [&](Vec3d p, double depth) { take(p, depth, false, false, true); });
    }
    Pixel out = pixelOf(exact);
    std::vector<Projected> others{least, most};
    // Samples that are almost the greatest: rounding may choose one of them.
    if (scene_.rounding.place_steps > 0)
      for (const Projected& sample : of_depths)
        if (sample.value >= exact.value - scene_.rounding.place_steps) others.push_back(sample);
    for (const Projected& other_samples : others) {
      const Pixel other = pixelOf(other_samples);
      out.doubt = std::max(out.doubt, std::abs(other.opacity - out.opacity));
      for (int c = 0; c < 3; ++c)
        out.doubt = std::max(out.doubt, std::abs(other.rgb[c] - out.rgb[c]));
    }
    return out;
  }

  const VolumeLayout& layout_;
  const View& view_;
  const ReferenceScene& scene_;
  const ReferenceValues values_;
  const ReferenceGradients gradients_;
  const ReferenceLight light_;
  const IndexFromWorld index_from_world_;
  const Box3 crop_;
  const double finest_;
  const double last_depth_;
  std::array<double, 2> depths_;  // of what is shown, the first in front of a perspective eye
};

}  // namespace

FloatPicture renderReference(VolumeSource& source, const View& view, const ReferenceScene& scene) {
  const Renderer renderer(source, view, scene);
  FloatPicture picture;
  picture.width = view.size.width;
  picture.height = view.size.height;
  const size_t pixels = static_cast<size_t>(picture.width) * static_cast<size_t>(picture.height);
  picture.rgba.resize(4 * pixels);
  picture.depth.resize(pixels);
  picture.doubt.resize(pixels);
  std::atomic<int> next_row{0};
  const auto work = [&] {
    for (int j = next_row++; j < picture.height; j = next_row++)
      for (int i = 0; i < picture.width; ++i) {
        const Renderer::Pixel pixel = renderer.pixel(i, j);
        const size_t at =
            static_cast<size_t>(j) * static_cast<size_t>(picture.width) + static_cast<size_t>(i);
        const Vec3d rgb = pixel.rgb;
        const std::array<double, 4> rgba = {rgb.x, rgb.y, rgb.z, pixel.opacity};
        for (size_t c = 0; c < 4; ++c) picture.rgba[4 * at + c] = static_cast<float>(rgba[c]);
        picture.depth[at] = static_cast<float>(pixel.depth);
        picture.doubt[at] = static_cast<float>(pixel.doubt);
      }
  };
  std::vector<std::jthread> threads;
  for (unsigned t = 1; t < std::max(1U, std::thread::hardware_concurrency()); ++t)
    threads.emplace_back(work);
  work();
  threads.clear();  // joins
  return picture;
}

}  // namespace sluice
