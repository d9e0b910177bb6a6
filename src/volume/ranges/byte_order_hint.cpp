#include "src/volume/ranges/byte_order_hint.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "src/base/values/value_counts.h"

namespace sluice {
namespace {

using Shares = std::array<double, 16>;

// 4 bits if 16 classes are as frequent, less the more uneven they are.
double entropyBits(const Shares& counts) {
  double all = 0, bits = 0;
  for (const double count : counts) all += count;
  for (const double count : counts)
    if (count > 0) bits -= count / all * std::log2(count / all);
  return bits;
}

// Neighbours differ nearly everywhere, as if they were drawn from the whole range: noise does so,
// and a former lower byte. Labels differ as much, but seldom.
bool neighborsAreUnrelated(const ValueCounts& counts, double counted) {
  constexpr double kOften = 0.5, kFar = 0.2;  // two numbers drawn from a range differ by a third
  const ValueRange range = rangeOf(counts);
  const auto changes = static_cast<double>(counts.changes);
  return changes > kOften * counted &&
         static_cast<double>(counts.jumps) > kFar * changes * (range.hi - range.lo);
}

// Numbers of two parts: `unit` is the size of the lower one. The most frequent value, a background,
// tells nothing. Values over the whole of their type use both parts much alike; their neighbours
// tell.
bool partsAreSwapped(const ValueCounts& counts, const Histogram& histogram, double unit) {
  // Counted from a multiple of 16 units at or below the least value, so that phases are those of
  // the stored numbers.
  const double least = std::floor(histogram.range.lo / (16 * unit)) * 16 * unit;
  const auto background = std::max_element(histogram.counts.begin(), histogram.counts.end());
  Shares upper{}, lower{};
  double counted = 0;
  for (size_t bin = 0; bin < histogram.counts.size(); ++bin) {
    if (histogram.counts.begin() + static_cast<ptrdiff_t>(bin) == background) continue;
    const auto count = static_cast<double>(histogram.counts[bin]);
    const double value = binEdge(histogram, bin) + binWidth(histogram) / 2 - least;
    const double phase = std::fmod(value, unit) / unit;
    upper[std::min<size_t>(15, static_cast<size_t>(value / unit / 16))] += count;
    lower[std::min<size_t>(15, static_cast<size_t>(phase * 16))] += count;
    counted += count;
  }
  // An upper part with fewer than 3 of 4 bits is uneven, as in numbers that are read right.
  constexpr double kEnough = 1000, kEven = 3, kDifference = 1, kLeastDifference = 0.1;
  if (counted < kEnough || entropyBits(upper) < kEven) return false;
  const double difference = entropyBits(upper) - entropyBits(lower);
  return difference > kDifference ||
         (difference > kLeastDifference && neighborsAreUnrelated(counts, counted));
}

// 8-bit values in the upper halves of 16 bits: no voxel has anything in the lower one.
bool hasLowerHalves(const SliceRanges& ranges) {
  const auto totals = ranges.totalsAs<uint16_t>();
  return std::any_of(totals.begin(), totals.end(), [](const PlaneRange<uint16_t>& range) {
    return (range.lo & 0xffU) != 0 || (range.hi & 0xffU) != 0;
  });
}

bool floatsAreSwapped(const Histogram& histogram) {
  constexpr double kHuge = 1e25, kTiny = 1e-30;
  constexpr std::ptrdiff_t kMany = 64;
  const double largest = std::max(std::abs(histogram.range.lo), std::abs(histogram.range.hi));
  // Whole numbers have no lower bytes: swapped, they have no exponent.
  if (largest < kTiny) return histogram.range.lo < histogram.range.hi;
  // A single fill value far from the others does not come from misread exponents.
  return largest > kHuge && std::count_if(histogram.counts.begin(), histogram.counts.end(),
                                          [](uint64_t count) { return count > 0; }) > kMany;
}

}  // namespace

bool looksByteSwapped(const SliceRanges& ranges, VoxelType type) {
  constexpr double kUnitOf16 = 0x1p8, kUnitOf32 = 0x1p24;
  constexpr size_t kBins = 4096;
  const Histogram histogram = histogramOf(ranges.counts, kBins);
  if (histogram.counts.empty() || !(histogram.range.lo < histogram.range.hi)) return false;
  switch (type) {
    case VoxelType::kU8:
    case VoxelType::kI8:
      return false;
    case VoxelType::kU16:
    case VoxelType::kI16:
      return partsAreSwapped(ranges.counts, histogram, kUnitOf16) && hasLowerHalves(ranges);
    case VoxelType::kU32:
    case VoxelType::kI32:
      return partsAreSwapped(ranges.counts, histogram, kUnitOf32);
    case VoxelType::kF32:
    case VoxelType::kF64:
      break;
  }
  return floatsAreSwapped(histogram);
}

}  // namespace sluice
