// The metadata files of a store that sluice packs: OME-Zarr 0.4 over Zarr 2, or 0.5 over Zarr 3.
// Pure functions; the same text for the same arguments, so that a pack that was interrupted ends in
// the same bytes.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "io/zarr/metadata/zarr_array.h"
#include "io/zarr/reading/zarr_codec.h"
#include "src/base/sources/volume_channels.h"
#include "src/base/sources/volume_levels.h"
#include "src/base/sources/volume_source.h"
#include "src/base/sources/volume_times.h"

namespace sluice {

enum class ZarrFormat { k2, k3 };

// .zgroup, or the zarr.json of a group without attributes.
std::string zarrGroupText(ZarrFormat format = ZarrFormat::k2);
// Attributes of an array for programs that open it by itself.
struct ZarrArrayLabels {
  std::vector<std::string> axes;  // names; empty: none
  // value = stored * value_scale + value_offset.
  double value_scale = 1, value_offset = 0;
};
// Metadata of an array: its .zarray and .zattrs, or its zarr.json alone.
struct ZarrArrayTexts {
  std::string header, attributes;  // attributes: empty if there is no .zattrs
};
// The texts of a Blosc array in C order; of Zarr 3 if it has shards. The scaling is written as the
// CF conventions have it (scale_factor, add_offset), which xarray applies. Zarr 2 has names of axes
// beside a scaling only, because xarray needs them.
ZarrArrayTexts zarrArrayTexts(const ZarrArray& array, const BloscOptions& options,
                              const ZarrArrayLabels& labels = {});
// The names of the axes of an image's arrays, in their order.
std::vector<std::string> zarrAxisNames(const VolumeLayout& layout, size_t channels);
// The coarser levels of an image: the places of their voxels among the finest one's, and how they
// were made; and the times of the steps of all levels.
struct ZarrLevelsText {
  std::vector<LevelPlacement> placements;  // from fine to coarse
  LevelValues values = LevelValues::kMeans;
  bool has_spreads = false;              // in arrays beside them, see kZarrSpreadFolder
  std::vector<LevelValues> groups = {};  // of further levels, see zarrLevelsFolder()
  std::optional<TimeAxis> times = {};
};

// The channels of an image, for viewers.
struct ZarrChannelsText {
  std::vector<std::string> names;  // one each, perhaps empty
  std::vector<StoredLook> looks;   // fewer than names: the file gave none
};

// .zattrs, or the zarr.json of a group, of an image called `name`, whose levels are the folders
// "0", "1" and so on: axes t c z y x, without t for one time step and without c for one channel;
// the layout's spacing and origin as scale and translation of level 0, from which the other levels'
// follow, and the times of the steps. Directions that are not the coordinate axes and a scaling of
// the values go under the key "sluice"; zarrArrayTexts() repeats the scaling for others.
// `channels`: their names and looks, which go under "omero" if there are any.
std::string zarrImageText(const VolumeLayout& layout, const std::string& name,
                          const ZarrChannelsText& channels, const ZarrLevelsText& levels,
                          ZarrFormat format = ZarrFormat::k2);

}  // namespace sluice
