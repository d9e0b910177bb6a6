#include "src/base/values/value_counts.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "src/base/error.h"

namespace sluice {
namespace {

// Most entries of a long series: beyond these, neighbours are joined.
constexpr size_t kMostMerged = 4 * kMostValueCounts;

bool isBefore(const ValueCount& a, const ValueCount& b) {
  return std::pair(a.lo, a.hi) < std::pair(b.lo, b.hi);
}

void joinNeighbors(std::vector<ValueCount>& entries) {
  size_t kept = 0;
  for (size_t i = 0; i < entries.size(); i += 2) {
    ValueCount joined = entries[i];
    if (i + 1 < entries.size()) {
      joined.hi = std::max(joined.hi, entries[i + 1].hi);
      joined.count += entries[i + 1].count;
    }
    entries[kept++] = joined;
  }
  entries.resize(kept);
}

}  // namespace

uint64_t total(const ValueCounts& counts) {
  uint64_t sum = 0;
  for (const ValueCount& entry : counts.entries) sum += entry.count;
  return sum;
}

ValueRange rangeOf(const ValueCounts& counts) {
  if (counts.entries.empty()) return {};
  double hi = counts.entries.front().hi;
  for (const ValueCount& entry : counts.entries) hi = std::max(hi, entry.hi);
  return {counts.entries.front().lo, hi};
}

ValueCounts scaled(ValueCounts counts, double scale, double offset) {
  for (ValueCount& entry : counts.entries) {
    entry.lo = entry.lo * scale + offset;
    entry.hi = entry.hi * scale + offset;
    if (scale < 0) std::swap(entry.lo, entry.hi);
  }
  // A negative scale turns the order round.
  if (scale < 0) std::sort(counts.entries.begin(), counts.entries.end(), isBefore);
  // Larger doubles do not fit into the whole number.
  constexpr double kMost = 1e18;
  counts.jumps =
      static_cast<uint64_t>(std::min(kMost, static_cast<double>(counts.jumps) * std::abs(scale)));
  return counts;
}

ValueCounts merged(const ValueCounts& a, const ValueCounts& b) {
  std::vector<ValueCount> all(a.entries.size() + b.entries.size());
  std::merge(a.entries.begin(), a.entries.end(), b.entries.begin(), b.entries.end(), all.begin(),
             isBefore);
  ValueCounts result;
  for (const ValueCount& entry : all) {
    const bool again = !result.entries.empty() && result.entries.back().lo == entry.lo &&
                       result.entries.back().hi == entry.hi;
    if (again) {
      result.entries.back().count += entry.count;
    } else {
      result.entries.push_back(entry);
    }
  }
  // Pairs lose the exact values, so they are joined only if the list is too long.
  while (result.entries.size() > kMostMerged) joinNeighbors(result.entries);
  result.changes = a.changes + b.changes;
  result.jumps = jumpsTogether(a.jumps, b.jumps);
  return result;
}

ValueCounts inside(const ValueCounts& counts, ValueRange range) {
  ValueCounts result;
  for (ValueCount entry : counts.entries) {
    if (entry.hi < range.lo || entry.lo > range.hi) continue;
    const double lo = std::max(entry.lo, range.lo), hi = std::min(entry.hi, range.hi);
    if (entry.hi > entry.lo) {
      // Halves, because the width of a range may overflow.
      const double share = (hi / 2 - lo / 2) / (entry.hi / 2 - entry.lo / 2);
      entry.count = static_cast<uint64_t>(std::llround(share * static_cast<double>(entry.count)));
    }
    entry.lo = lo;
    entry.hi = hi;
    if (entry.count > 0) result.entries.push_back(entry);
  }
  result.changes = counts.changes;
  result.jumps = counts.jumps;
  return result;
}

Histogram histogramOf(const ValueCounts& counts, size_t bins) {
  SLUICE_CHECK(bins > 0);
  Histogram histogram{rangeOf(counts), std::vector<uint64_t>(bins, 0)};
  for (const ValueCount& entry : counts.entries) {
    const size_t first = binOf(histogram.range, bins, entry.lo);
    const size_t last = binOf(histogram.range, bins, entry.hi);
    // Bins hold whole voxels, and none is lost: each bin gets what the running sum has reached by
    // its end.
    uint64_t given = 0;
    for (size_t bin = first; bin <= last; ++bin) {
      const double end = bin == last ? entry.hi : binEdge(histogram, bin + 1);
      const double share =
          bin == last ? 1 : (end / 2 - entry.lo / 2) / (entry.hi / 2 - entry.lo / 2);
      const auto reached = std::min(
          entry.count,
          static_cast<uint64_t>(std::clamp(share, 0.0, 1.0) * static_cast<double>(entry.count)));
      const uint64_t part = (bin == last ? entry.count : std::max(reached, given)) - given;
      histogram.counts[bin] += part;
      given += part;
    }
  }
  return histogram;
}

}  // namespace sluice
