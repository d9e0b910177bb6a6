// Arithmetic that gives the same bits on every machine: hashes, and a sine made of + and * alone,
// because the C library's differs from version to version in the last bit. The files that use it
// are compiled with -ffp-contract=off for the same reason.
#pragma once

#include <cstdint>

namespace sluice {

// A well-mixed 64-bit hash of one number.
constexpr uint64_t hash64(uint64_t x) {
  x += 0x9e3779b97f4a7c15ULL;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ULL;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebULL;
  return x ^ (x >> 31);
}
constexpr uint64_t hash64(uint64_t seed, int64_t x, int64_t y, int64_t z) {
  uint64_t h = hash64(seed ^ static_cast<uint64_t>(x));
  h = hash64(h ^ static_cast<uint64_t>(y));
  return hash64(h ^ static_cast<uint64_t>(z));
}
// 0 <= u < 1 from a hash.
constexpr double unitFrom(uint64_t hash) {
  return static_cast<double>(hash >> 11) * 0x1p-53;
}

// sin(2 pi turns), within 1e-11. Requires: |turns| < 2^31.
constexpr double sineOfTurns(double turns) {
  // Folds it into a quarter turn around the nearest extreme: s in [-1, 1], sin = +-sin(pi/2 s).
  double t = turns - static_cast<double>(static_cast<int64_t>(turns));  // -1 < t < 1
  if (t < 0) t += 1;
  double s = 4 * t;  // 0..4
  if (s > 3)
    s -= 4;
  else if (s > 1)
    s = 2 - s;
  const double s2 = s * s;
  // Taylor's series of sin(pi/2 s); the first term left out is below 1e-11.
  double sum = -6.688035109811464e-10;
  sum = 5.692172921967924e-08 + s2 * sum;
  sum = -3.598843235212084e-06 + s2 * sum;
  sum = 0.00016044118478735975 + s2 * sum;
  sum = -0.004681754135318687 + s2 * sum;
  sum = 0.07969262624616703 + s2 * sum;
  sum = -0.6459640975062462 + s2 * sum;
  sum = 1.5707963267948966 + s2 * sum;
  return s * sum;
}
constexpr double cosineOfTurns(double turns) {
  return sineOfTurns(turns + 0.25);
}

}  // namespace sluice
