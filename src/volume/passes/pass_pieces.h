// The pieces in which a pass over a volume reads it: runs of neighbouring blocks, or tiles that
// begin and end where a VoxelTaker wants them to.
//
// Pure functions.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "src/base/sources/volume_source.h"
#include "src/volume/block_layout.h"

namespace sluice {

struct PassPiece {
  Box3 read;    // voxels that are read
  Box3 own;     // part of them that no other piece has as its own
  Box3 blocks;  // indices of the blocks whose arrays get their values from this piece
};

// Blocks that may hold something else than the background, by id, ascending.
std::vector<int64_t> candidateBlocks(const BlockLayout& layout,
                                     const std::optional<Occupancy>& occupancy);

// Each of `blocks` (ascending) in one piece, of at most `most` blocks side by side along x. Own
// voxels share out the cells' lower corners and the volume's last planes.
std::vector<PassPiece> runsOf(const BlockLayout& layout, const std::vector<int64_t>& blocks,
                              int64_t most);

// The tiles of `side` voxels along y and z, and of as many along x as `most_voxels` allow (a
// multiple of `side`), in the layer that begins at plane `z`; only those that `blocks` (ascending)
// reach into, and none behind the last layer. A tile that another one follows along x is read with
// that one's first plane.
std::vector<PassPiece> tilesOf(const BlockLayout& layout, const std::vector<int64_t>& blocks,
                               int64_t side, int64_t z, int64_t most_voxels);

}  // namespace sluice
