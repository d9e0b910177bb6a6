// KeyHistogram: counts of device voxels whose range is not known yet.
//
// A voxel's key is its value for integers and the upper 16 bits of an order-preserving form of a
// float (sign, exponent and 7 bits of mantissa), so that one pass over a volume is enough; finish()
// spreads the keys over equal bins of the range found by then. Not shared between threads.
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <numeric>
#include <vector>

#include "src/base/histogram.h"
#include "src/volume/device_voxel.h"

namespace sluice {

template <class T>
class KeyHistogram {
 public:
  void add(const T* voxels, int64_t count) {
    for (int64_t i = 0; i < count; ++i) ++counts_[keyOf(voxels[i])];
  }
  void add(T value, uint64_t count) { counts_[keyOf(value)] += count; }
  void add(const KeyHistogram& other) {
    for (size_t i = 0; i < counts_.size(); ++i) counts_[i] += other.counts_[i];
  }
  uint64_t total() const { return std::accumulate(counts_.begin(), counts_.end(), uint64_t{0}); }
  // Device values, NaN and infinities left out. Integers of a range up to 4095 get one bin a value,
  // others 4096 bins. Requires: `range` holds every value added.
  void finish(ValueRange range, Histogram& out) const {
    const double span = range.hi - range.lo;
    size_t bins = 4096;
    if (sizeof(T) < 4 && span <= 4095) bins = static_cast<size_t>(span) + 1;
    out.range = range;
    out.counts.assign(bins, 0);
    for (size_t key = 0; key < counts_.size(); ++key) {
      if (counts_[key] == 0 || standsForNoNumber(static_cast<uint32_t>(key))) continue;
      const double value = valueOf(static_cast<uint32_t>(key));
      // A key's float stands for all that share its upper bits, so that it may lie past an end.
      const double share = span > 0 ? std::clamp((value - range.lo) / span, 0.0, 1.0) : 0;
      const double bin = share * static_cast<double>(bins);
      out.counts[bin >= static_cast<double>(bins) ? bins - 1 : static_cast<size_t>(bin)] +=
          counts_[key];
    }
  }

 private:
  static uint32_t keyOf(T v) {
    if constexpr (sizeof(T) < 4) {
      return v;
    } else {
      const auto bits = std::bit_cast<uint32_t>(v);
      return ((bits & 0x80000000U) != 0 ? ~bits : bits | 0x80000000U) >> 16;
    }
  }
  // NaN and infinities, as toDevice leaves them.
  static bool standsForNoNumber(uint32_t key) {
    if constexpr (sizeof(T) < 4) {
      return false;
    } else {
      return key == keyOf(kNotANumber) || key == keyOf(-kLargest) || key == keyOf(kLargest);
    }
  }
  static double valueOf(uint32_t key) {
    if constexpr (sizeof(T) < 4) {
      return key;
    } else {
      // The middle of the values that share the key; exact for zero.
      if (key == 0x8000) return 0;
      const uint32_t ordered = key << 16 | 0x8000;
      return std::bit_cast<float>((ordered & 0x80000000U) != 0 ? ordered & 0x7fffffffU : ~ordered);
    }
  }

  std::vector<uint64_t> counts_ = std::vector<uint64_t>(sizeof(T) == 1 ? 256 : 65536);
};

}  // namespace sluice
