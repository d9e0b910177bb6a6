#include "tests/support/reference_renderer.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <thread>
#include <vector>

#include "tests/support/gradient_factor.h"
#include "tests/support/reference_extinction.h"
#include "tests/support/reference_gradients.h"
#include "tests/support/reference_light.h"
#include "tests/support/reference_lighting.h"
#include "tests/support/reference_rays.h"
#include "tests/support/reference_surfaces.h"
#include "tests/support/reference_values.h"

namespace sluice {
namespace {

// The most light that white reflects with the default lighting (src/device/shading/lighting.h).
constexpr double kBrightestLit = 1.5;

class Renderer {
 public:
  Renderer(VolumeSource& source, const View& view, const ReferenceScene& scene)
      : layout_(source.layout()),
        view_(view),
        scene_(scene),
        values_(source, scene.time),
        gradients_(layout_, scene.transfer, values_),
        light_(layout_, view, scene, values_),
        rays_(layout_, view, scene),
        finest_(rays_.finestSpacing()),
        depths_(rays_.shownDepths()) {}

  struct Pixel {
    Vec3d rgb;
    double opacity = 0, depth = 0;
    double doubt = 0;
  };

  Pixel pixel(int i, int j) const {
    const auto [start, direction] = rays_.through(i, j);
    const double farther = scene_.jitter > 0 ? scene_.jitter * scene_.jitterOf(i, j) : 0;
    if (scene_.integrates) return integrated(start, direction, farther);
    return scene_.mode == ReferenceMode::kComposite ? composite(start, direction, farther)
                                                    : project(start, direction);
  }

 private:
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
  void blend(Pixel& out, const ReferenceRays::Sample& sample, Vec3d rgb, double a) const {
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
  void blendSurfaces(Pixel& out, Vec3d start, Vec3d direction, const ReferenceRays::Sample& sample,
                     Vec3d rgb, double a) const {
    const Box3 all = boxOf(layout_.dims);
    const auto placeAt = [&](double part) {
      return clampedTo(
          all, rays_.indexOf(start + direction * (sample.depth + (part - 0.5) * view_.step)));
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
    rays_.eachSample(start, direction, farther, [&](const ReferenceRays::Sample& sample) {
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
      return values_.at(clampedTo(boxOf(layout_.dims), rays_.indexOf(start + direction * depth)));
    };
    Pixel out;
    rays_.eachSample(start, direction, farther, [&](const ReferenceRays::Sample& sample) {
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
      rays_.eachSample(start, direction, 0, [&](const ReferenceRays::Sample& sample) {
        take(sample.p, sample.depth, !sample.near_face, sample.counts, true);
        return true;
      });
    } else {
      const double near = scene_.rounding.face_vox;
      rays_.eachOnPlanes(start, direction, 0,
                         [&](Vec3d p, double depth) { take(p, depth, false, true, false); });
      rays_.eachOnPlanes(start, direction, -near,
                         [&](Vec3d p, double depth) { take(p, depth, true, false, false); });
      rays_.eachOnPlanes(start, direction, near,
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
  const ReferenceRays rays_;
  const double finest_;
  const std::array<double, 2> depths_;  // of what is shown
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
