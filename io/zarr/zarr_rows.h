// Rows of voxels out of a decoded chunk, or of the fill value. Pure functions.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "io/zarr/zarr_array.h"

namespace sluice {

// Voxels between neighbours along each of the array's axes, inside a chunk.
std::vector<int64_t> stridesInChunk(const ZarrArray& array);

// Copies `count` voxels of `voxel` bytes, of which every stride-th is taken, to packed ones.
void copyRow(const std::byte* from, int64_t stride, std::byte* to, int64_t count, size_t voxel);

// Writes a voxel `count` times.
void fillRow(std::span<const std::byte> voxel, std::byte* to, int64_t count);

}  // namespace sluice
