// Values of the public options that both the volume's and the picture's conversions take over and
// check. All throw Error, in one line that names the field.
#pragma once

#include <array>
#include <bit>
#include <cmath>
#include <cstdint>

#include "src/base/error.h"
#include "src/base/values/vec.h"
#include "src/library/requests.h"

namespace sluice {

// x, y and z of the interface's arrays as vectors, and back.
inline Vec3d vec(const std::array<double, 3>& v) {
  return {v[0], v[1], v[2]};
}
inline Vec3i vec(const std::array<int64_t, 3>& v) {
  return {v[0], v[1], v[2]};
}
template <class T>
std::array<T, 3> asArray(Vec3<T> v) {
  return {v.x, v.y, v.z};
}

// `field`: the option's name, which messages begin with. These throw Error (a request's).
inline void requireFinite(const char* field, double value) {
  if (!std::isfinite(value)) failRequest("{} {}: must be finite", field, value);
}

inline void requirePowerOfTwo(const char* field, int64_t value, int64_t least, int64_t most) {
  if (value < least || value > most || !std::has_single_bit(static_cast<uint64_t>(value)))
    failRequest("{} {}: must be a power of two from {} to {}", field, value, least, most);
}

// The number itself, from 0 (one a core) to kMostThreads. Throws Error.
inline int checkedThreads(int threads) {
  if (threads < 0 || threads > kMostThreads)
    failRequest("threads {}: must be 0, one a core, or up to {}", threads, kMostThreads);
  return threads;
}

}  // namespace sluice
