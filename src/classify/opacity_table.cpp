#include "src/classify/opacity_table.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "src/base/error.h"

namespace sluice {
namespace {

// Neighbouring entries may differ by this much, of 1: half of what an 8-bit picture shows.
constexpr float kVisible = 0.5F / 255;
// A step is spread over twice as many entries.
constexpr ptrdiff_t kSpread = 3;

// For integers the entry count is chosen so that each value falls on an entry.
int entryCount(const ValueMap& map, double span, int most) {
  if (map.type == DeviceType::kF32 || span < 1 || span > most - 1) return most;
  return static_cast<int>(std::floor((most - 1) / span) * span) + 1;
}

}  // namespace

OpacityTable::OpacityTable(const TransferFunction& transfer, const ValueMap& map,
                           ValueRange device_range, int most_entries)
    : range_(device_range) {
  SLUICE_CHECK_LE(2, most_entries);
  const double span = range_.hi - range_.lo;
  const int count = entryCount(map, span, most_entries);
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
  constexpr ptrdiff_t kReach = kSpread - 1;
  // Each entry within reach of a step becomes the mean of those within reach of it: a ramp for one
  // step, and never 0 for what was visible, also where two steps are close together.
  ptrdiff_t done = 0;  // entries below are final
  for (ptrdiff_t step = 0; step < last; ++step) {
    const auto at = static_cast<size_t>(step);
    if (std::abs(sharp[at + 1] - sharp[at]) <= kVisible) continue;
    for (ptrdiff_t i = std::max(done, step + 1 - kReach); i <= std::min(last, step + kReach); ++i) {
      float sum = 0;
      for (ptrdiff_t k = i - kReach; k <= i + kReach; ++k)
        sum += sharp[static_cast<size_t>(std::clamp<ptrdiff_t>(k, 0, last))];
      opacity_[static_cast<size_t>(i)] = sum / static_cast<float>(2 * kReach + 1);
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
