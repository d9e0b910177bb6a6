#include "src/volume/passes/voxel_pass.h"

#include <algorithm>

#include "src/base/memory/aligned_array.h"
#include "src/volume/ranges/brick_ranges.h"

namespace sluice {

void passInTiles(const BlockLayout& layout, const std::vector<int64_t>& blocks, int64_t most_voxels,
                 PassLayers layers, WorkerPool& pool, VoxelTaker& taker, const StopToken& stop,
                 const TakePiece& take) {
  const int64_t side = taker.side();
  for (int64_t z = 0; z < layout.dims.z; z += side) {
    const bool is_wanted = taker.wantsLayer(z);  // asked first: take() depends on it
    if (layers == PassLayers::kAll || is_wanted) {
      const std::vector<PassPiece> tiles = tilesOf(layout, blocks, side, z, most_voxels);
      pool.parallelFor(static_cast<int64_t>(tiles.size()), [&](int64_t i) {
        stop.throwIfStopped();
        take(tiles[static_cast<size_t>(i)]);
      });
    }
    taker.layersBefore(std::min(z + side, layout.dims.z));
  }
}

int64_t voxelsPerTile(size_t voxel_bytes, uint64_t thread_bytes) {
  return static_cast<int64_t>(std::min(kBytesPerRead, thread_bytes) / voxel_bytes);
}

void passVoxels(VolumeSource& source, int64_t time, const BlockLayout& layout, WorkerPool& pool,
                ProgressMeter& progress, uint64_t most_bytes, const StopToken& stop,
                VoxelTaker& taker) {
  const std::vector<int64_t> blocks = candidateBlocks(layout, source.occupancy(time));
  const size_t voxel_bytes = bytesPerVoxel(source.layout().type);
  progress.expect(static_cast<uint64_t>(volume(layout.dims)) * voxel_bytes);
  const TakePiece take = [&](const PassPiece& piece) {
    const auto voxels = static_cast<size_t>(piece.own.count());
    const AlignedArray<std::byte> stored = alignedForOverwrite<std::byte>(voxels * voxel_bytes);
    source.readRegion(time, piece.own, {stored.get(), voxels * voxel_bytes});
    const Vec3i size = piece.own.size();
    taker.take({piece.own, stored.get(), size.x, size.x * size.y});
    progress.add(voxels * voxel_bytes);
  };
  passInTiles(layout, blocks,
              voxelsPerTile(voxel_bytes, most_bytes / static_cast<uint64_t>(pool.threads())),
              PassLayers::kWanted, pool, taker, stop, take);
}

}  // namespace sluice
