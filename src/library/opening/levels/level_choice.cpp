#include "src/library/opening/levels/level_choice.h"

#include <algorithm>
#include <utility>

#include "src/base/sources/forwarding_source.h"
#include "src/base/sources/level_kinds.h"
#include "src/library/drawing/scene/chosen_look.h"
#include "src/library/opening/levels/coarsest_level.h"
#include "src/library/opening/levels/side_levels.h"
#include "src/library/opening/levels/volume_sample.h"
#include "src/render/blocks/cut/cut_rules.h"
#include "src/volume/block_layout.h"
#include "src/volume/pyramid.h"

namespace sluice {
namespace {

bool suit(std::span<const CoarserLevel> own, const IndexNeeds& needs) {
  return std::ranges::all_of(own, [&](const CoarserLevel& level) {
    return level.values == needs.values ||
           (level.values == LevelValues::kUnknown && needs.values == LevelValues::kMeans);
  });
}

// Levels beside the index are for pictures that may be drawn from them. Those that continue the
// levels of a file have no spreads, and the mode of modes is not that of the voxels.
LevelsWish wishBeside(std::span<const CoarserLevel> own, const IndexNeeds& needs, LevelsWish wish) {
  if (needs.levels == LevelNeeds::kFinest) return LevelsWish::kNone;
  if (own.empty()) return wish;
  if (own.front().is_computed) return LevelsWish::kNone;
  if (!suit(own, needs)) return wish;
  return needs.levels == LevelNeeds::kAll && needs.values != LevelValues::kModes
             ? wish
             : LevelsWish::kNone;
}

// Whether a sample is asked for and may serve: of one step, for a cut through all levels.
bool maySample(const VolumeLayout& layout, const IndexNeeds& needs) {
  return needs.sample_seconds && needs.may_stand_in && needs.levels == LevelNeeds::kAll &&
         needs.values == LevelValues::kMeans && layout.time_steps == 1 &&
         isWorthSampling(layout, *needs.sample_seconds);
}

// A volume with other levels than those that its reader shows.
class OtherLevels final : public ForwardingSource {
 public:
  OtherLevels(std::unique_ptr<VolumeSource> source, std::span<const CoarserLevel> levels)
      : ForwardingSource(std::move(source)), levels_(levels), layout_(ForwardingSource::layout()) {
    layout_.levels = 1 + static_cast<int64_t>(levels.size());
  }
  const VolumeLayout& layout() const override { return layout_; }
  std::span<const CoarserLevel> levelsAbove() const override { return levels_; }

 private:
  const std::span<const CoarserLevel> levels_;
  VolumeLayout layout_;  // constant after construction
};

}  // namespace

IndexNeeds needsOf(const LookArguments& look, Mode mode, const std::optional<CutOptions>& cut) {
  LevelNeeds levels = LevelNeeds::kFinest;
  const bool has_surfaces = !look.surfaces.empty() && traitsOf(mode).has_colors;
  if (cut && !showsFinestSurfaces(*cut, has_surfaces))
    levels = cut->is_default ? LevelNeeds::kFaithful : LevelNeeds::kAll;
  return {needsGradients(look, mode),
          look.whole_series || (look.first_picture && needsStatistics(look) && !look.this_step),
          levels, levelValuesFor(mode, look.labels, 1)};
}

IndexNeeds storedNeeds(IndexNeeds needs, const ValueMap& map) {
  // A negative slope turns the order of the stored values around, so the greatest values are the
  // least stored ones.
  if (map.scale > 0) return needs;
  if (needs.values == LevelValues::kMaxima)
    needs.values = LevelValues::kMinima;
  else if (needs.values == LevelValues::kMinima)
    needs.values = LevelValues::kMaxima;
  return needs;
}

IndexNeeds hurriedNeeds(IndexNeeds needs, const VolumeSource& source) {
  const std::span<const CoarserLevel> own = coarserLevels(source);
  if (!needs.opens_soon || needs.levels == LevelNeeds::kFinest || own.empty() ||
      own.front().is_computed || !suit(own, needs))
    return needs;
  // A small local volume is indexed about as soon as its coarse level would be.
  if (!isLarge(source.layout()) && source.distantReads() == 0) return needs;
  needs.levels = LevelNeeds::kAll;
  needs.may_stand_in = true;
  return needs;
}

IndexNeeds needsOfBlocks(int64_t block, IndexNeeds needs, LevelsWish wish) {
  const bool is_asked = needs.levels == LevelNeeds::kAll || wish == LevelsWish::kAlways;
  if (!hasRoom(block, kGhostOfLevels) && !is_asked) needs.levels = LevelNeeds::kFinest;
  return needs;
}

LevelChoice chooseLevels(VolumeSource& source, const IndexNeeds& needs, LevelsWish wish) {
  const std::span<const CoarserLevel> own = coarserLevels(source);
  LevelChoice choice{suit(own, needs), wishBeside(own, needs, wish), false};
  // A picture that must come soon does not wait for extremes, which nobody has asked for.
  const bool is_hurried = needs.sample_seconds && needs.levels == LevelNeeds::kFaithful;
  if (choice.beside == LevelsWish::kAuto && is_hurried && needs.values != LevelValues::kMeans)
    choice.beside = LevelsWish::kKept;
  const VolumeLayout& coarsest =
      choice.own_suit ? coarsestLevel(source).source->layout() : source.layout();
  choice.may_sample = choice.beside != LevelsWish::kNone && maySample(coarsest, needs);
  // Levels that are kept are better than a sample, which comes sooner than levels that are made.
  if (choice.may_sample) choice.beside = LevelsWish::kKept;
  return choice;
}

std::unique_ptr<VolumeSource> withLevelsFor(std::unique_ptr<VolumeSource> source,
                                            const IndexNeeds& needs) {
  const std::span<const CoarserLevel> levels = levelsOfKind(*source, needs.values);
  if (levels.empty() || suit(coarserLevels(*source), needs)) return source;
  return std::make_unique<OtherLevels>(std::move(source), levels);
}

std::unique_ptr<VolumeSource> withoutLevels(std::unique_ptr<VolumeSource> source) {
  return std::make_unique<OtherLevels>(std::move(source), std::span<const CoarserLevel>());
}

std::span<const CoarserLevel> levelsFor(const VolumeSource& source, const IndexNeeds& needs) {
  const std::span<const CoarserLevel> all = coarserLevels(source);
  if (needs.levels == LevelNeeds::kAll) return all;
  const auto isFaithful = [&](const CoarserLevel& level) {
    return level.values == needs.values && showsAsFinest(level.values, level.spreads != nullptr);
  };
  size_t count = 0;
  if (needs.levels == LevelNeeds::kFaithful)
    while (count < all.size() && isFaithful(all[count])) ++count;
  return all.first(count);
}

}  // namespace sluice
