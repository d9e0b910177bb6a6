// N5: a data set, or a group of levels s0, s1 and so on, as a volume of chunked arrays.
//
// Name the folder of a level to read that one alone; its place is found in the group around it.
#pragma once

#include <vector>

#include "io/stores/chunk_store.h"
#include "io/zarr/reading/chunked_array.h"
#include "src/base/values/vec.h"

namespace sluice {

// Whether a folder is of N5: it has attributes.json, or its first level does.
bool isN5(const StorePlace& folder);

// The data set in a folder. Throws Error: there is none, or it cannot be read.
OpenedArray openN5Array(const StorePlace& folder);

// Finest voxels along x, y and z to a voxel of each level, of a set-up of BigDataViewer: as its own
// attributes say, or those of the levels in a time point's folder. Throws Error.
std::vector<Vec3d> n5Factors(const StorePlace& setup, const StorePlace& time_point);

// Throws Error: neither a data set nor a group of levels, attributes that cannot be read.
ChunkedVolume n5Volume(const StorePlace& folder);

}  // namespace sluice
