// InsideSet: the device values that lie inside a surface, those of at least the threshold. Plain
// values and pure functions.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "src/volume/voxels/device_voxel.h"

namespace sluice {

// The closed interval lo..hi of device voxels; lo > hi: none is inside. NaN (kNotANumber) never is.
// If the file's scale of values is negative, the values of at least the threshold are the small
// device values.
struct InsideSet {
  double lo = 0, hi = 0;
  double level = 0;  // the device value of the threshold itself

  bool empty() const { return lo > hi; }
  bool contains(double device) const { return device >= lo && device <= hi; }
};

enum class RangeState { kOutside, kInside, kMixed };

constexpr RangeState stateOf(const InsideSet& inside, double lo, double hi) {
  if (hi < inside.lo || lo > inside.hi) return RangeState::kOutside;
  return lo >= inside.lo && hi <= inside.hi ? RangeState::kInside : RangeState::kMixed;
}

inline InsideSet insideSet(const ValueMap& map, double threshold) {
  constexpr double kFar = std::numeric_limits<double>::infinity();
  const double level = map.deviceOf(threshold);
  InsideSet set{level, kFar, level};
  if (map.scale < 0) set = {-kFar, level, level};
  if (map.type == DeviceType::kF32) {
    constexpr double kNumbers = double{kNotANumber} / 2;
    set.lo = std::max(set.lo, kNumbers);
    return set;
  }
  // The threshold of a scaled value may miss the whole number that it stands for by a rounding.
  const double least = 1e-9 * std::max(1.0, std::abs(level));
  const double most = map.type == DeviceType::kU8 ? 255 : 65535;
  set.lo = std::max(0.0, std::ceil(set.lo - least));
  set.hi = std::min(most, std::floor(set.hi + least));
  return set;
}

}  // namespace sluice
