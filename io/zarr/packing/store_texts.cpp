#include "io/zarr/packing/store_texts.h"

#include <algorithm>
#include <span>

#include "io/files/length_unit.h"
#include "io/zarr/levels/level_maker.h"
#include "io/zarr/metadata/zarr_image.h"
#include "src/base/sources/volume_channels.h"

namespace sluice {
namespace {

// The name of each channel, empty if the file does not tell, and its look.
ZarrChannelsText textOf(ChannelSources channels) {
  ZarrChannelsText text;
  text.names.resize(channels.size());
  const std::span<const std::string> said = channelNames(*channels.front());
  if (channels.size() == 1) {
    const auto at = static_cast<size_t>(channels.front()->layout().channel);
    const std::span<const StoredLook> looks = channelLooks(*channels.front());
    if (at < said.size()) text.names.front() = said[at];
    if (at < looks.size()) text.looks.push_back(looks[at]);
    // Nothing would show in a viewer if the one channel were hidden.
    for (StoredLook& look : text.looks) look.is_active = true;
    return text;
  }
  for (size_t c = 0; c < std::min(text.names.size(), said.size()); ++c) text.names[c] = said[c];
  const std::span<const StoredLook> looks = channelLooks(*channels.front());
  text.looks.assign(looks.begin(), looks.end());
  return text;
}

// The text of an image for levels made in these ways.
ZarrLevelsText textOf(const std::vector<LevelShape>& levels, const std::vector<Downsample>& ways) {
  const Downsample how = ways.front();
  ZarrLevelsText text{{}, valuesOf(how), !levels.empty() && keepsSpreads(how)};
  for (const LevelShape& level : levels) text.placements.push_back(placementOf(level));
  if (!levels.empty())
    for (size_t i = 1; i < ways.size(); ++i) text.groups.push_back(valuesOf(ways[i]));
  return text;
}

// Spreads are no values, so that the values' scaling is none of theirs.
ZarrArrayLabels labelsOf(const PackedArray& packed, const VolumeLayout& layout, size_t channels) {
  ZarrArrayLabels labels{.axes = zarrAxisNames(layout, channels)};
  if (packed.folder.starts_with(std::string(kZarrSpreadFolder) + "/")) return labels;
  labels.value_scale = layout.value_scale;
  labels.value_offset = layout.value_offset;
  return labels;
}

}  // namespace

std::string StoreTexts::parameters() const {
  std::string all;
  for (const ZarrArrayTexts& array : arrays) all += array.header + array.attributes;
  return all + image;
}

StoreTexts storeTexts(ChannelSources channels, const PackOptions& options,
                      const std::vector<PackedArray>& arrays,
                      const std::vector<LevelShape>& levels) {
  VolumeLayout layout = channels.front()->layout();
  if (!options.unit.empty()) layout.unit = lengthUnit(options.unit);
  const ZarrFormat format = options.shard_voxels ? ZarrFormat::k3 : ZarrFormat::k2;
  StoreTexts texts;
  texts.group = zarrGroupText(format);
  ZarrLevelsText of_levels = textOf(levels, options.downsample);
  of_levels.times = timesOf(*channels.front());
  texts.image = zarrImageText(layout, layout.name, textOf(channels), of_levels, format);
  for (const PackedArray& packed : arrays)
    texts.arrays.push_back(
        zarrArrayTexts(packed.array, options.blosc, labelsOf(packed, layout, channels.size())));
  return texts;
}

}  // namespace sluice
