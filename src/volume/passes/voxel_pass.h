// A pass over the voxels of a volume in tiles, layer by layer, for a VoxelTaker.
//
// The folder: pass_pieces.h cuts a volume into the pieces of a pass, and key_histogram.h counts the
// values that a pass reads.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "src/base/sources/voxel_taker.h"
#include "src/base/threads/stop_token.h"
#include "src/base/threads/worker_pool.h"
#include "src/volume/block_layout.h"
#include "src/volume/passes/pass_pieces.h"

namespace sluice {

// A read and its converted voxels together take at most this many bytes on each thread, so that a
// row of a very wide volume is cut.
inline constexpr uint64_t kBytesPerRead = uint64_t{32} << 20;

// A pass calls this for its pieces, from any thread.
using TakePiece = std::function<void(const PassPiece&)>;
// Whether a pass leaves out the layers that the taker does not want.
enum class PassLayers { kAll, kWanted };

// Calls `take` for the tiles of `blocks` (ascending), and taker.layersBefore() at the end of each
// layer. Throws Interrupted, and what `take` does.
void passInTiles(const BlockLayout& layout, const std::vector<int64_t>& blocks, int64_t most_voxels,
                 PassLayers layers, WorkerPool& pool, VoxelTaker& taker, const StopToken& stop,
                 const TakePiece& take);

// The most voxels of a tile if a voxel as it is read and as it is kept take `voxel_bytes` together.
int64_t voxelsPerTile(size_t voxel_bytes, uint64_t thread_bytes);

}  // namespace sluice
