#include "src/library/drawing/cost/wanted_reads.h"

#include <algorithm>
#include <utility>

#include "src/render/frame/level_borders.h"

namespace sluice {
namespace {

// Surfaces are also drawn beside a block where levels meet.
Box3 drawnIn(const PyramidLayout& pyramid, const TextureBlock& block, const Box3& shown) {
  return block.level_faces == 0 ? block.cells : cellsWithBorders(pyramid, block, shown);
}

}  // namespace

uint64_t decodedBytes(const PyramidLayout& layout, VoxelType type, const BlockName& block) {
  return static_cast<uint64_t>(layout.storedVoxels(block).count()) *
         storedBytesPerVoxel(type, layout.of(block).numbers);
}

StripTally::StripTally(FrameSetup setup, std::span<const PictureRows> strips)
    : setup_(std::move(setup)), strips_(std::max<int64_t>(1, std::ssize(strips))) {
  // Strips come from the top down, and the highest one may have fewer rows.
  if (strips_ > 1) rows_ = strips.back().hi - strips.back().lo;
}

int64_t StripTally::loads(std::span<const Box3> blocks) const {
  if (strips_ == 1) return 1;
  std::vector<std::pair<int, int>> intervals;  // of strips, the last one included
  intervals.reserve(blocks.size());
  for (const Box3& cells : blocks)
    if (const PictureRows rows = rowsOf(setup_, cells); rows.lo < rows.hi)
      intervals.emplace_back(rows.lo / rows_, (rows.hi - 1) / rows_);
  // The union of the intervals: a strip that several blocks of a chunk reach loads the chunk once.
  std::ranges::sort(intervals);
  int64_t count = 0;
  int next = 0;
  for (const auto& [first, last] : intervals) {
    count += std::max(0, last + 1 - std::max(first, next));
    next = std::max(next, last + 1);
  }
  return count;
}

WantedReads wantedReads(const TexturePlan& textures, VoxelType type, const StripTally& strips) {
  WantedReads wanted;
  std::vector<Box3> cells;
  for (const Cluster& cluster : textures.clusters)
    for (const ChunkPosition chunk : cluster.chunks) {
      const auto& blocks = textures.chunks[chunk].blocks;
      cells.clear();
      cells.reserve(blocks.size());
      for (const BlockPosition block : blocks)
        cells.push_back(drawnIn(textures.pyramid, textures.blocks[block], strips.shown()));
      // A chunk is loaded or evicted as a whole, so its blocks are read as often as it is.
      const int64_t times = strips.loads(cells);
      for (const BlockPosition block : blocks)
        wanted.add(times, decodedBytes(textures.pyramid, type, textures.blocks[block].name));
    }
  return wanted;
}

WantedReads wantedReadsOfEachBlock(const PyramidLayout& layout, const VisibleBlocks& visible,
                                   const PlanOptions& options, VoxelType type,
                                   const StripTally& strips) {
  WantedReads wanted;
  visitTextureBlocks(layout, visible, options, [&](const TextureBlock& block) {
    const Box3 cells = drawnIn(layout, block, strips.shown());
    wanted.add(strips.loads({&cells, 1}), decodedBytes(layout, type, block.name));
  });
  return wanted;
}

}  // namespace sluice
