#include "src/visibility/plenoptic/extinction.h"

#include <array>
#include <bit>
#include <cmath>

namespace sluice {
namespace {

// 255 steps of a 14th of an octave reach from kMostExtinction down to 2^-18 of it, with 5 % from
// one to the next.
constexpr double kStepsAnOctave = 14;

float extinctionOf(float opacity) {
  if (opacity >= 1) return kMostExtinction;
  return std::min(kMostExtinction, -std::log1p(-std::max(opacity, 0.0F)));
}

// The share of the opacity that remains at any gradient.
float leastFactor(const OpacityTable& table, size_t entry) {
  const size_t rows = table.magnitudes().size();
  float least = 1;
  if (rows == 0) return least;
  const size_t per_row = table.factors().size() / rows;
  for (size_t r = 0; r < rows; ++r)
    least = std::min(least, table.factors()[r * per_row + (per_row > 1 ? entry : 0)]);
  return least;
}

std::array<float, 256> unpacked() {
  std::array<float, 256> values{};
  for (size_t i = 1; i < values.size(); ++i)
    values[i] = static_cast<float>(kMostExtinction *
                                   std::exp2((static_cast<double>(i) - 255) / kStepsAnOctave));
  return values;
}

// Finds the byte of an extinction by the first bits of its mantissa: a 64th of an octave holds at
// most one of the steps, which are a 14th apart.
class PackTable {
 public:
  PackTable() : values_(unpacked()), base_(bucketOf(values_[1])) {
    first_.resize(bucketOf(values_[255]) - base_ + 1);
    for (size_t bucket = 0; bucket < first_.size(); ++bucket) {
      const float begin =
          std::bit_cast<float>(static_cast<uint32_t>(bucket + base_) << kBucketShift);
      size_t packed = 0;
      while (packed < 255 && values_[packed + 1] <= begin) ++packed;
      first_[bucket] = static_cast<uint8_t>(packed);
    }
  }
  uint8_t pack(float extinction) const {
    if (!(extinction >= values_[1])) return 0;
    if (extinction >= values_[255]) return 255;
    const uint8_t packed = first_[bucketOf(extinction) - base_];
    return static_cast<uint8_t>(packed + (values_[packed + size_t{1}] <= extinction ? 1 : 0));
  }

 private:
  static constexpr uint32_t kBucketShift = 23 - 6;
  static size_t bucketOf(float value) { return std::bit_cast<uint32_t>(value) >> kBucketShift; }

  const std::array<float, 256> values_;
  const size_t base_;
  std::vector<uint8_t> first_;  // the byte of each bucket's first value
};

}  // namespace

ExtinctionTable::ExtinctionTable(const OpacityTable& table)
    : table_(table), opacity_(table.opacity()) {
  levels_.emplace_back(opacity_.size());
  for (size_t i = 0; i < opacity_.size(); ++i)
    // Without a gradient's factor the bound would exceed what samples have.
    levels_[0][i] = extinctionOf(opacity_[i] * leastFactor(table, i));
  // Minima of spans of 2^n entries, so that two of them cover any interval (a sparse table).
  for (size_t span = 1; 2 * span <= opacity_.size(); span *= 2) {
    const std::vector<float>& last = levels_.back();
    std::vector<float> next(opacity_.size() - 2 * span + 1);
    for (size_t i = 0; i < next.size(); ++i) next[i] = std::min(last[i], last[i + span]);
    levels_.push_back(std::move(next));
  }
  of_bytes_.resize(size_t{1} << 16U);
  for (size_t lo = 0; lo < 256; ++lo)
    for (size_t hi = lo; hi < 256; ++hi)
      of_bytes_[lo << 8U | hi] = leastIn(static_cast<double>(lo), static_cast<double>(hi));
}

float ExtinctionTable::leastIn(double lo, double hi) const {
  // One of the ends stands for NaN, beside which a sample may show nothing.
  if (lo < kLeastNumber) return 0;
  // An additional entry on both sides covers the rounding of the device's arithmetic; see
  // ShownValues.
  const int first = std::max(0, table_.entryOf(lo) - 1);
  const int last = std::min(table_.entries() - 1, table_.entryOf(hi) + 1);
  const int entries = last - first + 1;
  const auto count = static_cast<size_t>(entries);
  const auto level = static_cast<size_t>(std::bit_width(count) - 1);
  const std::vector<float>& least = levels_[level];
  return std::min(least[static_cast<size_t>(first)],
                  least[static_cast<size_t>(last + 1) - (size_t{1} << level)]);
}

uint8_t packExtinction(float extinction) {
  static const PackTable kTable;
  return kTable.pack(extinction);
}

float unpackExtinction(uint8_t packed) {
  static const std::array<float, 256> kValues = unpacked();
  return kValues[packed];
}

}  // namespace sluice
