// The number that a mode keeps of a sample if it colours the greatest value by its depth
// (ModeTraits::codes_depth): the sample's place in FrameSetup::window in whole steps, and below it
// how near the sample is. The greatest number belongs to the greatest place and, of those in one
// step, to the nearest sample, so that devices and parts of a picture need only the greatest of all
// numbers, in any order. All are whole and below 2^24, exact in single precision. Pure functions.
#pragma once

#include <algorithm>
#include <cmath>

#include "src/device/frame_values.h"

namespace sluice {

// Depths of a step.
inline constexpr int kDepthSteps = 4096;
// Places from 0 to 1 are in steps 0 to kPlaceSteps: floor(place * kPlaceSteps + kPlaceShift). The
// shift keeps simple fractions, which the values of flat parts often are, away from the ends of
// steps: there rounding would choose between two steps, and so between two depths.
inline constexpr int kPlaceSteps = 4094;
inline constexpr double kPlaceShift = 0.618;

// `depth`: from 0 at the nearest of FrameSetup::shown_depths to 1 at the farthest.
inline double depthCode(double place, double depth) {
  const double nearness = std::floor((1 - std::clamp(depth, 0.0, 1.0)) * (kDepthSteps - 1) + 0.5);
  return std::floor(place * kPlaceSteps + kPlaceShift) * kDepthSteps + nearness;
}
inline double placeOfCode(double code) {
  return std::min(std::floor(code / kDepthSteps) / kPlaceSteps, 1.0);
}
inline double depthOfCode(double code) {
  return 1 - std::fmod(code, kDepthSteps) / (kDepthSteps - 1);
}

// The colour of a depth, see FrameSetup::depth_colors.
inline Vec3d depthColor(const FrameSetup& setup, double depth) {
  const auto& colors = setup.depth_colors;
  const double at = depth * static_cast<double>(colors.size() - 1);
  const auto first = static_cast<size_t>(at);
  const Vec3d a = colors[first], b = colors[std::min(first + 1, colors.size() - 1)];
  return a + (b - a) * (at - std::floor(at));
}

// The row that takes an index position, with a 1 behind it, to its depth from 0 to 1.
inline std::array<double, 4> depthRow(const FrameSetup& setup) {
  const auto [lo, hi] = setup.shown_depths;
  const double scale = hi > lo ? 1 / (hi - lo) : 0;
  std::array<double, 4> row = setup.depth_from_index;
  row[3] -= lo;
  for (double& number : row) number *= scale;
  return row;
}

}  // namespace sluice
