// Histogram: how often each value occurs in a volume, in equal bins over a closed range of values.
//
// Plain data, filled by whoever passes over the voxels. A type of few values has one bin per
// integer value (u8: 256 over 0..255). Other types have 4096 bins or more, so that a few outliers
// leave enough bins to the rest.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "src/base/sources/volume_source.h"

namespace sluice {

struct Histogram {
  ValueRange range;              // lo <= hi, both finite
  std::vector<uint64_t> counts;  // bin i holds lo + width * [i, i + 1); the last one hi as well
};

// The bin of a value; values outside the range belong to the first or the last. Requires: bins > 0,
// value is not NaN.
size_t binOf(ValueRange range, size_t bins, double value);

// 0 for a range of one value.
double binWidth(const Histogram& histogram);

// The lower edge of a bin; binEdge(h, h.counts.size()) is range.hi.
double binEdge(const Histogram& histogram, size_t bin);

// The number of values that were counted.
uint64_t total(const Histogram& histogram);

// The value that `share` (0..1) of the counted values do not exceed, taken as spread evenly inside
// their bin. range.lo when nothing is counted. percentile(h, 0) is the lower edge of the first bin
// that holds something, percentile(h, 1) the upper edge of the last.
double percentile(const Histogram& histogram, double share);

// The share (0..1) of the counted values that are `value` or more.
double shareAbove(const Histogram& histogram, double value);

// The histograms of -value and of |value|.
Histogram mirrored(const Histogram& histogram);
Histogram folded(const Histogram& histogram);

}  // namespace sluice
