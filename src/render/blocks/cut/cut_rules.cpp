#include "src/render/blocks/cut/cut_rules.h"

#include <algorithm>

#include "src/base/error.h"
#include "src/render/camera/index_space.h"
#include "src/render/camera/pixel_sizes.h"

namespace sluice {
namespace {

Vec3i finestCells(const PyramidLayout& pyramid) {
  return pyramid.finest().dims - Vec3i{1, 1, 1};
}

// The values that levels hold, and their word for `sluice pack --downsample`.
struct LevelWords {
  const char *hold, *option;
};
LevelWords wordsOf(LevelValues values) {
  switch (values) {
    case LevelValues::kMaxima:
      return {"maxima", "max"};
    case LevelValues::kMinima:
      return {"minima", "min"};
    case LevelValues::kModes:
      return {"labels", "mode"};
    case LevelValues::kMeans:
    case LevelValues::kUnknown:
      break;
  }
  return {"means", "mean"};
}

// Whether the extreme of several voxels shows if one of them does: for the greatest value, each
// value above one that shows. Other ways to combine samples look at no extreme.
bool showsExtremes(const TransferFunction& transfer, Combining combining) {
  std::vector<OpacityPoint> towards_extreme = transfer.opacities;
  if (combining == Combining::kLeast)
    std::ranges::reverse(towards_extreme);
  else if (combining != Combining::kGreatest)
    return true;
  // From the extreme end inwards, all values after the first that shows must show, too: otherwise a
  // maximum that is hidden would hide a value that shows.
  const auto isShown = [](const OpacityPoint& point) { return point.opacity > 0; };
  const auto first = std::ranges::find_if(towards_extreme, isShown);
  return std::all_of(first, towards_extreme.end(), isShown);
}

}  // namespace

void requireLevel(const CutOptions& options, const TimeStep& step) {
  const int levels = static_cast<int>(step.coarser.size()) + 1;
  if (options.level && *options.level >= levels)
    failRequest("{}: --level {}: there {} {} level{}, counted from 0",
                step.source->layout().calledBy(), *options.level, levels == 1 ? "is" : "are",
                levels, levels == 1 ? "" : "s");
}

bool drawsCut(const TimeStep& step, const std::optional<CutOptions>& cut, Mode mode,
              const TransferFunction& transfer) {
  const bool has_surfaces = !transfer.surfaces.empty() && traitsOf(mode).has_colors;
  if (!cut || showsFinestSurfaces(*cut, has_surfaces)) return false;
  const bool has_labels = transfer.labels;
  const bool shows_extremes = showsExtremes(transfer, traitsOf(mode).combining);
  const LevelValues wanted = levelValuesFor(mode, has_labels, step.ranges->map.scale);
  // The default is taken silently, so that it is used only if no picture changes by it.
  if (cut->is_default) {
    // The opening may have kept levels for another look: those of labels have shares, which are no
    // spreads. Levels of an unknown kind are means, and it has left out those that differ too much.
    const bool are_wanted = std::ranges::all_of(step.coarser, [&](const CoarserStep& level) {
      const LevelValues shown = level.valuesShown();
      return shown == wanted || (shown == LevelValues::kUnknown && wanted == LevelValues::kMeans);
    });
    return !step.coarser.empty() && suitDefaultCut(mode, has_labels) && are_wanted &&
           shows_extremes;
  }
  requireLevel(*cut, step);
  // Levels that were asked for are drawn, or refused with a reason.
  for (const CoarserStep& level : step.coarser) {
    const LevelValues found = level.valuesShown();
    if (found == LevelValues::kUnknown || found == wanted || cut->level.value_or(1) == 0) continue;
    failRequest(
        "{}: its coarser levels hold {}, which are no {}; leave out --level, --pixel-error and "
        "--max-bytes, or pack it with --downsample {}",
        step.source->layout().calledBy(), wordsOf(found).hold, wordsOf(wanted).hold,
        wordsOf(wanted).option);
  }
  if (!shows_extremes && !step.coarser.empty() && cut->level.value_or(1) > 0)
    failRequest(
        "{}: its coarser levels hold {}, and the look hides some of them where it shows other "
        "values; leave out --level, --pixel-error and --max-bytes, or make all {} values visible",
        step.source->layout().calledBy(), wordsOf(wanted).hold,
        traitsOf(mode).combining == Combining::kGreatest ? "greater" : "lesser");
  return !step.coarser.empty();
}

int finestLevelShown(const TimeStep& step, const View& view, const CutOptions& options) {
  requireLevel(options, step);
  if (options.level) return *options.level;
  const PyramidLayout pyramid = step.layout();
  const PixelSizes sizes(step.source->layout(), view);
  int level = 0;
  // The whole volume's voxels, at the place nearest to the eye.
  while (level < pyramid.levels() - 1 &&
         sizes.of(pyramid.level(level + 1), boxOf(finestCells(pyramid))) <= widestVoxel(options))
    ++level;
  return level;
}

int coarsestLevelShown(const TimeStep& step, const View& view, const VisibleBlocks& blocks) {
  const PyramidLayout pyramid = step.layout();
  const PixelSizes sizes(step.source->layout(), view);
  int coarsest = 0;
  for (const ObjectBlock& block : blocks.blocks)
    // Parts outside the picture stay coarse, whatever it shows.
    if (block.name.level > coarsest &&
        sizes.of(pyramid.of(block.name), pyramid.regionOf(block.name)) > 0)
      coarsest = block.name.level;
  return coarsest;
}

int finestLevelDrawn(const VisibleBlocks& blocks) {
  return blocks.cut && !blocks.cut->levels.empty() ? blocks.cut->levels.front().level : 0;
}

bool lightsFromFinest(const VisibleBlocks& blocks, const FrameOptions& options,
                      const VolumeLayout& layout) {
  if (!blocks.cut) return true;
  const bool is_alone =
      std::ranges::all_of(blocks.cut->levels, [](const auto& level) { return level.level == 0; });
  const CutOptions cut = options.cut.value_or(CutOptions{});
  // All bytes of the finest level, since the light is made of all of it.
  const uint64_t bytes = static_cast<uint64_t>(volume(layout.dims)) * bytesPerVoxel(layout.type);
  return is_alone && !options.crop && !options.time_limit_s &&
         bytes <= std::min(cut.most_stored_bytes, cut.most_held_bytes);
}

double spacingOfLevel(const TimeStep& step, int level) {
  const VolumeLayout& volume = step.source->layout();
  const Vec3d spacing = volume.spacing * step.layout().level(level).placement.scale;
  return std::min({spacing.x, spacing.y, spacing.z}) / finestSpacing(volume);
}

}  // namespace sluice
