#include "src/visibility/extinction.h"

#include <array>
#include <bit>
#include <cmath>

namespace sluice {
namespace {

constexpr double kStepsAnOctave = 14;

float extinctionOf(float opacity) {
  if (opacity >= 1) return kMostExtinction;
  return std::min(kMostExtinction, -std::log1p(-std::max(opacity, 0.0F)));
}

// What of the opacity every gradient leaves.
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

}  // namespace

ExtinctionTable::ExtinctionTable(const OpacityTable& table)
    : table_(table), opacity_(table.opacity()) {
  levels_.emplace_back(opacity_.size());
  for (size_t i = 0; i < opacity_.size(); ++i)
    levels_[0][i] = extinctionOf(opacity_[i] * leastFactor(table, i));
  for (size_t span = 1; 2 * span <= opacity_.size(); span *= 2) {
    const std::vector<float>& last = levels_.back();
    std::vector<float> next(opacity_.size() - 2 * span + 1);
    for (size_t i = 0; i < next.size(); ++i) next[i] = std::min(last[i], last[i + span]);
    levels_.push_back(std::move(next));
  }
}

float ExtinctionTable::leastIn(double lo, double hi) const {
  if (lo < kLeastNumber) return 0;
  // One more on both sides, for what the device's arithmetic rounds: see OpacityTable::anyOpaque().
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
  if (!(extinction > 0)) return 0;
  const double at =
      255 + kStepsAnOctave * std::log2(static_cast<double>(extinction) / kMostExtinction);
  auto packed = static_cast<int>(std::clamp(std::floor(at + 1e-6), 0.0, 255.0));
  // Rounding may have gone a step too far either way.
  while (packed > 0 && unpackExtinction(static_cast<uint8_t>(packed)) > extinction) --packed;
  return static_cast<uint8_t>(packed);
}

float unpackExtinction(uint8_t packed) {
  static const std::array<float, 256> kValues = unpacked();
  return kValues[packed];
}

}  // namespace sluice
