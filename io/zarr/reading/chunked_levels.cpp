// The levels of an image, their spreads, and levels of other values: which arrays are opened, why
// one is left out, and where each lies.
#include <algorithm>
#include <utility>

#include "io/files/level_places.h"
#include "io/zarr/reading/chunked_source.h"
#include "src/base/error.h"

namespace sluice {
namespace {

LevelClaim claimOf(const ZarrView& view, const ZarrImage& image, size_t dataset) {
  LevelClaim claim;
  claim.dims = view.layout.dims;
  const ZarrPlace& place = image.places[dataset];
  if (place.scale.empty()) return claim;
  claim.scale = claim.translation = Vec3d{};
  for (size_t a = 0; a < 3; ++a) {
    (*claim.scale)[static_cast<int>(a)] = place.scale[view.space[a]];
    (*claim.translation)[static_cast<int>(a)] = place.translation[view.space[a]];
  }
  return claim;
}

// Why two arrays cannot be levels of one image; empty if they can.
std::string faultAmong(const VolumeLayout& finest, const VolumeLayout& level) {
  if (level.type != finest.type)
    return fmt::format("its voxels are {}, the first level's are {}", name(level.type),
                       name(finest.type));
  const auto fault = [](int64_t count, const char* what, int64_t expected) {
    return fmt::format("it has {} {}{}, the first level has {}", count, what, count == 1 ? "" : "s",
                       expected);
  };
  if (level.time_steps != finest.time_steps)
    return fault(level.time_steps, "time step", finest.time_steps);
  if (level.channels != finest.channels) return fault(level.channels, "channel", finest.channels);
  return "";
}

// Why an array cannot be the spreads of a level; empty where it can.
std::string faultOfSpreads(const VolumeLayout& level, const VolumeLayout& spreads) {
  const VoxelType type = spreadType(level.type);
  if (spreads.type != type)
    return fmt::format("its numbers are {}, expected {}", name(spreads.type), name(type));
  if (spreads.dims != level.dims || spreads.time_steps != level.time_steps ||
      spreads.channels != level.channels)
    return "its shape is not that of the level";
  return "";
}

}  // namespace

void ChunkedSource::openLevels(const ChunkedVolume& volume) {
  VolumeLayout& layout = view_.layout;
  const LevelClaim finest = claimOf(view_, volume.image, 0);
  spreads_ = openSpreads(volume, 0, layout);
  for (const ZarrLevelGroup& group : volume.image.level_groups)
    level_groups_.push_back({group.values, {}, {}});
  std::vector<size_t> datasets;  // of level_sources_
  for (size_t i = 1; i < volume.image.levels.size(); ++i) {
    // A level that is damaged costs the picture its detail at a distance, and not the volume.
    std::string fault;
    try {
      std::unique_ptr<ChunkedSource> source = openPart(volume, volume.open(i), i);
      fault = faultAmong(layout, source->view_.layout);
      if (fault.empty()) fault = faultOfLevel(finest, claimOf(source->view_, volume.image, i));
      if (fault.empty()) {
        spread_sources_.push_back(openSpreads(volume, i, source->view_.layout));
        for (size_t g = 0; g < level_groups_.size(); ++g)
          level_groups_[g].sources.push_back(openInGroup(volume, g, i, source->view_.layout));
        level_sources_.push_back(std::move(source));
        datasets.push_back(i);
      }
    } catch (const Error& error) {
      fault = error.what();
    }
    if (!fault.empty())
      layout.notes.push_back(fmt::format("{}: level {} is left out: {}", volume.name, i, fault));
  }
  placeLevels(volume, datasets);
  placeGroups();
  layout.levels = 1 + static_cast<int64_t>(levels_above_.size());
}

std::unique_ptr<ChunkedSource> ChunkedSource::openPart(const ChunkedVolume& volume,
                                                       OpenedArray opened, size_t level) {
  const ChannelWish channel = view_.channel ? ChannelWish(channel_) : ChannelWish();
  return std::unique_ptr<ChunkedSource>(
      new ChunkedSource(volume, std::move(opened), level, channel, cache_, Part::kLevel));
}

std::unique_ptr<ChunkedSource> ChunkedSource::openSpreads(const ChunkedVolume& volume, size_t level,
                                                          const VolumeLayout& layout) {
  if (!volume.open_spreads) return nullptr;
  std::string fault;
  try {
    std::optional<OpenedArray> opened = volume.open_spreads(level);
    if (!opened) return nullptr;
    std::unique_ptr<ChunkedSource> source = openPart(volume, *std::move(opened), level);
    fault = faultOfSpreads(layout, source->view_.layout);
    if (fault.empty()) return source;
  } catch (const Error& error) {
    fault = error.what();
  }
  view_.layout.notes.push_back(
      fmt::format("{}: the spread of level {} is left out: {}", volume.name, level, fault));
  return nullptr;
}

std::unique_ptr<ChunkedSource> ChunkedSource::openInGroup(const ChunkedVolume& volume, size_t group,
                                                          size_t level,
                                                          const VolumeLayout& layout) {
  std::string fault;
  try {
    std::unique_ptr<ChunkedSource> source =
        openPart(volume, volume.open_in_group(group, level), level);
    fault = faultAmong(layout, source->view_.layout);
    if (fault.empty() && source->view_.layout.dims != layout.dims)
      fault = "its shape is not that of the level";
    if (fault.empty()) return source;
  } catch (const Error& error) {
    fault = error.what();
  }
  view_.layout.notes.push_back(fmt::format("{}: the {} of level {} is left out: {}", volume.name,
                                           volume.image.level_groups[group].folder, level, fault));
  return nullptr;
}

std::span<const CoarserLevel> ChunkedSource::levelsOfKind(LevelValues values) const {
  for (const LevelGroup& group : level_groups_)
    if (group.values == values) return group.levels;
  return {};
}

std::vector<ChunkedSource*> ChunkedSource::sourcesAbove() const {
  std::vector<ChunkedSource*> sources;
  const auto add = [&](const std::vector<std::unique_ptr<ChunkedSource>>& list) {
    for (const auto& source : list)
      if (source != nullptr) sources.push_back(source.get());
  };
  add(level_sources_);
  add(spread_sources_);
  for (const LevelGroup& group : level_groups_) add(group.sources);
  if (spreads_ != nullptr) sources.push_back(spreads_.get());
  return sources;
}

void ChunkedSource::placeLevels(const ChunkedVolume& volume, const std::vector<size_t>& datasets) {
  const ZarrImage& image = volume.image;
  const LevelClaim finest = claimOf(view_, image, 0);
  bool is_translated = image.places[0].is_translated;
  for (size_t i = 0; i < datasets.size(); ++i) {
    const LevelClaim claim = claimOf(level_sources_[i]->view_, image, datasets[i]);
    LevelPlacement place{levelFactor(finest, claim), {}};
    is_translated = is_translated || image.places[datasets[i]].is_translated;
    if (claim.translation && finest.translation)
      place.offset = (*claim.translation - *finest.translation) / *finest.scale;
    const bool has_spreads = spread_sources_[i] != nullptr;
    levels_above_.push_back({level_sources_[i].get(), place, spread_sources_[i].get(), false,
                             has_spreads && image.level_values != LevelValues::kModes
                                 ? LevelValues::kMeans
                                 : image.level_values});
  }
  // Other programs list levels in any order.
  std::stable_sort(levels_above_.begin(), levels_above_.end(),
                   [](const CoarserLevel& a, const CoarserLevel& b) {
                     const Vec3d f = a.placement.scale, g = b.placement.scale;
                     return f.x * f.y * f.z < g.x * g.y * g.z;
                   });
  if (!levels_above_.empty() && !is_translated)
    view_.layout.notes.push_back(volume.name + ": " + findOrigin(*this, levels_above_));
}

void ChunkedSource::placeGroups() {
  for (LevelGroup& group : level_groups_)
    for (const CoarserLevel& level : levels_above_)
      for (size_t i = 0; i < level_sources_.size(); ++i)
        if (level.source == level_sources_[i].get() && group.sources[i] != nullptr)
          group.levels.push_back(
              {group.sources[i].get(), level.placement, nullptr, false, group.values});
}

}  // namespace sluice
