#include "src/classify/opacity_table.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "src/base/error.h"

namespace sluice {
namespace {

// Neighbouring entries may differ by this much, of 1: half of what an 8-bit picture shows.
constexpr float kVisible = 0.5F / 255;
// Entries that a step is spread over at least, so that rounding changes little, and at most: where
// neighbours then differ by less than what is visible, samples need not interpolate.
constexpr int kLeastStepEntries = 4, kMostStepEntries = 8;

// The part of `all` over which the transfer function changes, where that is so small a part that it
// would get few entries: simulations write a value far off the data where they know nothing.
// Beyond it the ends hold.
ValueRange tableRange(const TransferFunction& transfer, const ValueMap& map, ValueRange all) {
  constexpr double kFewOfAll = 1.0 / 64, kMargin = 1.0 / 64;
  const double lo = std::min(transfer.colors.front().value, transfer.opacities.front().value);
  const double hi = std::max(transfer.colors.back().value, transfer.opacities.back().value);
  const auto [from, to] = std::minmax({map.deviceOf(lo), map.deviceOf(hi)});
  // Something on both sides of a lone step too.
  const double margin = std::max(kMargin * (to - from), 1e-3 * std::max(-from, to));
  ValueRange part{from - margin, to + margin};
  if (map.type != DeviceType::kF32) part = {std::floor(part.lo), std::ceil(part.hi)};
  part = {std::max(part.lo, all.lo), std::min(part.hi, all.hi)};
  const bool is_few = part.lo < part.hi && part.hi - part.lo < kFewOfAll * (all.hi - all.lo);
  return is_few ? part : all;
}

// Each integer falls on an entry, of floats that hold integers too.
int entryCount(ValueRange range, int most) {
  const double span = range.hi - range.lo;
  const bool has_integers = std::floor(range.lo) == range.lo && std::floor(span) == span;
  if (!has_integers || span < 1 || span > most - 1) return most;
  return static_cast<int>(std::floor((most - 1) / span) * span) + 1;
}

}  // namespace

OpacityTable::OpacityTable(const TransferFunction& transfer, const ValueMap& map,
                           ValueRange device_range, int most_entries)
    : range_(tableRange(transfer, map, device_range)), volume_range_(device_range) {
  SLUICE_CHECK_LE(2, most_entries);
  const double span = range_.hi - range_.lo;
  const int count = entryCount(range_, most_entries);
  entries_per_device_ = span > 0 ? (count - 1) / span : 0;
  const auto size = static_cast<size_t>(count);
  opacity_.resize(size);
  rgb_.resize(3 * size);
  opaque_before_.resize(size + 1);
  for (size_t i = 0; i < size; ++i) {
    const double device =
        count > 1 ? range_.lo + span * static_cast<double>(i) / (count - 1) : range_.lo;
    const double value = map.valueOf(device);
    const Vec3d color = colorAt(transfer, value);
    opacity_[i] = static_cast<float>(opacityAt(transfer, value));
    for (int channel = 0; channel < 3; ++channel)
      rgb_[3 * i + static_cast<size_t>(channel)] = static_cast<float>(color[channel]);
  }
  spreadSteps();
  must_interpolate_ = neighborsDiffer();
  for (size_t i = 0; i < size; ++i)
    opaque_before_[i + 1] = opaque_before_[i] + (opacity_[i] > 0 ? 1 : 0);
}

void OpacityTable::spreadSteps() {
  const std::vector<float> sharp = opacity_;
  const auto last = static_cast<ptrdiff_t>(sharp.size()) - 1;
  const auto stepAt = [&](ptrdiff_t i) {
    return std::abs(sharp[static_cast<size_t>(i) + 1] - sharp[static_cast<size_t>(i)]);
  };
  float largest = 0;
  for (ptrdiff_t i = 0; i < last; ++i) largest = std::max(largest, stepAt(i));
  // A part more than needed, for what colours and the slopes beside the step add.
  const auto parts = static_cast<int>(std::min(largest / kVisible, 1000.0F)) + 2;
  step_entries_ =
      parts - 1 <= kMostStepEntries ? std::max(parts - 1, kLeastStepEntries) : kLeastStepEntries;
  // Each entry from which a step is in sight becomes the mean of itself and the step_entries_ after
  // it: a ramp that ends where the step is, and never 0 for what was visible, also where two steps
  // are close together.
  ptrdiff_t done = 0;  // entries below are final
  for (ptrdiff_t step = 0; step < last; ++step) {
    if (stepAt(step) <= kVisible) continue;
    for (ptrdiff_t i = std::max(done, step + 1 - step_entries_); i <= step; ++i) {
      float sum = 0;
      for (ptrdiff_t k = i; k <= i + step_entries_; ++k)
        sum += sharp[static_cast<size_t>(std::min(k, last))];
      opacity_[static_cast<size_t>(i)] = sum / static_cast<float>(step_entries_ + 1);
      done = i + 1;
    }
  }
}

bool OpacityTable::neighborsDiffer() const {
  for (size_t i = 0; i + 1 < opacity_.size(); ++i) {
    if (std::abs(opacity_[i + 1] - opacity_[i]) > kVisible) return true;
    for (size_t c = 0; c < 3; ++c)
      if (std::abs(opacity_[i + 1] * rgb_[3 * i + 3 + c] - opacity_[i] * rgb_[3 * i + c]) >
          kVisible)
        return true;
  }
  return false;
}

}  // namespace sluice
