#include "src/volume/passes/voxel_pass.h"

#include <algorithm>
#include <utility>

#include "src/base/memory/aligned_array.h"
#include "src/volume/ranges/brick_ranges.h"

namespace sluice {

namespace {

// Pieces that a source is told of beforehand, for each thread.
constexpr size_t kExpectedPieces = 2;

}  // namespace

void passPieces(const PassedVoxels& passed, std::span<const PassPiece> pieces, size_t count,
                const TakePiece& take) {
  const size_t ahead = kExpectedPieces * static_cast<size_t>(passed.pass.pool.threads());
  passed.pass.pool.parallelFor(static_cast<int64_t>(count), [&](int64_t i) {
    passed.pass.stop.throwIfStopped();
    const auto piece = static_cast<size_t>(i);
    if (const size_t later = piece + ahead; later < pieces.size())
      passed.source.expectRegion(passed.time, pieces[later].read);
    take(pieces[piece]);
  });
}

void passInTiles(const PassedVoxels& passed, int64_t most_voxels, PassLayers layers,
                 VoxelTaker& taker, const TakePiece& take) {
  ProgressMeter& progress = passed.pass.progress;
  const BlockLayout& layout = passed.layout;
  const int64_t side = taker.side();
  const size_t voxel_bytes = bytesPerVoxel(passed.source.layout().type);
  progress.expect(static_cast<uint64_t>(volume(layout.dims)) * voxel_bytes);
  std::vector<PassPiece> next = tilesOf(layout, passed.blocks, side, 0, most_voxels);
  for (int64_t z = 0; z < layout.dims.z; z += side) {
    const bool is_wanted = taker.wantsLayer(z);  // asked first: take() depends on it
    const size_t count = next.size();
    std::vector<PassPiece> tiles = std::move(next);
    // The next layer's tiles are listed now, so that the source is told of its first ones before
    // this layer ends.
    next = tilesOf(layout, passed.blocks, side, z + side, most_voxels);
    tiles.insert(tiles.end(), next.begin(), next.end());
    const int64_t end = std::min(z + side, layout.dims.z);
    int64_t rest = layout.dims.x * layout.dims.y * (end - z);
    if (layers == PassLayers::kAll || is_wanted) {
      passPieces(passed, tiles, count, [&](const PassPiece& tile) {
        take(tile);
        progress.add(static_cast<uint64_t>(tile.own.count()) * voxel_bytes);
      });
      for (size_t i = 0; i < count; ++i) rest -= tiles[i].own.count();
    }
    // Background and layers that nobody wants are done, too, or the pass would end before its end.
    if (rest > 0) progress.add(static_cast<uint64_t>(rest) * voxel_bytes);
    // All tiles of this layer have been taken: parallelFor() returns after the last.
    taker.layersBefore(end);
  }
}

int64_t voxelsPerTile(size_t voxel_bytes, uint64_t thread_bytes) {
  return static_cast<int64_t>(std::min(kBytesPerRead, thread_bytes) / voxel_bytes);
}

void passVoxels(VolumeSource& source, int64_t time, const BlockLayout& layout,
                const VolumePass& pass, VoxelTaker& taker) {
  const std::vector<int64_t> blocks = candidateBlocks(layout, source.occupancy(time));
  const size_t voxel_bytes = bytesPerVoxel(source.layout().type);
  const TakePiece take = [&](const PassPiece& piece) {
    const auto voxels = static_cast<size_t>(piece.own.count());
    const AlignedArray<std::byte> stored = alignedForOverwrite<std::byte>(voxels * voxel_bytes);
    source.readRegion(time, piece.own, {stored.get(), voxels * voxel_bytes});
    const Vec3i size = piece.own.size();
    taker.take({piece.own, stored.get(), size.x, size.x * size.y});
  };
  const auto threads = static_cast<uint64_t>(pass.pool.threads());
  passInTiles({source, time, layout, blocks, pass},
              voxelsPerTile(voxel_bytes, pass.memory_bytes / threads), PassLayers::kWanted, taker,
              take);
}

}  // namespace sluice
