#include "src/render/blocks/look.h"

#include <algorithm>
#include <utility>

#include "src/render/camera/index_space.h"

namespace sluice {

LookUp lookUp(const OpacityTable& table, double finest_spacing) {
  LookUp result;
  result.device_range = table.deviceRange();
  result.volume_range = table.volumeRange();
  result.interpolates = table.mustInterpolate();
  result.rgba = table.rgba();
  for (const double magnitude : table.magnitudes())
    // The table has magnitudes per voxel length, devices have gradients per world unit.
    result.magnitudes.push_back(magnitude / finest_spacing);
  result.factors = table.factors();
  result.labels = table.labels();
  result.surfaces = table.surfaces();
  return result;
}

Look makeLook(const TimeStep& step, TransferFunction transfer, Mode mode) {
  if (!traitsOf(mode).has_colors) {
    transfer.gradients.clear();
    transfer.surfaces.clear();
  }
  OpacityTable table(transfer, step.ranges->map, step.ranges->device_range);
  LookUp look_up = lookUp(table, finestSpacing(step.source->layout()));
  // A spread beside anything but a mean is no distribution that the look could be expected over.
  const bool has_spreads = std::ranges::any_of(step.coarser, [](const CoarserStep& level) {
    return level.spreads != nullptr && level.valuesShown() == LevelValues::kMeans;
  });
  if (has_spreads && traitsOf(mode).has_colors && !table.labels())
    look_up.expected = std::make_shared<const ExpectedLook>(expectedLook(
        look_up, table.volumeRange(),
        step.ranges->map.type == DeviceType::kU8 ? TexelBytes::kOne : TexelBytes::kMore));
  return {std::move(transfer), std::move(table),
          std::make_shared<const LookUp>(std::move(look_up))};
}

}  // namespace sluice
