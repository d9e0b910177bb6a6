// VisibleValues: OpacityTable::anyOpaque for voxels of one device type, as the few intervals of
// values that it is true of, so that the scan over the min-max arrays compares voxels with voxels
// and looks nothing up.
//
// Immutable after construction; any thread may read.
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <limits>
#include <type_traits>
#include <vector>

#include "src/classify/transfer/opacity_table.h"

namespace sluice {

template <class T>
class VisibleValues {
 public:
  explicit VisibleValues(const OpacityTable& table) {
    const std::vector<float>& opacity = table.opacity();
    const int entries = table.entries();
    for (int entry = 0; entry < entries; ++entry) {
      if (!(opacity[static_cast<size_t>(entry)] > 0)) continue;
      // A run of opaque entries, and of those so near that their neighbours meet.
      int last = entry;
      for (int e = entry; e < entries && e <= last + 3; ++e)
        if (opacity[static_cast<size_t>(e)] > 0) last = e;
      const int64_t from = firstOfEntry(table, entry - 1), end = firstOfEntry(table, last + 2);
      if (from < kCount && end > 0) intervals_.push_back({nth(from), nth(end - 1)});
      entry = last;
    }
  }

  // table.anyOpaque(lo, hi). Requires: lo <= hi.
  bool any(T lo, T hi) const {
    if (intervals_.size() == 1) return lo <= intervals_[0].hi && hi >= intervals_[0].lo;
    const auto first =
        std::partition_point(intervals_.begin(), intervals_.end(),
                             [lo](const Interval& interval) { return interval.hi < lo; });
    return first != intervals_.end() && first->lo <= hi;
  }

  // True only if any() holds for every range inside lo to hi, since one interval contains them.
  // Requires: lo <= hi.
  bool allPartsOf(T lo, T hi) const {
    const auto first =
        std::partition_point(intervals_.begin(), intervals_.end(),
                             [hi](const Interval& interval) { return interval.hi < hi; });
    return first != intervals_.end() && first->lo <= lo;
  }

 private:
  // Ranges that reach up to `lo` and down to `hi` show. If the opaque entries lie between two
  // neighbouring integers, lo is the integer above them and hi the one below.
  struct Interval {
    T lo, hi;
  };

  // The finite values of T in ascending order are nth(0) to nth(kCount - 1).
  static constexpr int64_t kCount =
      std::is_integral_v<T> ? int64_t{1} << (8 * sizeof(T)) : int64_t{2} * 0x7f800000;
  static T nth(int64_t n) {
    static_assert(std::is_same_v<T, float> || std::is_unsigned_v<T>);
    if constexpr (std::is_integral_v<T>) {
      return static_cast<T>(n);
    } else {
      // Positive floats are in the order of their bits, negative ones in the reverse.
      const int64_t half = kCount / 2;
      return std::bit_cast<float>(n >= half ? static_cast<uint32_t>(n - half)
                                            : static_cast<uint32_t>(half - 1 - n) | 0x80000000U);
    }
  }
  // The first value whose entry is `entry` or above; kCount when there is none. Entries ascend with
  // the values, so it is found by halving, in agreement with the table to the last bit.
  static int64_t firstOfEntry(const OpacityTable& table, int entry) {
    int64_t lo = 0, hi = kCount;
    while (lo < hi) {
      const int64_t middle = (lo + hi) / 2;
      if (table.entryOf(static_cast<double>(nth(middle))) >= entry)
        hi = middle;
      else
        lo = middle + 1;
    }
    return lo;
  }

  std::vector<Interval> intervals_;  // both ends ascending
};

}  // namespace sluice
