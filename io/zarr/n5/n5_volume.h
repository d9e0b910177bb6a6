// N5: a data set, or a group of levels s0, s1 and so on, as a volume of chunked arrays.
//
// Name the folder of a level to read that one alone; its place is found in the group around it.
#pragma once

#include "io/stores/chunk_store.h"
#include "io/zarr/reading/chunked_array.h"

namespace sluice {

// Whether a folder is of N5: it has attributes.json, or its first level does.
bool isN5(const StorePlace& folder);

// Throws Error: neither a data set nor a group of levels, attributes that cannot be read.
ChunkedVolume n5Volume(const StorePlace& folder);

}  // namespace sluice
