#include "src/library/opening/pass_forecast.h"

#include <algorithm>
#include <span>

#include "io/web/address.h"
#include "src/base/sources/volume_levels.h"
#include "src/library/drawing/cost/picture_cost.h"
#include "src/library/drawing/scene/resources.h"
#include "src/library/opening/levels/stand_in.h"
#include "src/volume/pyramid.h"

namespace sluice {
namespace {

// The levels that nest, of those that a picture with these needs may be drawn from.
PyramidLayout pyramidOf(const VolumeSource& source, const BlockLayout& finest,
                        const IndexNeeds& needs) {
  PyramidLayout pyramid(finest);
  for (const CoarserLevel& level : levelsFor(source, needs)) {
    const int numbers = level.spreads != nullptr ? 2 : 1;
    if (!pyramid.add(level.source->layout().dims, level.placement, numbers).empty()) break;
  }
  return pyramid;
}

}  // namespace

std::optional<PassForecast> passForecast(VolumeSource& source, const VolumeArguments& arguments,
                                         const MachineOptions& machine, const IndexNeeds& asked,
                                         const IndexWish& wish) {
  const VolumeLayout& layout = source.layout();
  const PageGeometry page = pageShape(machine, deviceMap(layout));
  const int64_t side = machine.block.value_or(blockSizeFor(page.size_vox));
  const IndexNeeds needs =
      needsOfBlocks(side, storedNeeds(asked, deviceMap(layout)), machine.levels);
  const int plain_ghost = needs.gradients ? 1 : 0;
  const bool has_levels = !levelsFor(source, needs).empty();
  // Opening refuses such blocks.
  if (!hasRoom(side, has_levels ? kGhostOfLevels : plain_ghost)) return std::nullopt;
  const int ghost = has_levels ? ghostOfLevels(layout.dims, side, levelsFor(source, needs)) : 0;
  PyramidLayout pyramid = pyramidOf(source, blockLayout(layout.dims, side, ghost), needs);
  if (pyramid.levels() == 1) pyramid = PyramidLayout(blockLayout(layout.dims, side, plain_ghost));
  const IndexPlaces places = indexPlaces(withoutSecrets(arguments.inputs.front()), wish);
  // There is an index, so no pass is made.
  if (keptRanges(source, places, arguments.time, pyramid.finest())) return std::nullopt;
  PassForecast forecast;
  const bool stands_in =
      needs.may_stand_in && pyramid.levels() > 1 && (layout.time_steps == 1 || !needs.whole_series);
  forecast.level = stands_in ? standInLevel(pyramid) : 0;
  forecast.is_all = !stands_in;
  bool is_known = false;
  for (int level = forecast.level; level < pyramid.levels(); ++level) {
    // Levels above show as the first one does, or need an index of their own.
    const CoarserLevel* const above =
        level > forecast.level ? &coarserLevels(source)[static_cast<size_t>(level) - 1] : nullptr;
    if (above != nullptr && showsAsFinest(above->values, above->spreads != nullptr)) continue;
    const auto reads = storedReadsOfLevel(source, arguments.time, level);
    is_known = is_known || reads.has_value();
    forecast.reads += reads.value_or(StoredReads());
  }
  return is_known ? std::optional(forecast) : std::nullopt;
}

}  // namespace sluice
