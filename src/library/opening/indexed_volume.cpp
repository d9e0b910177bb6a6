#include "src/library/opening/indexed_volume.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <span>
#include <utility>

#include "io/web/address.h"
#include "src/base/error.h"
#include "src/base/sources/read_units.h"
#include "src/base/sources/volume_levels.h"
#include "src/library/drawing/scene/resources.h"
#include "src/library/opening/channel_looks.h"
#include "src/library/opening/levels/coarsest_level.h"
#include "src/library/opening/levels/side_levels.h"
#include "src/library/opening/levels/volume_sample.h"
#include "src/library/opening/step_ranges.h"
#include "src/volume/ranges/byte_order_hint.h"

namespace sluice {
namespace {

// The distance between two neighbouring floats at the greatest value, if the volume has values that
// floats cannot tell apart as far as colours need it; else 0.
double lostBelow(const VolumeLayout& layout, const SliceRanges& ranges) {
  const bool is_whole = layout.type == VoxelType::kU32 || layout.type == VoxelType::kI32;
  // Integers of up to 16 bits and floats are kept as they are.
  if (!is_whole && layout.type != VoxelType::kF64) return 0;
  const ValueRange range = ranges.device_range;
  const auto most = static_cast<float>(std::max(std::abs(range.lo), std::abs(range.hi)));
  const double apart = double{std::nextafter(most, std::numeric_limits<float>::infinity())} - most;
  constexpr double kColors = 4096;
  return apart > (is_whole ? 1 : (range.hi - range.lo) / kColors) ? apart : 0;
}

// Whether all values are so small that floats have few digits left for them, or none.
bool isTiny(const ValueRange& device_range) {
  const double most = std::max(std::abs(device_range.lo), std::abs(device_range.hi));
  return most > 0 && most < double{std::numeric_limits<float>::min()};
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
  if (const double apart = lostBelow(layout, index.ranges); apart > 0)
    notes.push_back(fmt::format(
        "{}: its {} are drawn as floats, which are {:.3g} apart at its greatest value: values and "
        "labels that are closer look the same; subtract an offset to keep them apart",
        name, layout.type == VoxelType::kF64 ? "doubles" : "integers of 32 bits", apart));
  else if (index.ranges.map.type == DeviceType::kF32 && isTiny(index.ranges.device_range))
    notes.push_back(
        fmt::format("{}: its values are all closer to 0 than {:.2g}, which floats hold with few "
                    "digits: pictures may show nothing of them; multiply the values",
                    name, std::numeric_limits<float>::min()));
  if (looksByteSwapped(index.ranges, layout.type))
    notes.push_back(
        fmt::format("{}: its values look as if their bytes were read in the wrong order; give "
                    "--endian big or little for a raw file, or correct the header",
                    name));
  if (!index.note.empty()) notes.push_back(index.note);
  return notes;
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

// Notes if the levels are left out because the blocks have no room for them.
IndexNeeds needsWithin(int64_t block, const IndexNeeds& needs, LevelsWish wish,
                       IndexedVolume& volume) {
  const IndexNeeds within = needsOfBlocks(block, needs, wish);
  if (within.levels != needs.levels && !levelsFor(*volume.source, needs).empty())
    volume.notes.push_back(fmt::format(
        "{}: drawn from level 0 alone: blocks of {} voxels a side have no room for the border that "
        "several levels take",
        volume.name, block));
  return within;
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
      volume.levels_fault = obstacle;
      volume.notes.push_back(fmt::format("{}: levels from {} on are left out: {}", volume.name,
                                         pyramid.levels(), obstacle));
      break;
    }
    volume.coarser.emplace_back();
  }
  volume.pyramid = std::make_shared<const PyramidLayout>(std::move(pyramid));
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
  if (stand_in && std::ranges::find(coarser, stand_in->index) == coarser.end())
    bytes += stand_in->index->bytes();
  if (stand_in && stand_in->reach != nullptr) bytes += stand_in->reach->bytes();
  for (const auto& level : coarser)
    if (level != nullptr) bytes += level->bytes();
  return bytes;
}

IndexedVolume indexVolume(std::unique_ptr<VolumeSource> source, const VolumeArguments& arguments,
                          const MachineOptions& machine, const IndexNeeds& asked,
                          const IndexWish& wish, const IndexPass& pass) {
  IndexedVolume volume;
  const IndexNeeds stored = storedNeeds(asked, deviceMap(source->layout()));
  volume.source = withLevelsFor(std::move(source), stored);
  volume.needs = asked;
  volume.name = withoutSecrets(arguments.inputs.front());
  volume.places = indexPlaces(volume.name, wish);
  const VolumeLayout& layout = volume.source->layout();
  volume.map = deviceMap(layout);
  volume.page = pageShape(machine, volume.map);
  const int64_t block = machine.block.value_or(blockSizeFor(volume.page.size_vox));
  const IndexNeeds needs =
      hurriedNeeds(needsWithin(block, stored, machine.levels, volume), *volume.source);
  volume.was_hurried = needs.may_stand_in && !asked.may_stand_in;
  volume.time = arguments.time;
  const bool has_own = !coarserLevels(*volume.source).empty();
  const LevelChoice choice = chooseLevels(*volume.source, needs, machine.levels);
  VolumeSource& coarsest = choice.own_suit ? *coarsestLevel(*volume.source).source : *volume.source;
  const bool is_asked = asked.levels == LevelNeeds::kAll || machine.levels == LevelsWish::kAlways;
  const bool continues = has_own && choice.own_suit;
  SideLevels side({coarsest, continues, volume.name, volume.places, volume.time,
                   downsampleFor(needs.values), choice.beside, is_asked, pass.pool,
                   pass.memory_bytes, pass.stop, pass.announce});
  const auto layoutOf = [&](int ghost) {
    if (!hasRoom(block, ghost))
      failRequest(
          "{}: blocks of {} voxels a side have no room for the border that a picture takes; give a "
          "larger --block",
          volume.name, block);
    return blockLayout(layout.dims, block, ghost, volume.name.c_str());
  };
  const int plain_ghost = needs.gradients ? 1 : 0;
  if (choice.may_sample && !side.any() && (has_own || !isKnown(volume, layoutOf(plain_ghost))))
    takeSample(volume, *needs.sample_seconds, pass);
  // Several levels take a layer more (pyramid.h), and have the same blocks lit and unlit, so that
  // an index made ahead serves both: without one, nothing would be known of the finest level.
  const std::span<const CoarserLevel> own_levels = levelsFor(*volume.source, needs);
  const bool has_levels = side.any() || !own_levels.empty();
  volume.layout =
      layoutOf(has_levels ? ghostOfLevels(layout.dims, block, own_levels) : plain_ghost);
  if (std::string note = smallBlocksNote(volume); machine.block && !note.empty())
    volume.notes.push_back(std::move(note));
  std::optional<IndexedRanges> made;
  if (side.taker() != nullptr) {
    try {
      if (continues)
        passOverCoarsest(volume, coarsest, side, pass);
      else
        made = passForLevels(volume, pass, side);
    } catch (const Error&) {
      // A pass that failed halfway leaves no levels that look whole.
      side.discard();
      throw;
    }
    side.finish();
  }
  if (side.any() && !choice.own_suit) volume.source = withoutLevels(std::move(volume.source));
  volume.source = side.join(std::move(volume.source));
  addLevels(volume, levelsFor(*volume.source, needs));
  volume.source->holdAtMost(pass.memory_bytes / 4);  // nothing else is in memory yet
  if (made) indexLevels(volume, 1, pass);
  IndexedRanges index = made ? *std::move(made) : indexStep(volume, needs, pass);
  std::ranges::copy(side.notes(), std::back_inserter(volume.notes));
  std::ranges::copy(notesOf(volume.name, layout, index), std::back_inserter(volume.notes));
  volume.values = statisticsOf(volume, index, needs.whole_series, pass);
  volume.index = std::make_shared<const IndexedRanges>(std::move(index));
  volume.page.pages = pageCount(machine, volume, volume.rangesBytes());
  return volume;
}

std::string IndexedVolume::standInNote() const {
  // An index of other blocks tells the same as one of these.
  if (!stand_in || stand_in->level == 0) return "";
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

std::vector<std::string> standInNotes(std::span<const IndexedVolume* const> volumes) {
  const bool have_all = std::ranges::all_of(
      volumes, [](const IndexedVolume* volume) { return !volume->standInNote().empty(); });
  std::vector<std::string> notes;
  for (const IndexedVolume* volume : volumes) {
    std::string note = volume->standInNote();
    if (note.empty()) continue;
    // The volume over the others has a name of its own.
    if (!have_all && !volume->channel.is_over)
      note.insert(volume->name.size() + 2, volume->channel.title() + ": ");
    if (std::ranges::find(notes, note) == notes.end()) notes.push_back(std::move(note));
  }
  return notes;
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
  return chooseLook(volume.source->layout(), volume.values,
                    knownLookOfChannel(look, volume.channel, volume.values.counts, mode), mode);
}

}  // namespace sluice
