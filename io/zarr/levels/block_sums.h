// BlockSums: what the voxels of a block add up to, and the mean and the spread that follow. The
// parts of LevelMaker (level_maker.h) share the rules of rounding here.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <type_traits>

namespace sluice {

// The voxels of a block added up so far. Sums of integers are exact: 2^32 times 2^18 voxels are
// below 2^53.
struct BlockSums {
  double value = 0;    // sum
  double squares = 0;  // of the values' distances from an origin
  uint32_t count = 0;  // of voxels that are numbers
};

// The type of the spreads of voxels of type T (volume_levels.h).
template <class T>
constexpr bool kIsNarrow = std::is_integral_v<T> && sizeof(T) <= 2;
template <class T>
using SpreadOf = typename std::conditional_t<kIsNarrow<T>, std::make_unsigned<T>,
                                             std::type_identity<float>>::type;

// The nearest whole number, ties to the even one, as std::nearbyint() without a call. Requires:
// less than half of the largest number without a fraction away from 0.
template <class Real>
Real rounded(Real value) {
  // Above it a number has no fraction.
  constexpr Real kUnitsAreLast = std::is_same_v<Real, float> ? Real{0x1.8p23F} : Real(0x1.8p52);
  return (value + kUnitsAreLast) - kUnitsAreLast;
}

// sum / count. Multiplying is faster and the same for powers of two, which most counts are.
inline double meanOf(double sum, uint32_t count) {
  const bool is_power_of_two = count != 0 && (count & (count - 1)) == 0;
  if (is_power_of_two) return sum * (1.0 / count);
  return sum / count;
}

// Twice the standard deviation. `origin`: what the squares are measured from, a value close to the
// others, so that little is cancelled.
template <class Spread>
Spread spreadOf(const BlockSums& block, double origin) {
  if (block.count == 0) return 0;
  const double mean = meanOf(block.value, block.count) - origin;
  const double variance = meanOf(block.squares, block.count) - mean * mean;
  const double spread = 2 * std::sqrt(std::max(0.0, variance));
  if constexpr (std::is_floating_point_v<Spread>)
    return std::isfinite(spread) ? static_cast<Spread>(spread) : Spread{0};
  else
    return static_cast<Spread>(rounded(spread));
}

// A block's value as a voxel, rounded once.
template <class T>
T voxelOf(double value, uint32_t count) {
  if constexpr (std::is_floating_point_v<T>) {
    if (count == 0) return std::numeric_limits<T>::quiet_NaN();
    return static_cast<T>(value);
  } else {
    return static_cast<T>(rounded(value));
  }
}

}  // namespace sluice
