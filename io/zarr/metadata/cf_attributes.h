// Attributes of the CF conventions on an array by itself, as xarray writes them: the scaling of the
// values, the numbers that stand for missing ones, and the limits of valid ones.
#pragma once

#include "io/zarr/metadata/zarr_image.h"
#include "src/base/files/json_field.h"

namespace sluice {

// Attributes of other types than these may mean anything, and are passed over. xarray writes the
// _FillValue of floats in Zarr 3 as the base64 of eight bytes.
void parseCfAttributes(const JsonField& attributes, ZarrImage& image);

}  // namespace sluice
