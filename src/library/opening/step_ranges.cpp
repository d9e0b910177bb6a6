#include "src/library/opening/step_ranges.h"

#include <algorithm>
#include <functional>
#include <utility>

#include "src/index/first_pass.h"
#include "src/library/drawing/scene/resources.h"
#include "src/library/opening/levels/side_levels.h"

namespace sluice {
namespace {

const CoarserLevel& levelAt(const IndexedVolume& volume, int level) {
  return coarserLevels(*volume.source)[static_cast<size_t>(level) - 1];
}

// The levels to be made in the pass over the voxels.
enum class MakesLevels { kNo, kYes };

// The budgets for the volume at all its levels, of which a pass is refused.
std::function<PassBudgets(const PassNeeds&)> budgetsOf(const IndexedVolume& volume, int64_t time,
                                                       const IndexPass& pass, MakesLevels makes) {
  return [&volume, time, &pass, makes](const PassNeeds& refused) {
    PassNeeds all = refused;
    const auto add = [&](const PassNeeds& level) {
      all.array_bytes += level.array_bytes;
      all.least_bytes = std::max(all.least_bytes, level.least_bytes);
    };
    if (!volume.coarser.empty()) {
      all.array_bytes = 0;
      // Levels finer than the stand-in are not read.
      if (volume.stand_in_level == 0) add(firstPassNeeds(*volume.source, time, volume.layout));
      for (int level = std::max(1, volume.stand_in_level);
           level <= static_cast<int>(volume.coarser.size()); ++level)
        add(firstPassNeeds(*levelAt(volume, level).source, time,
                           volume.pyramid->level(level).blocks));
    }
    // Coarser levels halve at least one axis each time.
    if (makes == MakesLevels::kYes) all.array_bytes *= 2;
    constexpr double kMost = 0x1p62;
    if (all.array_bytes >= kMost) return PassBudgets{all.least_bytes, 0};
    const bool has_levels = makes == MakesLevels::kYes || !volume.coarser.empty();
    return PassBudgets{all.least_bytes,
                       static_cast<double>(enoughToDraw(volume, pass, has_levels,
                                                        static_cast<uint64_t>(all.array_bytes)))};
  };
}

// `side`: the levels to be made in the same pass; null: none.
IndexedRanges passedRanges(const IndexedVolume& volume, int64_t time, const IndexPass& pass,
                           const SideLevels* side) {
  VolumePass within = pass;
  if (side != nullptr) within.memory_bytes -= side->heldBytes();
  within.budgets =
      budgetsOf(volume, time, pass, side == nullptr ? MakesLevels::kNo : MakesLevels::kYes);
  // The first opening reads everything, and nothing else is in memory then.
  volume.source->holdAtMost(
      std::min(within.memory_bytes / 4, volume.source->passReads().most_bytes));
  return indexedRanges(*volume.source, volume.places, time, volume.layout, within,
                       side == nullptr ? nullptr : side->taker());
}

bool needsIndex(const CoarserLevel& level) {
  return !showsAsFinest(level.values, level.spreads != nullptr);
}

std::shared_ptr<const IndexedRanges> indexOfLevel(const IndexedVolume& volume, int level,
                                                  int64_t time, const IndexPass& pass) {
  IndexPlaces places = volume.places;
  // A sample is never the same again.
  if (volume.sample && level == volume.pyramid->levels() - 1) places.disabled = true;
  VolumePass within = pass;
  within.budgets = budgetsOf(volume, time, pass, MakesLevels::kNo);
  return std::make_shared<const IndexedRanges>(indexedRanges(
      *levelAt(volume, level).source, places, time, volume.pyramid->level(level).blocks, within));
}

// The same if it is kept, without reading the level; otherwise null.
std::shared_ptr<const IndexedRanges> keptIndexOfLevel(const IndexedVolume& volume, int level,
                                                      int64_t time) {
  auto kept = keptRanges(*levelAt(volume, level).source, volume.places, time,
                         volume.pyramid->level(level).blocks);
  return kept ? std::make_shared<const IndexedRanges>(*std::move(kept)) : nullptr;
}

// The stand-in for the finest level of a step. Reads a coarse level, unless it is kept or is the
// volume's own, or unless an index of other blocks tells more.
StandIn standInOf(const IndexedVolume& volume, int64_t time, const IndexPass& pass) {
  if (auto kept = keptRangesOfAnyBlocks(*volume.source, volume.places, time)) {
    const ValueRange device_range = kept->ranges.device_range;
    return {0, std::make_shared<const IndexedRanges>(*std::move(kept)), device_range};
  }
  const int level = volume.stand_in_level;
  StandIn stand_in{level, nullptr, {}};
  if (time == volume.time) stand_in.index = volume.coarser[static_cast<size_t>(level) - 1];
  if (stand_in.index == nullptr) stand_in.index = indexOfLevel(volume, level, time, pass);
  stand_in.device_range = stand_in.index->ranges.device_range;
  const CoarserLevel& at = levelAt(volume, level);
  if (at.spreads != nullptr && at.values != LevelValues::kModes) {
    SpreadReach reach = reachOfSpreads(at, stand_in.device_range, stand_in.index->bricks.cells,
                                       time, pass.pool, pass.stop);
    stand_in.device_range = reach.range;
    stand_in.reach = std::make_shared<const ReachRanges>(std::move(reach.drawn));
  }
  return stand_in;
}

// The finest level with the values of what stands in. Only the blocks are known that pictures have
// read.
IndexedRanges unreadRanges(const IndexedVolume& volume, int64_t time, const StandIn& stand_in) {
  IndexedRanges index;
  auto learnt = keptLearnt(*volume.source, volume.places, time, volume.layout);
  // A level that shows what the finest one shows needs the listing at once.
  const std::span<const CoarserLevel> levels = coarserLevels(*volume.source);
  const auto shown = levels.first(volume.coarser.size());
  const Listing listing = std::ranges::all_of(shown, needsIndex) ? Listing::kLater : Listing::kNow;
  index.ranges =
      learnt ? *std::move(learnt) : unknownRanges(*volume.source, time, volume.layout, listing);
  index.ranges.device_range = stand_in.device_range;
  index.ranges.counts = stand_in.index->ranges.counts;
  if (stand_in.level == 0) index.ranges.far_range = stand_in.index->ranges.far_range;
  return index;
}

}  // namespace

StepValues valuesOfStep(const IndexedVolume& volume, int64_t time, const IndexPass& pass) {
  if (time == volume.time && volume.index != nullptr) return {volume.index, volume.stand_in};
  StepValues values;
  const auto keep = [](IndexedRanges ranges) {
    return std::make_shared<const IndexedRanges>(std::move(ranges));
  };
  if (volume.stand_in_level == 0) {
    values.index = keep(passedRanges(volume, time, pass, nullptr));
  } else if (auto kept = keptRanges(*volume.source, volume.places, time, volume.layout)) {
    values.index = keep(*std::move(kept));
  } else {
    values.stand_in = standInOf(volume, time, pass);
    values.index = keep(unreadRanges(volume, time, *values.stand_in));
  }
  return values;
}

IndexedRanges rangesOfStep(const IndexedVolume& volume, int64_t time, const IndexPass& pass) {
  if (volume.stand_in_level == 0) return passedRanges(volume, time, pass, nullptr);
  return *valuesOfStep(volume, time, pass).index;
}

TimeStep stepOfSeries(const IndexedVolume& volume, int64_t time, const IndexPass& pass) {
  TimeStep step = volume.step();
  // A volume over a series may have one step, which all pictures show.
  if (time == volume.time || volume.source->layout().time_steps == 1) return step;
  step.time = time;
  auto ranges = std::make_shared<SliceRanges>(rangesOfStep(volume, time, pass).ranges);
  // One range for the series: the look must not change from step to step.
  ranges->device_range = volume.index->ranges.device_range;
  step.ranges = std::move(ranges);
  for (size_t i = 0; i < step.coarser.size(); ++i) {
    auto& ranges = step.coarser[i].ranges;
    if (ranges == nullptr) continue;
    const int level = static_cast<int>(i) + 1;
    // A level finer than the stand-in is not read for its index, which is used if it was kept.
    const auto index = level < volume.stand_in_level ? keptIndexOfLevel(volume, level, time)
                                                     : indexOfLevel(volume, level, time, pass);
    ranges = nullptr;
    if (index != nullptr) ranges = {index, &index->ranges};
  }
  return step;
}

bool isKnown(const IndexedVolume& volume, const BlockLayout& layout) {
  return !isLarge(volume.source->layout()) &&
         keptRanges(*volume.source, volume.places, volume.time, layout);
}

IndexedRanges passForLevels(const IndexedVolume& volume, const IndexPass& pass,
                            const SideLevels& side) {
  return passedRanges(volume, volume.time, pass, &side);
}

void passOverCoarsest(const IndexedVolume& volume, VolumeSource& coarsest, const SideLevels& side,
                      const IndexPass& pass) {
  const BlockLayout blocks =
      blockLayout(coarsest.layout().dims, volume.layout.size, volume.layout.ghost);
  volume.source->holdAtMost(pass.memory_bytes / 4);
  // The ranges are not needed here: the pass is for the levels that are made in it.
  VolumePass within = pass;
  within.memory_bytes -= side.heldBytes();
  within.budgets = budgetsOf(volume, volume.time, pass, MakesLevels::kYes);
  indexedRanges(coarsest, volume.places, volume.time, blocks, within, side.taker());
}

void indexLevels(IndexedVolume& volume, int least, const IndexPass& pass) {
  for (int level = 1; level <= static_cast<int>(volume.coarser.size()); ++level) {
    auto& index = volume.coarser[static_cast<size_t>(level) - 1];
    if (!needsIndex(levelAt(volume, level))) continue;
    index = level < least ? keptIndexOfLevel(volume, level, volume.time)
                          : indexOfLevel(volume, level, volume.time, pass);
  }
}

IndexedRanges indexStep(IndexedVolume& volume, const IndexNeeds& needs, const IndexPass& pass) {
  // A computed level has to read the finest one anyway.
  if (!needs.may_stand_in || volume.coarser.empty() || levelAt(volume, 1).is_computed) {
    IndexedRanges index = rangesOfStep(volume, volume.time, pass);
    indexLevels(volume, 1, pass);
    return index;
  }
  const int level = volume.sample ? volume.pyramid->levels() - 1 : standInLevel(*volume.pyramid);
  auto kept = keptRanges(*volume.source, volume.places, volume.time, volume.layout);
  const bool is_hurried = needs.sample_seconds || needs.opens_soon;
  if (!kept || is_hurried) volume.stand_in_level = level;
  indexLevels(volume, std::max(1, volume.stand_in_level), pass);
  if (kept) return *std::move(kept);
  volume.stand_in = standInOf(volume, volume.time, pass);
  return unreadRanges(volume, volume.time, *volume.stand_in);
}

ValueStatistics statisticsOf(const IndexedVolume& volume, IndexedRanges& index, bool whole_series,
                             const IndexPass& pass) {
  const auto valuesOf = [&](const SliceRanges& ranges) {
    return scaled(ranges.counts, volume.map.scale, volume.map.offset);
  };
  const auto widen = [](ValueRange& range, const ValueRange& by) {
    range = {std::min(range.lo, by.lo), std::max(range.hi, by.hi)};
  };
  ValueStatistics values{valuesOf(index.ranges), {}};
  // Tables and light follow from it too.
  ValueRange& device = index.ranges.device_range;
  const int64_t steps = whole_series ? volume.source->layout().time_steps : 0;
  for (int64_t time = 0; time < steps; ++time) {
    if (time == volume.time) continue;
    const IndexedRanges other = rangesOfStep(volume, time, pass);
    if (other.ranges.counts.entries.empty()) continue;
    widen(device, other.ranges.device_range);
    values.counts = merged(values.counts, valuesOf(other.ranges));
  }
  const double a = volume.map.valueOf(device.lo), b = volume.map.valueOf(device.hi);
  values.range = {std::min(a, b), std::max(a, b)};
  return values;
}

}  // namespace sluice
