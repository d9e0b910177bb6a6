#include "src/classify/opacity_table.h"

#include <algorithm>
#include <cmath>

#include "src/base/error.h"

namespace sluice {
namespace {

// Neighbouring entries may differ by this much, of 1: half of what an 8-bit picture shows.
constexpr float kVisible = 0.5F / 255;
// A step is spread over twice as many entries.
constexpr size_t kSpread = 3;

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
  for (size_t i = 0; i + 1 < sharp.size(); ++i) {
    if (std::abs(sharp[i + 1] - sharp[i]) <= kVisible) continue;
    const size_t from = i + 1 > kSpread ? i + 1 - kSpread : 0;
    const size_t to = std::min(sharp.size() - 1, i + kSpread);
    for (size_t k = from + 1; k < to; ++k) {
      const auto share = static_cast<float>(k - from) / static_cast<float>(to - from);
      opacity_[k] = sharp[from] + share * (sharp[to] - sharp[from]);
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
