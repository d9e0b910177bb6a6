// Growing boxes of a whole volume: one pass over its blocks, on all threads, in bounded memory; and
// the cost of a partition under a transfer function.
//
// Blocks of background alone (slice_ranges.h) are never read: each is one box of one value. The
// gradients at its faces depend on its neighbours.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <span>

#include "src/base/sources/volume_source.h"
#include "src/classify/boxes/box_tree.h"
#include "src/classify/transfer/opacity_table.h"
#include "src/volume/passes/volume_pass.h"
#include "src/volume/ranges/slice_ranges.h"

namespace sluice {

// Cells a side of a brick, to which box faces are rounded. Smaller ones fit tighter, in more boxes.
inline constexpr int64_t kGrowingBrickSide = 4;

// The default limit for voxels in memory.
inline constexpr uint64_t kMostGrowingBytes = uint64_t{128} << 20;
// Voxels that a thread holds at least while it grows the boxes of one block.
uint64_t growingBytes(const VolumeLayout& volume, const BlockLayout& layout);

// Fills a region with device voxels of a time step; called on several threads at once.
using ReadVoxels = std::function<void(int64_t time, const RegionRead& region)>;
// Called on any thread, on several at once.
using TakeBricks = std::function<void(int64_t block, const BrickGrid& grid)>;
// Throws Error if a block's voxels contradict the arrays of its step (stale_check.h).
void expectSameValues(const VolumeSource& source, int64_t time, const SliceRanges& ranges,
                      int64_t block, const BrickGrid& grid);

// Calls `take` once for each of `blocks` (ids of the layout, ascending), with the bricks of the
// cells that it owns. Neighbours along x are read together, as far as all threads hold at most the
// pass's memory of voxels, or growingBytes() each. Voxels come through `read` if it is given,
// otherwise from the source. Throws Error from the source, Interrupted.
void forEachBlockBricks(VolumeSource& source, int64_t time, const BlockLayout& layout,
                        std::span<const int64_t> blocks, const VolumePass& pass,
                        const TakeBricks& take, const ReadVoxels& read = {});

// The cost of drawing a partition. Cells are counted inside the crop, boxes if they reach into it.
struct PartitionCost {
  int64_t blocks = 0;  // blocks read
  int64_t grown = 0;   // boxes before the conversion to trees
  int64_t boxes = 0, textures = 0;
  std::array<int64_t, 3> types{};  // boxes by BoxType
  int64_t visible_boxes = 0, visible_cells = 0;
  // The bricks of 8^3 cells, counted from each block's first, that hold a visible cell: the cost of
  // a partition that knew the transfer function. 0 if blocks are so large that bricks are.
  int64_t perfect_bricks = 0, perfect_cells = 0;
};
// Called on any thread, on several at once.
using TakeTree = std::function<void(int64_t block, const BoxTree& tree)>;
// Reads all blocks that are held (forEachBlockBricks), compares them with `ranges`, and hands each
// one's tree to `take` if there is one.
PartitionCost partitionCost(VolumeSource& source, int64_t time, const SliceRanges& ranges,
                            const OpacityTable& table, const Box3& crop, const VolumePass& pass,
                            const TakeTree& take = {});

}  // namespace sluice
