// The blocks of N5: a header with the block's own extents, and the compressed voxels. A block at
// the upper end of the data set may have as few voxels as the data set has there. Pure functions.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "io/zarr/metadata/zarr_array.h"

namespace sluice {

struct N5Block {
  std::span<const std::byte> stored = {};  // after the header
  std::vector<int64_t> extents = {};       // as the array's axes are; at most a chunk's
  uint64_t bytes = 0;                      // of its voxels once decoded
};

// Throws Error, which starts with `path`, unless a file of `stored_bytes` can hold a block of at
// most `chunk_bytes`. Called before anything is read or allocated.
void checkN5Size(uint64_t stored_bytes, uint64_t chunk_bytes, const std::string& path);

// Throws Error, which starts with `path`: the header is cut, of another form, larger than a chunk,
// or smaller than the array is there.
N5Block parseN5Block(const ZarrArray& array, int64_t chunk, std::span<const std::byte> file,
                     const std::string& path);

// Moves the voxels of a block from the start of a chunk to their places in it. Voxels of the chunk
// beyond the block are left as they are.
void spreadN5Block(const ZarrArray& array, const N5Block& block, std::span<std::byte> chunk);

}  // namespace sluice
