// The metadata files of a store that sluice packs: OME-Zarr 0.4 over Zarr v2. Pure functions; the
// same text for the same arguments, so that a pack that was interrupted ends in the same bytes.
#pragma once

#include <string>
#include <vector>

#include "io/zarr/zarr_array.h"
#include "io/zarr/zarr_codec.h"
#include "src/base/volume_source.h"

namespace sluice {

std::string zarrGroupText();
// .zarray of a Blosc array in C order.
std::string zarrArrayText(const ZarrArray& array, const BloscOptions& options);
// .zattrs of an image of one level, "0", called `name`: axes t c z y x, without t for one time step
// and without c for one channel; the layout's spacing and origin as scale and translation.
// Directions that are not the coordinate axes and a scaling of the values go under the key
// "sluice". `channels`: a name each, perhaps empty; of several they go under "omero".
std::string zarrImageText(const VolumeLayout& layout, const std::string& name,
                          const std::vector<std::string>& channels);

}  // namespace sluice
