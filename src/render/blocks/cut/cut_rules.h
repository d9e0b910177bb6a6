// Whether a picture is drawn from a cut through the levels of resolution (level_cut.h), and which
// levels it shows. Pure functions.
#pragma once

#include <optional>

#include "src/classify/transfer/transfer_function.h"
#include "src/render/blocks/time_step.h"
#include "src/render/blocks/visible_blocks.h"
#include "src/render/camera/cut_options.h"
#include "src/render/camera/frame_setup.h"

namespace sluice {

// The kind of values that coarser levels must hold for a picture of this mode, of values or labels.
// `value_scale`: the value of a stored number more; if it is negative, the greatest value has the
// least number, of which levels are made.
constexpr LevelValues levelValuesFor(Mode mode, bool has_labels, double value_scale) {
  if (has_labels) return LevelValues::kModes;
  if (traitsOf(mode).codes_depth && value_scale < 0) return LevelValues::kMinima;
  return traitsOf(deviceMode(mode, value_scale)).level_values;
}
// Whether such levels can show what the finest level shows, so that a picture may be drawn from
// them without being asked: not averages, nor labels along a ray.
constexpr bool suitDefaultCut(Mode mode, bool has_labels) {
  return traitsOf(mode).suits_levels && !(has_labels && !traitsOf(mode).has_colors);
}

// Whether surfaces are asked for at the finest level: as in a volume of one level.
constexpr bool showsFinestSurfaces(const CutOptions& cut, bool has_surfaces) {
  return has_surfaces && cut.level == 0;
}

// Whether a picture is drawn from a cut. False if no cut is set, if the step has one level, if the
// default cut would show something else than the finest level, or for showsFinestSurfaces(). Throws
// Error if a cut was asked for that cannot be drawn: of a level that is not there, from levels of
// something else than the picture shows, or of extremes that the look hides while it shows values
// next to them.
bool drawsCut(const TimeStep& step, const std::optional<CutOptions>& cut, Mode mode,
              const TransferFunction& transfer);
// The level that voxels `pixel_error` pixels wide require where the view needs the finest one, or
// the level that the options name. The distance between slices follows from it.
int finestLevelShown(const TimeStep& step, const View& view, const CutOptions& options);
// The coarsest level of the blocks that the picture shows.
int coarsestLevelShown(const TimeStep& step, const View& view, const VisibleBlocks& blocks);
// The finest level of the blocks of the whole picture; 0 if there are none.
int finestLevelDrawn(const VisibleBlocks& blocks);
// Whether shadows and occlusion are made from the finest level, as in a volume of one level: if it
// is drawn alone, uncropped and without a limit of time, and all of it takes no more than the
// blocks of a picture may. Else they come from a coarser level: reading a large volume whole would
// take longer than a picture of a part of it.
bool lightsFromFinest(const VisibleBlocks& blocks, const FrameOptions& options,
                      const VolumeLayout& layout);
// The finest spacing of a level's voxels in units of the volume's finest spacing.
double spacingOfLevel(const TimeStep& step, int level);

// Throws Error if the options name a level that is not there.
void requireLevel(const CutOptions& options, const TimeStep& step);

}  // namespace sluice
