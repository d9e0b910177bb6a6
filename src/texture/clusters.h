// groupIntoClusters: which blocks of a plan are visited together (Tong 1999, section 3.2.3.3).
#pragma once

#include <cstdint>

#include "src/texture/texture_plan.h"

namespace sluice {

// Fills the plan's grids and clusters, and each block's cluster; a cluster has at most
// `capacity_blocks` blocks. Blocks of one level are grouped into boxes of u x v x 1 of them. Blocks
// of several levels are grouped by the octree: all of them, if the cache has room, else those in a
// cell of the coarsest level's grid, else those in a cell of the next. Requires: plan.pyramid and
// plan.blocks are there; capacity_blocks >= 1.
void groupIntoClusters(TexturePlan& plan, int64_t capacity_blocks);

// The same with the clusters of another plan, see PlanOptions::clusters; those that have blocks.
void groupAs(const TexturePlan& other, TexturePlan& plan);

// The size in blocks of the clusters that blocks of one level are grouped into, u x v x 1.
Vec3i clusterBlocks(Vec3i grid, int64_t capacity_blocks);

}  // namespace sluice
