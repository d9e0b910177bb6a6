#include "src/base/values/histogram.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "src/base/error.h"

namespace sluice {

size_t binOf(ValueRange range, size_t bins, double value) {
  SLUICE_CHECK(bins > 0);
  if (value <= range.lo) return 0;
  if (value >= range.hi) return bins - 1;
  // Halves, because the width of the range may overflow.
  const double share = (value / 2 - range.lo / 2) / (range.hi / 2 - range.lo / 2);
  return std::min(bins - 1, static_cast<size_t>(share * static_cast<double>(bins)));
}

double binWidth(const Histogram& histogram) {
  const auto bins = static_cast<double>(histogram.counts.size());
  return bins == 0 ? 0 : histogram.range.hi / bins - histogram.range.lo / bins;
}

double binEdge(const Histogram& histogram, size_t bin) {
  if (histogram.counts.empty()) return histogram.range.lo;
  return std::lerp(histogram.range.lo, histogram.range.hi,
                   static_cast<double>(bin) / static_cast<double>(histogram.counts.size()));
}

uint64_t total(const Histogram& histogram) {
  return std::accumulate(histogram.counts.begin(), histogram.counts.end(), uint64_t{0});
}

double percentile(const Histogram& histogram, double share) {
  const uint64_t all = total(histogram);
  if (all == 0) return histogram.range.lo;
  const double wanted = std::clamp(share, 0.0, 1.0) * static_cast<double>(all);
  double below = 0;
  size_t last = 0;
  for (size_t i = 0; i < histogram.counts.size(); ++i) {
    const auto count = static_cast<double>(histogram.counts[i]);
    if (count == 0) continue;
    last = i;
    if (below + count >= wanted) {
      const double inside = (wanted - below) / count;
      return std::lerp(binEdge(histogram, i), binEdge(histogram, i + 1), inside);
    }
    below += count;
  }
  // Rounding may leave the sum a little below the wanted count.
  return binEdge(histogram, last + 1);
}

double shareAbove(const Histogram& histogram, double value) {
  const auto all = static_cast<double>(total(histogram));
  if (all == 0) return 0;
  double above = 0;
  for (size_t i = 0; i < histogram.counts.size(); ++i) {
    if (histogram.counts[i] == 0) continue;
    const double lo = binEdge(histogram, i), hi = binEdge(histogram, i + 1);
    const double part = value <= lo   ? 1
                        : value >= hi ? 0
                                      : (hi / 2 - value / 2) / (hi / 2 - lo / 2);
    above += part * static_cast<double>(histogram.counts[i]);
  }
  return above / all;
}

Histogram mirrored(const Histogram& histogram) {
  return {{-histogram.range.hi, -histogram.range.lo},
          {histogram.counts.rbegin(), histogram.counts.rend()}};
}

Histogram folded(const Histogram& histogram) {
  Histogram result{{0, std::max(std::abs(histogram.range.lo), std::abs(histogram.range.hi))},
                   std::vector<uint64_t>(histogram.counts.size(), 0)};
  for (size_t i = 0; i < histogram.counts.size(); ++i) {
    const double center = std::midpoint(binEdge(histogram, i), binEdge(histogram, i + 1));
    result.counts[binOf(result.range, result.counts.size(), std::abs(center))] +=
        histogram.counts[i];
  }
  return result;
}

}  // namespace sluice
