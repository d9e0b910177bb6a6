// Fields that the metadata of both Zarr versions have.
#pragma once

#include <nlohmann/json.hpp>
#include <vector>

#include "io/zarr/metadata/zarr_array.h"
#include "src/base/files/json_field.h"

namespace sluice {

// The extents of 1 to 5 axes. Throws Error.
std::vector<int64_t> zarrExtents(const JsonField& field);
// The extents of as many axes as the array has. Throws Error.
std::vector<int64_t> zarrExtents(const JsonField& field, const ZarrArray& array);
// Throws Error if the array has too many voxels, or its chunks. Requires: shape, chunks, type.
void requireZarrSizes(const JsonField& shape, const JsonField& chunks, const ZarrArray& array);
// The value of missing chunks. Requires: the type.
double zarrFill(const JsonField& field, const ZarrArray& array);

// A zarr.json of version 3, see parseZarrArray().
ZarrArray parseZarrArray3(const JsonField& root, const nlohmann::json& document,
                          const std::string& path);

}  // namespace sluice
