#include "src/classify/opacity_table.h"

#include <algorithm>
#include <cmath>

#include "src/base/error.h"

namespace sluice {
namespace {

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
    opaque_before_[i + 1] = opaque_before_[i] + (opacity_[i] > 0 ? 1 : 0);
  }
}

}  // namespace sluice
