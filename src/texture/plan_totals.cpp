#include "src/texture/plan_totals.h"

#include <algorithm>

#include "src/base/error.h"
#include "src/texture/clusters.h"
#include "src/texture/frame_trace.h"
#include "src/volume/block_side.h"

namespace sluice {
namespace {

// Blocks that own a cell of `cells`. Owned cells are the same along an axis for all blocks of one
// index there, so each axis is counted by itself.
int64_t blocksThatOwn(const BlockLayout& layout, const Box3& cells) {
  int64_t blocks = 1;
  for (int axis = 0; axis < 3; ++axis) {
    int64_t of_axis = 0;
    for (Vec3i index; index[axis] < layout.grid[axis]; ++index[axis]) {
      const Box3 owned = layout.ownedCells(index);
      of_axis += std::max(owned.lo[axis], cells.lo[axis]) < std::min(owned.hi[axis], cells.hi[axis])
                     ? 1
                     : 0;
    }
    blocks *= of_axis;
  }
  return blocks;
}

}  // namespace

PlanTotals totalsOf(const TexturePlan& plan, const EyePosition& eye) {
  return {plan.chunks.size(), plan.clusters.size(), plan.cluster_blocks,
          plan.pageCount(),   bindCount(plan, eye), plan.bytes()};
}

PlanTotals totalsOfEveryBlock(const PyramidLayout& pyramid, const VisibleBlocks& visible,
                              const PageGeometry& page, const PlanOptions& options) {
  SLUICE_CHECK(loadsEveryBlock(visible, options.algorithm) && !visible.share);
  const BlockLayout& layout = pyramid.finest();
  const int64_t side = blockSide(layout, pyramid.levels());
  PlanTotals totals;
  // Every block is in the plan, visible or not, so that the grid alone gives all counts but the
  // binds.
  totals.cluster_blocks = clusterBlocks(layout.grid, clusterCapacity(pyramid, visible, page));
  totals.clusters = 1;
  for (int axis = 0; axis < 3; ++axis)
    totals.clusters *= static_cast<size_t>(ceilDiv(layout.grid[axis], totals.cluster_blocks[axis]));
  const int64_t blocks = layout.blockCount();
  totals.chunks = static_cast<size_t>(blocks);
  totals.pages = blocks * pyramid.level(0).numbers * page.pagesOf(Vec3i{side, side, side});
  totals.bytes = static_cast<uint64_t>(totals.pages * page.pageBytes());
  // Algorithm I draws all blocks that own a cell inside the crop, II those with an object box.
  totals.binds = options.algorithm == Algorithm::kConventional
                     ? blocksThatOwn(layout, options.crop)
                     : static_cast<int64_t>(visible.blocks.size());
  return totals;
}

}  // namespace sluice
