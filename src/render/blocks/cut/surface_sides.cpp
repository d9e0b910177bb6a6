#include "src/render/blocks/cut/surface_sides.h"

#include <utility>

#include "src/device/shading/look_up_texels.h"

namespace sluice {

std::vector<LookPtr> looksBesideSurfaces(const TimeStep& step, const Look& look) {
  std::vector<LookPtr> looks;
  const auto add = [&](TransferFunction transfer) {
    OpacityTable table(transfer, step.ranges->map, step.ranges->device_range);
    looks.push_back(std::make_shared<const Look>(
        Look{std::move(transfer), std::move(table), std::make_shared<const LookUp>()}));
  };
  // Opacity of its own may be thin, too, beside the surfaces.
  TransferFunction alone = look.transfer;
  alone.surfaces.clear();
  for (const IsoSurface& surface : look.transfer.surfaces)
    // Opaque below the value, or above it: a sheet or a gap is thin on one of its sides.
    for (const double below : {0.0, 1.0}) {
      TransferFunction side;
      side.colors = alone.colors;
      side.opacities = {{surface.value, below}, {surface.value, 1 - below}};
      add(std::move(side));
    }
  if (showsOpacities(*look.look_up)) add(std::move(alone));
  return looks;
}

}  // namespace sluice
