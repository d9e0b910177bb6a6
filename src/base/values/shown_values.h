// ShownValues: which values show something under a transfer function, and the question that every
// acceleration asks: may a sample between two values show? There is one answer, so that a block
// called empty by one part of the program is empty for all of them.
//
// A transfer function is a table of entries at equal distances over a range of values; values
// beyond its ends look as the ends do. A sample takes the nearest entry or interpolates two, and
// rounding may move it by one more. So a value may show if its nearest entry or one beside it has
// an opacity. The entries for which that is true form a few intervals, which are kept in ascending
// order. Labels lie on their entries exactly, so an entry beside one that shows does not show.
//
// Zero is exact, too: interpolated between zeros it is zero in any arithmetic. If it is the lower
// end of the range, it shows only if its own entry does. A ramp that begins at the value of the
// background thus leaves the background out.
//
// Immutable after construction; any thread may read.
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <type_traits>
#include <vector>

#include "src/base/sources/volume_source.h"

namespace sluice {

class ShownValues {
 public:
  // The nearest entries of values that may show. `first` may be -1, and `last` the number of
  // entries: one beyond an end.
  struct Interval {
    int first, last;
    friend bool operator==(const Interval&, const Interval&) = default;
  };

  // Whether values of the entries beside one that shows may show, too: not those of labels.
  enum class Reach { kBeside, kItself };
  // `labels`: the values are labels, whole numbers. They reach no further if each lies on an entry.
  static Reach reachOf(bool labels, ValueRange range, int entries) {
    const double span = range.hi - range.lo;
    const bool on_entries = span >= 1 && std::floor(range.lo) == range.lo &&
                            std::floor(span) == span && std::fmod(entries - 1, span) == 0;
    return labels && on_entries ? Reach::kItself : Reach::kBeside;
  }

  // No value shows.
  ShownValues() = default;
  // `shows(i)`: entry i has an opacity. Entry i stands for range.lo + i * (range.hi - range.lo) /
  // (entries - 1). Requires: at least one entry.
  template <class Shows>
  ShownValues(ValueRange range, int entries, const Shows& shows, Reach reach = Reach::kBeside)
      : lo_(range.lo),
        entries_a_value_(range.hi > range.lo ? (entries - 1) / (range.hi - range.lo) : 0),
        entries_(entries) {
    const int beside = reach == Reach::kBeside ? 1 : 0;
    for (int entry = 0; entry < entries; ++entry) {
      if (!shows(entry)) continue;
      const int first = entry;
      while (entry + 1 < entries && shows(entry + 1)) ++entry;
      // Values below the first entry look as it does.
      add(first == 0 ? -1 : first - beside, entry + beside);
    }
  }

  // The nearest entry, clamped to the table.
  int entryOf(double value) const {
    const double at = (value - lo_) * entries_a_value_ + 0.5;
    if (!(at > 0)) return 0;
    return at >= entries_ ? entries_ - 1 : static_cast<int>(at);
  }
  // The same, but -1 for a zero at the lower end of the range and for what is below it, which looks
  // as the first entry does and not as the one beside it.
  int placeOf(double value) const { return lo_ == 0 && value <= 0 ? -1 : entryOf(value); }
  // False only if every sample from `lo` to `hi` has opacity 0, also one that single-precision
  // arithmetic moves to the next entry; and if lo > hi. O(log intervals).
  bool anyIn(double lo, double hi) const {
    return !(lo > hi) && anyEntryIn(placeOf(lo), placeOf(hi));
  }
  // The same for samples whose places are from `lo` to `hi`. Requires: lo <= hi.
  bool anyEntryIn(int lo, int hi) const {
    if (intervals_.size() == 1) return lo <= intervals_[0].last && hi >= intervals_[0].first;
    const auto found =
        std::partition_point(intervals_.begin(), intervals_.end(),
                             [lo](const Interval& interval) { return interval.last < lo; });
    return found != intervals_.end() && found->first <= hi;
  }
  // Ascending; no two touch.
  const std::vector<Interval>& intervals() const { return intervals_; }

  friend bool operator==(const ShownValues&, const ShownValues&) = default;

 private:
  // They come in ascending order.
  void add(int first, int last) {
    if (!intervals_.empty() && first <= intervals_.back().last + 1)
      intervals_.back().last = last;
    else
      intervals_.push_back({first, last});
  }

  double lo_ = 0, entries_a_value_ = 0;
  int entries_ = 1;
  std::vector<Interval> intervals_;
};

// ShownVoxels: ShownValues::anyIn() for voxels of one type, so that a scan over the min-max arrays
// compares voxels with voxels and looks nothing up. Immutable; any thread may read.
template <class T>
class ShownVoxels {
 public:
  // Ranges that reach up to `lo` and down to `hi` show. If the entries that show lie between two
  // neighbouring integers, lo is the integer above them and hi the one below.
  struct Interval {
    T lo, hi;
  };

  explicit ShownVoxels(const ShownValues& shown) {
    for (const auto [first, last] : shown.intervals()) {
      const int64_t from = firstOfEntry(shown, first), end = firstOfEntry(shown, last + 1);
      if (from < kCount && end > 0) intervals_.push_back({nth(from), nth(end - 1)});
    }
  }

  // ShownValues::anyIn(lo, hi). Requires: lo <= hi.
  bool any(T lo, T hi) const {
    if (intervals_.size() == 1) return lo <= intervals_[0].hi && hi >= intervals_[0].lo;
    const auto first =
        std::partition_point(intervals_.begin(), intervals_.end(),
                             [lo](const Interval& interval) { return interval.hi < lo; });
    return first != intervals_.end() && first->lo <= hi;
  }

  // Ascending at both ends. any(lo, hi) if one of them has lo <= its hi and hi >= its lo.
  const std::vector<Interval>& intervals() const { return intervals_; }

  // True only if any() holds for every range inside lo to hi, since one interval contains them.
  // Requires: lo <= hi.
  bool allPartsOf(T lo, T hi) const {
    const auto first =
        std::partition_point(intervals_.begin(), intervals_.end(),
                             [hi](const Interval& interval) { return interval.hi < hi; });
    return first != intervals_.end() && first->lo <= lo;
  }

 private:
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
  // The first value whose place is `entry` or above; kCount when there is none. Places ascend with
  // the values, so it is found by halving, in agreement with ShownValues to the last bit.
  static int64_t firstOfEntry(const ShownValues& shown, int entry) {
    int64_t lo = 0, hi = kCount;
    while (lo < hi) {
      const int64_t middle = (lo + hi) / 2;
      if (shown.placeOf(static_cast<double>(nth(middle))) >= entry)
        hi = middle;
      else
        lo = middle + 1;
    }
    return lo;
  }

  std::vector<Interval> intervals_;  // both ends ascending
};

}  // namespace sluice
