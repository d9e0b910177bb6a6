// How voxels lie in a decoded chunk, and rows of the fill value. Pure functions.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "io/zarr/metadata/zarr_array.h"

namespace sluice {

// Voxels between neighbours along each of the array's axes, inside a chunk.
std::vector<int64_t> stridesInChunk(const ZarrArray& array);

// Writes a voxel `count` times.
void fillRow(std::span<const std::byte> voxel, std::byte* to, int64_t count);

}  // namespace sluice
