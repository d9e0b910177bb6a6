#include "src/library/opening/indexed_volume.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <span>
#include <utility>

#include "io/step_numbers.h"
#include "src/base/error.h"
#include "src/base/values/forwarding_source.h"
#include "src/base/values/level_kinds.h"
#include "src/base/values/read_units.h"
#include "src/base/values/volume_levels.h"
#include "src/library/drawing/resources.h"
#include "src/library/opening/coarsest_level.h"
#include "src/library/opening/side_levels.h"
#include "src/library/opening/thick_source.h"
#include "src/library/opening/volume_sample.h"
#include "src/render/blocks/level_cut.h"
#include "src/volume/byte_order_hint.h"

namespace sluice {
namespace {

// `side`: the levels to be made in the same pass; null: none.
IndexedRanges rangesOf(const IndexedVolume& volume, int64_t time, const IndexPass& pass,
                       const SideLevels* side) {
  const uint64_t bytes = pass.memory_bytes - (side == nullptr ? 0 : side->heldBytes());
  // The first opening reads everything, and nothing else is in memory then.
  volume.source->holdAtMost(bytes / 4);
  return indexedRanges(*volume.source, volume.places, time, volume.layout, pass.pool, pass.progress,
                       bytes, pass.stop, side == nullptr ? nullptr : side->taker());
}

// Statistics over all steps of a series, from their indices, which are made if missing. `index`
// belongs to the step that is drawn; its range is widened to the range of all steps.
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

std::vector<std::string> notesOf(const std::string& name, const VolumeLayout& layout,
                                 const IndexedRanges& index) {
  std::vector<std::string> notes = layout.notes;
  const ValueRange far = index.ranges.far_range;
  if (far.lo <= far.hi)
    notes.push_back(fmt::format(
        "{}: it has finite values from {:g} to {:g} that are drawn as infinities, since they are "
        "beyond {:g}",
        name, index.ranges.map.valueOf(far.lo), index.ranges.map.valueOf(far.hi), kLargest));
  if (looksByteSwapped(index.ranges, layout.type))
    notes.push_back(
        fmt::format("{}: its values look as if their bytes were read in the wrong order; give "
                    "--endian big or little for a raw file, or correct the header",
                    name));
  if (!index.note.empty()) notes.push_back(index.note);
  return notes;
}

// The needs in terms of the numbers that a volume stores.
IndexNeeds ofStored(IndexNeeds needs, const ValueMap& map) {
  if (map.scale > 0) return needs;
  if (needs.values == LevelValues::kMaxima)
    needs.values = LevelValues::kMinima;
  else if (needs.values == LevelValues::kMinima)
    needs.values = LevelValues::kMaxima;
  return needs;
}

// Whether pictures with these needs may be drawn from a file's own levels, of which not all writers
// say how they were made: then they are taken for means.
bool suit(std::span<const CoarserLevel> own, const IndexNeeds& needs) {
  return std::ranges::all_of(own, [&](const CoarserLevel& level) {
    return level.values == needs.values ||
           (level.values == LevelValues::kUnknown && needs.values == LevelValues::kMeans);
  });
}

// Levels beside the index are for pictures that may be drawn from them. Those that continue the
// levels of a file have no spreads, and the mode of modes is not that of the voxels.
LevelsWish wishFor(const VolumeSource& source, const IndexNeeds& needs, LevelsWish wish) {
  const std::span<const CoarserLevel> own = coarserLevels(source);
  if (needs.levels == LevelNeeds::kFinest) return LevelsWish::kNone;
  if (own.empty()) return wish;
  if (own.front().is_computed) return LevelsWish::kNone;
  if (!suit(own, needs)) return wish;
  return needs.levels == LevelNeeds::kAll && needs.values != LevelValues::kModes
             ? wish
             : LevelsWish::kNone;
}

// A volume without the levels that its readers see, which hold something else than pictures need:
// with others of its file, or none.
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

// The volume with those levels of its file that pictures need, if they are beside others.
std::unique_ptr<VolumeSource> withLevelsFor(std::unique_ptr<VolumeSource> source,
                                            const IndexNeeds& needs) {
  const std::span<const CoarserLevel> levels = levelsOfKind(*source, needs.values);
  if (levels.empty() || suit(coarserLevels(*source), needs)) return source;
  return std::make_unique<OtherLevels>(std::move(source), levels);
}

// The levels that these needs ask for.
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

// Whether a sample is asked for and may serve: of one step, for a cut through all levels.
bool maySample(const VolumeLayout& layout, const IndexNeeds& needs) {
  return needs.sample_seconds && needs.may_stand_in && needs.levels == LevelNeeds::kAll &&
         needs.values == LevelValues::kMeans && layout.time_steps == 1 &&
         isWorthSampling(layout, *needs.sample_seconds);
}

// Whether a volume is drawn at level 0 from an index that is there already, without further levels.
bool isKnown(const IndexedVolume& volume, const BlockLayout& layout) {
  return !isLarge(volume.source->layout()) &&
         keptRanges(*volume.source, volume.places, volume.time, layout);
}

// Makes the levels that continue those of the file, and the index of its coarsest one.
void passOverCoarsest(const IndexedVolume& volume, VolumeSource& coarsest, const SideLevels& side,
                      const IndexPass& pass) {
  const BlockLayout blocks =
      blockLayout(coarsest.layout().dims, volume.layout.size, volume.layout.ghost);
  volume.source->holdAtMost(pass.memory_bytes / 4);
  indexedRanges(coarsest, volume.places, volume.time, blocks, pass.pool, pass.progress,
                pass.memory_bytes - side.heldBytes(), pass.stop, side.taker());
}

// Opens the volume with a sample of its coarsest level as a further level.
void takeSample(IndexedVolume& volume, double seconds, const IndexPass& pass) {
  VolumeSource& coarsest = *coarsestLevel(*volume.source).source;
  if (readUnits(coarsest).is_one_stream && pass.announce)
    pass.announce(fmt::format(
        "{}: is one compressed stream, which cannot be read in parts: all of it is unpacked before "
        "the first picture",
        volume.name));
  volume.source->holdAtMost(pass.memory_bytes / 4);
  VolumeSample sample =
      sampleVolume({coarsest, volume.time, pass.pool, pass.memory_bytes, seconds, pass.stop});
  const size_t level = coarserLevels(*volume.source).size();
  volume.sample = {sample.part + (level == 0 ? "" : fmt::format(" of level {}", level)),
                   sample.voxels.size()};
  volume.source = withSample(std::move(volume.source), std::move(sample));
}

// Adds the levels up to the first that does not nest.
void addLevels(IndexedVolume& volume, std::span<const CoarserLevel> levels) {
  if (levels.empty()) return;
  PyramidLayout pyramid(volume.layout);
  for (const CoarserLevel& level : levels) {
    const ValueMap map = deviceMap(level.source->layout());
    const bool is_alike = level.source->layout().type == volume.source->layout().type &&
                          map.scale == volume.map.scale && map.offset == volume.map.offset;
    const bool has_spreads = level.spreads != nullptr;
    const std::string obstacle =
        is_alike ? pyramid.add(level.source->layout().dims, level.placement, has_spreads ? 2 : 1)
                 : std::string("its voxels are of another type or scale of values");
    if (!obstacle.empty()) {
      volume.notes.push_back(fmt::format("{}: levels from {} on are left out: {}", volume.name,
                                         pyramid.levels(), obstacle));
      break;
    }
    volume.coarser.emplace_back();
  }
  volume.pyramid = std::make_shared<const PyramidLayout>(std::move(pyramid));
}

std::shared_ptr<const IndexedRanges> indexOfLevel(const IndexedVolume& volume, int level,
                                                  int64_t time, const IndexPass& pass) {
  VolumeSource& source = *coarserLevels(*volume.source)[static_cast<size_t>(level) - 1].source;
  IndexPlaces places = volume.places;
  // A sample is never the same again.
  if (volume.sample && level == volume.pyramid->levels() - 1) places.disabled = true;
  return std::make_shared<const IndexedRanges>(
      indexedRanges(source, places, time, volume.pyramid->level(level).blocks, pass.pool,
                    pass.progress, pass.memory_bytes, pass.stop));
}

bool needsIndex(const CoarserLevel& level) {
  return !showsAsFinest(level.values, level.spreads != nullptr);
}

// Indices of the levels that need one, from `least` on.
void indexLevels(IndexedVolume& volume, int least, const IndexPass& pass) {
  const std::span<const CoarserLevel> levels = coarserLevels(*volume.source);
  for (int level = least; level <= static_cast<int>(volume.coarser.size()); ++level)
    if (needsIndex(levels[static_cast<size_t>(level) - 1]))
      volume.coarser[static_cast<size_t>(level) - 1] =
          indexOfLevel(volume, level, volume.time, pass);
}

// The stand-in's values for the finest level, of whose blocks only those are known that pictures
// have read. Indices are made of
// the stand-in and the levels above it; finer levels have theirs if they are there.
IndexedRanges standIn(IndexedVolume& volume, const IndexPass& pass) {
  const int number = volume.sample ? volume.pyramid->levels() - 1 : standInLevel(*volume.pyramid);
  indexLevels(volume, number, pass);
  const std::span<const CoarserLevel> levels = coarserLevels(*volume.source);
  for (int level = 1; level < number; ++level) {
    const auto i = static_cast<size_t>(level) - 1;
    if (!needsIndex(levels[i])) continue;
    auto kept = keptRanges(*levels[i].source, volume.places, volume.time,
                           volume.pyramid->level(level).blocks);
    if (kept) volume.coarser[i] = std::make_shared<const IndexedRanges>(*std::move(kept));
  }
  const auto at = static_cast<size_t>(number) - 1;
  StandIn stand_in{number, volume.coarser[at], {}};
  if (stand_in.index == nullptr) stand_in.index = indexOfLevel(volume, number, volume.time, pass);
  stand_in.device_range = stand_in.index->ranges.device_range;
  if (levels[at].spreads != nullptr)
    stand_in.device_range =
        rangeOfSpreads(levels[at], stand_in.device_range, volume.time, pass.pool, pass.stop);
  IndexedRanges index;
  auto learnt = keptLearnt(*volume.source, volume.places, volume.time, volume.layout);
  index.ranges =
      learnt ? *std::move(learnt) : unknownRanges(*volume.source, volume.time, volume.layout);
  index.ranges.device_range = stand_in.device_range;
  index.ranges.counts = stand_in.index->ranges.counts;
  index.state = "not made";
  volume.stand_in = std::move(stand_in);
  return index;
}

// The index of the step, with those of coarser levels: kept ones, a stand-in's, or made ones.
IndexedRanges indexOf(IndexedVolume& volume, const IndexNeeds& needs, const IndexPass& pass) {
  const std::span<const CoarserLevel> levels = coarserLevels(*volume.source);
  const bool one_step = volume.source->layout().time_steps == 1 || !needs.whole_series;
  const bool may_stand_in =
      needs.may_stand_in && one_step && !volume.coarser.empty() && !levels.front().is_computed;
  std::optional<IndexedRanges> index;
  if (may_stand_in) {
    index = keptRanges(*volume.source, volume.places, volume.time, volume.layout);
    if (!index) return standIn(volume, pass);
  }
  if (!index) index = rangesOfStep(volume, volume.time, pass);
  indexLevels(volume, 1, pass);
  return *std::move(index);
}

}  // namespace

TimeStep IndexedVolume::step() const {
  TimeStep step{source.get(), time, {index, &index->ranges}, pyramid, {}};
  const std::span<const CoarserLevel> levels = coarserLevels(*source);
  for (size_t i = 0; i < coarser.size(); ++i) {
    std::shared_ptr<const SliceRanges> ranges;
    if (coarser[i] != nullptr) ranges = {coarser[i], &coarser[i]->ranges};
    step.coarser.push_back(
        {levels[i].source, std::move(ranges), levels[i].spreads, levels[i].values});
  }
  return step;
}

int IndexedVolume::numbers() const {
  int most = 1;
  if (pyramid != nullptr)
    for (int level = 0; level < pyramid->levels(); ++level)
      most = std::max(most, pyramid->level(level).numbers);
  return most;
}

uint64_t IndexedVolume::rangesBytes() const {
  uint64_t bytes = index->bytes() + (sample ? sample->held_bytes : 0);
  if (stand_in && stand_in->index != coarser[static_cast<size_t>(stand_in->level) - 1])
    bytes += stand_in->index->bytes();
  for (const auto& level : coarser)
    if (level != nullptr) bytes += level->bytes();
  return bytes;
}

IndexNeeds needsOf(const LookArguments& look, Mode mode, const std::optional<CutOptions>& cut) {
  LevelNeeds levels = LevelNeeds::kFinest;
  // Surfaces are those of the finest level.
  const bool has_surfaces = !look.surfaces.empty() && traitsOf(mode).has_colors;
  if (cut && !has_surfaces) levels = cut->is_default ? LevelNeeds::kFaithful : LevelNeeds::kAll;
  return {needsGradients(look, mode),
          look.whole_series || (look.first_picture && needsStatistics(look) && !look.this_step),
          levels, levelValuesFor(mode, look.labels, 1)};
}

std::unique_ptr<VolumeSource> openSource(const VolumeArguments& arguments) {
  return checkedSource(openVolume(arguments.inputs, arguments.open), arguments);
}

std::unique_ptr<VolumeSource> checkedSource(std::unique_ptr<VolumeSource> opened,
                                            const VolumeArguments& arguments) {
  auto source = withThickness(std::move(opened));
  const int64_t steps = source->layout().time_steps;
  if (arguments.time >= 0 && arguments.time < steps) return source;
  const std::optional<int64_t> step = stepOfNumber(*source, arguments.time);
  const auto numbers = numbersOfSteps(*source);
  // Numbers that begin above 0 were meant by who asks for one beyond them.
  const bool beyond_numbers = numbers && numbers->front() > 0 && arguments.time > numbers->back();
  // A number that is a file's asks for no step beyond the last one.
  const auto missing = missingStep(*source, step ? *step : beyond_numbers ? steps : arguments.time);
  const std::string gap = missing ? "; " + *missing + " is missing" : "";
  constexpr const char* kCounted = "time steps are counted from 0, not by the files' numbers";
  if (step)
    fail("{}: --time {}: {}: the file of that number is step {} of {}; give --time {}{}",
         arguments.inputs.front(), arguments.time, kCounted, *step, steps, *step, gap);
  if (beyond_numbers)
    fail("{}: --time {}: {}: the last file has number {} and is step {} of {}{}",
         arguments.inputs.front(), arguments.time, kCounted, numbers->back(), steps - 1, steps,
         gap);
  fail("{}: --time {}: the volume has {} time step{}, counted from 0{}", arguments.inputs.front(),
       arguments.time, steps, steps == 1 ? "" : "s", gap);
}

IndexedVolume indexVolume(std::unique_ptr<VolumeSource> source, const VolumeArguments& arguments,
                          const MachineOptions& machine, const IndexNeeds& asked,
                          const IndexWish& wish, const IndexPass& pass) {
  IndexedVolume volume;
  const IndexNeeds needs = ofStored(asked, deviceMap(source->layout()));
  volume.source = withLevelsFor(std::move(source), needs);
  volume.needs = asked;
  volume.name = arguments.inputs.front();
  volume.places = indexPlaces(volume.name, wish);
  const VolumeLayout& layout = volume.source->layout();
  volume.map = deviceMap(layout);
  volume.page = pageShape(machine, volume.map);
  const int64_t block = machine.block.value_or(blockSizeFor(volume.page.size_vox));
  volume.time = arguments.time;
  const bool has_own = !coarserLevels(*volume.source).empty();
  const bool suits = suit(coarserLevels(*volume.source), needs);
  VolumeSource& coarsest = suits ? *coarsestLevel(*volume.source).source : *volume.source;
  LevelsWish wished = wishFor(*volume.source, needs, machine.levels);
  // A picture that must come soon does not wait for extremes, which nobody has asked for.
  const bool is_hurried = needs.sample_seconds && needs.levels == LevelNeeds::kFaithful;
  if (wished == LevelsWish::kAuto && is_hurried && needs.values != LevelValues::kMeans)
    wished = LevelsWish::kKept;
  const bool may_sample = wished != LevelsWish::kNone && maySample(coarsest.layout(), needs);
  SideLevels side({coarsest, has_own && suits, volume.name, volume.places, volume.time,
                   downsampleFor(needs.values),
                   may_sample ? std::max(wished, LevelsWish::kKept) : wished,
                   needs.levels == LevelNeeds::kAll || machine.levels == LevelsWish::kAlways,
                   pass.pool, pass.memory_bytes, pass.stop, pass.announce});
  const auto layoutOf = [&](int ghost) {
    if (block - 1 - 2 * ghost < 1)
      fail(
          "{}: blocks of {} voxels a side have no room for the border that a picture takes; give a "
          "larger --block",
          volume.name, block);
    return blockLayout(layout.dims, block, ghost, volume.name.c_str());
  };
  const int plain_ghost = needs.gradients ? 1 : 0;
  if (may_sample && !side.any() && (has_own || !isKnown(volume, layoutOf(plain_ghost))))
    takeSample(volume, *needs.sample_seconds, pass);
  // Several levels take a layer more (pyramid.h), and have the same blocks lit and unlit, so that
  // an index made ahead serves both: without one, nothing would be known of the finest level.
  const bool has_levels = side.any() || !levelsFor(*volume.source, needs).empty();
  volume.layout = layoutOf(has_levels ? 2 : plain_ghost);
  std::optional<IndexedRanges> made;
  if (side.taker() != nullptr) {
    try {
      if (has_own && suits)
        passOverCoarsest(volume, coarsest, side, pass);
      else
        made = rangesOf(volume, volume.time, pass, &side);
    } catch (const Error&) {
      side.discard();
      throw;
    }
    side.finish();
  }
  if (side.any() && !suits)
    volume.source =
        std::make_unique<OtherLevels>(std::move(volume.source), std::span<const CoarserLevel>());
  volume.source = side.join(std::move(volume.source));
  addLevels(volume, levelsFor(*volume.source, needs));
  volume.source->holdAtMost(pass.memory_bytes / 4);  // nothing else is in memory yet
  if (made) indexLevels(volume, 1, pass);
  IndexedRanges index = made ? *std::move(made) : indexOf(volume, needs, pass);
  std::ranges::copy(side.notes(), std::back_inserter(volume.notes));
  std::ranges::copy(notesOf(volume.name, layout, index), std::back_inserter(volume.notes));
  volume.values = statisticsOf(volume, index, needs.whole_series, pass);
  volume.index = std::make_shared<const IndexedRanges>(std::move(index));
  volume.page.pages = pageCount(machine, volume, volume.rangesBytes());
  return volume;
}

IndexedRanges rangesOfStep(const IndexedVolume& volume, int64_t time, const IndexPass& pass) {
  return rangesOf(volume, time, pass, nullptr);
}

std::string IndexedVolume::standInNote() const {
  if (!stand_in) return "";
  if (sample)
    return fmt::format(
        "{}: has no index yet; {} were read, evenly spread: the range of values, the look and the "
        "fit come from them, and the picture will improve with more time",
        name, sample->part);
  return fmt::format(
      "{}: level 0 has no index yet; the range of values, the look and the fit come from level {} "
      "and may differ a little from those of level 0",
      name, stand_in->level);
}

TimeStep stepOfSeries(const IndexedVolume& volume, int64_t time, const IndexPass& pass) {
  TimeStep step = volume.step();
  if (time == volume.time) return step;
  step.time = time;
  auto ranges = std::make_shared<SliceRanges>(rangesOfStep(volume, time, pass).ranges);
  ranges->device_range = volume.index->ranges.device_range;
  step.ranges = std::move(ranges);
  for (size_t i = 0; i < step.coarser.size(); ++i) {
    if (step.coarser[i].ranges == nullptr) continue;
    const auto index = indexOfLevel(volume, static_cast<int>(i) + 1, time, pass);
    step.coarser[i].ranges = {index, &index->ranges};
  }
  return step;
}

ValueRange IndexedVolume::finiteRange() const {
  const ValueRange far = index->ranges.far_range;
  if (far.lo > far.hi) return values.range;
  const ValueRange found{std::min(map.valueOf(far.lo), map.valueOf(far.hi)),
                         std::max(map.valueOf(far.lo), map.valueOf(far.hi))};
  if (values.counts.entries.empty()) return found;
  return {std::min(found.lo, values.range.lo), std::max(found.hi, values.range.hi)};
}

ChosenLook lookFor(const IndexedVolume& volume, const LookArguments& look, Mode mode) {
  return chooseLook(volume.source->layout(), volume.values, lookOfChannel(look, volume.channel),
                    mode);
}

}  // namespace sluice
