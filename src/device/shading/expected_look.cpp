#include "src/device/shading/expected_look.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "src/device/frame_values.h"

namespace sluice {
namespace {

// Entries and rows are close enough that the row of the least spread already smooths over them.
constexpr int kEntries = 512, kRows = 24;

using Rgba = std::array<double, 4>;

// Premultiplied entries of a look-up and their integral over device values.
class Integral {
 public:
  explicit Integral(const LookUp& look_up)
      : rgba_(look_up.rgba), count_(look_up.rgba.size() / 4), range_(look_up.device_range) {
    sums_.resize(count_ + 1);
    for (size_t i = 0; i < count_; ++i) {
      const Rgba entry = at(i);
      for (size_t c = 0; c < 4; ++c) sums_[i + 1][c] = sums_[i][c] + entry[c];
    }
  }

  // Mean of the entries of all values between the two.
  Rgba meanOf(double lo, double hi) const {
    const double from = placeOf(lo), to = placeOf(hi);
    constexpr double kSameEntry = 1e-6;
    // Sums that are so close differ by rounding alone: the entry itself is the mean.
    if (to - from < kSameEntry) return nearest(from);
    const Rgba before = sumTo(from), until = sumTo(to);
    Rgba mean{};
    for (size_t c = 0; c < 4; ++c) mean[c] = (until[c] - before[c]) / (to - from);
    return mean;
  }
  Rgba nearestTo(double value) const { return nearest(placeOf(value)); }

 private:
  Rgba at(size_t i) const {
    const std::span entry = rgba_.subspan(4 * i, 4);
    const double a = entry[3];
    return {entry[0] * a, entry[1] * a, entry[2] * a, a};
  }
  // Entry i has the places [i, i + 1); the ends of the table go on beyond it.
  double placeOf(double value) const {
    if (!(range_.hi > range_.lo)) return 0.5;
    return (value - range_.lo) / (range_.hi - range_.lo) * static_cast<double>(count_ - 1) + 0.5;
  }
  Rgba nearest(double place) const {
    return at(static_cast<size_t>(std::clamp(place, 0.0, static_cast<double>(count_) - 0.5)));
  }
  Rgba sumTo(double place) const {
    // The place may lie beyond the table, where the sum goes on with the first or the last entry.
    const double whole = std::floor(std::clamp(place, 0.0, static_cast<double>(count_ - 1)));
    const auto i = static_cast<size_t>(whole);
    const Rgba entry = at(i);
    Rgba sum = sums_[i];
    for (size_t c = 0; c < 4; ++c) sum[c] += (place - whole) * entry[c];
    return sum;
  }

  std::span<const float> rgba_;
  size_t count_;
  ValueRange range_;
  std::vector<Rgba> sums_;  // [i]: of the entries below i
};

Rgba expectedOf(const Integral& integral, const SpreadValues& values, ValueRange range) {
  const double mean = values.mean, reach = values.down + values.up;
  Rgba result{};
  const auto add = [&](double share, const Rgba& rgba) {
    for (size_t c = 0; c < 4; ++c) result[c] += share * rgba[c];
  };
  const double inner = 1 - values.at_ends;
  // The mean is kept if each part has the share of the other one's reach.
  const double below = reach > 0 ? values.up / reach : 0.5;
  add(inner * below, integral.meanOf(mean - values.down, mean));
  add(inner * (1 - below), integral.meanOf(mean, mean + values.up));
  if (values.at_ends > 0) {
    const double low = (range.hi - mean) / (range.hi - range.lo);
    add(values.at_ends * low, integral.nearestTo(range.lo));
    add(values.at_ends * (1 - low), integral.nearestTo(range.hi));
  }
  return result;
}

}  // namespace

SpreadValues spreadValues(double mean, double spread, ValueRange range) {
  const double half = (range.hi - range.lo) / 2, middle = range.lo + half;
  const double variance = std::min(0.25 * spread * spread, half * half);
  const double reach = std::sqrt(3 * variance);
  // The variance is at most (mean - lo) * (hi - mean), which values at the two ends have.
  const double aside = std::sqrt(half * half - variance);
  mean = std::clamp(mean, middle - aside, middle + aside);
  const double below = mean - range.lo, above = range.hi - mean;
  // Parts that reach `down` and `up` have the variance down * up / 3.
  SpreadValues values{mean, std::min(reach, below), std::min(reach, above), 0};
  if (values.down < reach)
    values.up = below > 0 ? std::min(3 * variance / below, above) : 0;
  else if (values.up < reach)
    values.down = above > 0 ? std::min(3 * variance / above, below) : 0;
  const double uniform = values.down * values.up / 3;
  // Values at the two ends alone have the variance below * above, three times the most of uniform
  // parts.
  if (variance > uniform * (1 + 1e-9) && uniform > 0)
    values.at_ends = std::min(1.0, (variance / uniform - 1) / 2);
  return values;
}

ValueRange spreadRange(double mean, double spread, ValueRange range) {
  const SpreadValues values = spreadValues(mean, spread, range);
  if (values.at_ends > 0) return range;
  return {values.mean - values.down, values.mean + values.up};
}

ValueRange shownRange(double mean, double spread, const ExpectedLook& expected) {
  const ValueRange all = expected.device_range;
  const double span = all.hi - all.lo;
  if (!(spread > 0) || !(span > 0)) return {mean, mean};
  // This is the upper one of the two rows that a sample is interpolated between: the reverse of row
  // r's spread in ExpectedLook.
  const double row = std::floor(std::sqrt(spread / span) * expected.rows) + 1;
  const double share = std::min(row / expected.rows, 1.0), entry = span / expected.entries;
  const ValueRange range = spreadRange(mean, span * share * share, all);
  // Samples are interpolated between entries, and one entry more is for rounding.
  return {std::min(mean, range.lo) - 2 * entry, std::max(mean, range.hi) + 2 * entry};
}

namespace {

std::vector<ByteRange> byteRanges(const ExpectedLook& look) {
  constexpr int kBytes = 256;
  const auto byteOf = [](double value) {
    return static_cast<uint8_t>(std::clamp(value, 0.0, double{kBytes - 1}));
  };
  std::vector<ByteRange> ranges;
  ranges.reserve(size_t{kBytes} * kBytes);
  for (int mean = 0; mean < kBytes; ++mean)
    for (int spread = 0; spread < kBytes; ++spread) {
      const ValueRange range = shownRange(mean, spread, look);
      // Shown values are rounded outwards, so that a byte that shows something is never left out.
      ranges.push_back({byteOf(std::floor(range.lo)), byteOf(std::ceil(range.hi))});
    }
  return ranges;
}

}  // namespace

ExpectedLook expectedLook(const LookUp& look_up, ValueRange device_range, TexelBytes texels) {
  const Integral integral(look_up);
  ExpectedLook look{device_range, kEntries, kRows, {}, {}};
  look.rgba.reserve(size_t{4} * kEntries * kRows);
  const double span = device_range.hi - device_range.lo;
  for (int row = 0; row < kRows; ++row) {
    const double share = (row + 1.0) / kRows, spread = span * share * share;
    for (int entry = 0; entry < kEntries; ++entry) {
      const double mean = device_range.lo + span * entry / (kEntries - 1);
      const SpreadValues values = spreadValues(mean, spread, device_range);
      for (const double channel : expectedOf(integral, values, device_range))
        look.rgba.push_back(static_cast<float>(channel));
    }
  }
  if (texels == TexelBytes::kOne) look.byte_ranges = byteRanges(look);
  return look;
}

}  // namespace sluice
