// StoreTexts: the metadata of a store that is packed, as text.
#pragma once

#include <string>
#include <vector>

#include "io/zarr/levels/level_shape.h"
#include "io/zarr/metadata/zarr_text.h"
#include "io/zarr/packing/zarr_pack_folder.h"
#include "io/zarr/packing/zarr_writer.h"

namespace sluice {

struct StoreTexts {
  std::string group, image;
  std::vector<ZarrArrayTexts> arrays;

  // All that distinguishes this store from others of the same volume.
  std::string parameters() const;
};

// The texts of a store of these arrays. `levels`: the coarser levels.
StoreTexts storeTexts(ChannelSources channels, const PackOptions& options,
                      const std::vector<PackedArray>& arrays,
                      const std::vector<LevelShape>& levels);

}  // namespace sluice
