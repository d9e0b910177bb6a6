// A pass over the voxels of a volume in tiles, layer by layer, for a VoxelTaker.
//
// The folder: pass_pieces.h cuts a volume into the pieces of a pass, and key_histogram.h counts the
// values that a pass reads.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "src/base/sources/volume_source.h"
#include "src/base/sources/voxel_taker.h"
#include "src/volume/block_layout.h"
#include "src/volume/passes/pass_pieces.h"
#include "src/volume/passes/volume_pass.h"

namespace sluice {

// A read and its converted voxels together take at most this many bytes on each thread, so that a
// row of a very wide volume is cut.
inline constexpr uint64_t kBytesPerRead = uint64_t{32} << 20;

// The voxels that a pass reads.
struct PassedVoxels {
  VolumeSource& source;
  int64_t time;
  const BlockLayout& layout;
  const std::vector<int64_t>& blocks;  // ascending
  const VolumePass& pass;
};

// A pass calls this for its pieces, from any thread.
using TakePiece = std::function<void(const PassPiece&)>;
// Whether a pass leaves out the layers that the taker does not want.
enum class PassLayers { kAll, kWanted };

// Calls `take` for the first `count` of the pieces. The source is told of each piece some pieces
// before it is read, and of the next ones after those at the end: a disk works while the threads
// count. Throws Interrupted, and what the source and `take` do.
void passPieces(const PassedVoxels& passed, std::span<const PassPiece> pieces, size_t count,
                const TakePiece& take);

// The same for all tiles of the blocks, with taker.layersBefore() at the end of each layer. The
// progress counts all stored bytes of the volume, those of layers and tiles that are left out, too.
void passInTiles(const PassedVoxels& passed, int64_t most_voxels, PassLayers layers,
                 VoxelTaker& taker, const TakePiece& take);

// A pass for `taker` alone, over the layers that it wants. Throws as passPieces() does.
void passVoxels(VolumeSource& source, int64_t time, const BlockLayout& layout,
                const VolumePass& pass, VoxelTaker& taker);

// The most voxels of a tile if a voxel as it is read and as it is kept take `voxel_bytes` together.
int64_t voxelsPerTile(size_t voxel_bytes, uint64_t thread_bytes);

}  // namespace sluice
