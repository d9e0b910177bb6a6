#include "src/render/frame/pixel_rays.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <span>
#include <vector>

#include "src/base/error.h"
#include "src/render/camera/pixel_sizes.h"

namespace sluice {
namespace {

constexpr size_t kChannels = 4;
// With one ray a pixel, a bright voxel in 1024^3 zeros was in none of twelve pictures of 128 to 512
// pixels. Rays that are a third of a voxel apart meet it.
constexpr double kRaysAVoxel = 3;

// A pixel's opacity counts this much against the sum of its colours, which is at most three times
// the opacity: any ray that shows something wins over one that does not.
constexpr float kOpacityShare = 4;

// Opacity does not come first alone: between rays that are opaque but for rounding the colours
// decide.
float scoreOf(std::span<const float> pixel, KeptRay ray) {
  const float brightness = pixel[0] + pixel[1] + pixel[2];
  return kOpacityShare * pixel[3] + (ray == KeptRay::kBrightest ? brightness : -brightness);
}

bool isExtreme(Mode mode) {
  const Combining combining = traitsOf(mode).combining;
  return combining == Combining::kGreatest || combining == Combining::kLeast;
}

// The sums of the colours of entries that show, by value.
std::vector<float> brightnessOf(const LookUp& look_up) {
  std::vector<float> brightness;
  const std::span<const float> entries(look_up.rgba);
  for (size_t at = 0; at + kChannels <= entries.size(); at += kChannels)
    if (entries[at + 3] > 0) brightness.push_back(entries[at] + entries[at + 1] + entries[at + 2]);
  return brightness;
}

}  // namespace

std::optional<KeptRay> keptRay(const LookUp& look_up, Mode mode) {
  if (traitsOf(mode).has_colors)
    return look_up.labels ? KeptRay::kBrightest : KeptRay::kEachChannel;
  if (!isExtreme(mode) || traitsOf(mode).codes_depth) return std::nullopt;
  // The value that wins must be told from its colour, so that colours have to follow the values.
  const std::vector<float> brightness = brightnessOf(look_up);
  const bool is_greatest = traitsOf(mode).combining == Combining::kGreatest;
  if (std::ranges::is_sorted(brightness))
    return is_greatest ? KeptRay::kBrightest : KeptRay::kDarkest;
  if (std::ranges::is_sorted(brightness, std::ranges::greater()))
    return is_greatest ? KeptRay::kDarkest : KeptRay::kBrightest;
  return std::nullopt;
}

int raysASide(const TimeStep& step, const VisibleBlocks& visible, const View& view,
              const FrameOptions& options) {
  const bool keeps_thin = options.cut && options.cut->keeps_thin && visible.cut;
  // A picture with a time limit has no time for more rays.
  if (!keeps_thin || options.time_limit_s) return 1;
  const PyramidLayout pyramid = step.layout();
  const PixelSizes sizes(step.source->layout(), view);
  double least_pixels = 1;  // that a voxel is wide
  for (const ObjectBlock& block : visible.blocks) {
    if (block.name.level > 0 && !isExtreme(options.mode)) continue;
    const double pixels = sizes.of(pyramid.of(block.name), pyramid.regionOf(block.name));
    if (pixels > 0) least_pixels = std::min(least_pixels, pixels);
  }
  if (least_pixels >= 1) return 1;
  const double pixels = static_cast<double>(view.size.width) * view.size.height;
  // Bounded in all: a volume seen from far away would ask for ever more.
  const double most = std::max(1.0, std::floor(std::sqrt(kMostRays / pixels)));
  return static_cast<int>(std::min(std::ceil(kRaysAVoxel / least_pixels), most));
}

std::array<double, 2> shiftOfRay(int x, int y, int side) {
  const auto shiftOf = [side](int at) { return (at + 0.5) / side - 0.5; };
  return {shiftOf(x), shiftOf(y)};
}

void keepMost(Picture& kept, const Picture& more, KeptRay ray) {
  SLUICE_CHECK_EQ(kept.rgba.size(), more.rgba.size());
  SLUICE_CHECK_EQ(kept.depth.size(), more.depth.size());
  for (size_t i = 0; i < kept.rgba.size() / kChannels; ++i) {
    const auto of = std::span(kept.rgba).subspan(kChannels * i, kChannels);
    const auto with = std::span(more.rgba).subspan(kChannels * i, kChannels);
    if (ray == KeptRay::kEachChannel) {
      std::ranges::transform(of, with, of.begin(), [](float a, float b) { return std::max(a, b); });
      if (!kept.depth.empty()) kept.depth[i] = std::min(kept.depth[i], more.depth[i]);
    } else if (scoreOf(of, ray) < scoreOf(with, ray)) {
      std::ranges::copy(with, of.begin());
      if (!kept.depth.empty()) kept.depth[i] = more.depth[i];
    }
  }
}

}  // namespace sluice
