// ValueCounts: how often each value occurs in a volume, every voxel counted once.
//
// Entries are single values if the type or the volume has few, otherwise short intervals. So fill
// values, however far off, take one entry and no resolution from the others. Counts of several time
// steps add up. Plain data; pure functions.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "src/base/values/histogram.h"

namespace sluice {

struct ValueCount {
  double lo = 0, hi = 0;  // lo == hi: this very value
  uint64_t count = 0;     // voxels in lo..hi, taken as spread evenly
  friend bool operator==(const ValueCount&, const ValueCount&) = default;
};

struct ValueCounts {
  std::vector<ValueCount> entries;  // ascending by lo, then hi; count > 0
  // Pairs of neighbours along x with different values, and the sum of their differences: labels
  // change seldom and by any amount, noise everywhere, smooth fields by little. Differences are
  // whole numbers, rounded down, before scaled(); each counts up to 2^32, the sum up to kMostJumps.
  uint64_t changes = 0, jumps = 0;
  friend bool operator==(const ValueCounts&, const ValueCounts&) = default;
};

inline constexpr uint64_t kMostJumps = uint64_t{1} << 62;
// Two sums of jumps together. Requires: neither is above kMostJumps.
inline uint64_t jumpsTogether(uint64_t a, uint64_t b) {
  return std::min(a + b, kMostJumps);
}

// At most this many entries come from one volume.
inline constexpr size_t kMostValueCounts = 4096;

// The number of voxels that all entries count.
uint64_t total(const ValueCounts& counts);
// From the least to the greatest value of all entries; 0, 0 if there are none.
ValueRange rangeOf(const ValueCounts& counts);
// Maps each value to value * `scale` + `offset`. Requires: scale is not 0.
ValueCounts scaled(ValueCounts counts, double scale, double offset);
// The counts of both together.
ValueCounts merged(const ValueCounts& a, const ValueCounts& b);
// The entries, or the parts of them, inside `range`.
ValueCounts inside(const ValueCounts& counts, ValueRange range);
// The counts in equal bins over rangeOf(counts). Requires: bins > 0.
Histogram histogramOf(const ValueCounts& counts, size_t bins);

}  // namespace sluice
