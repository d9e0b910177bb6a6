// PlanTotals: what a plan adds up to, for those who compare algorithms and forecast a picture. Pure
// functions.
#pragma once

#include <cstddef>
#include <cstdint>

#include "src/texture/texture_plan.h"

namespace sluice {

struct PlanTotals {
  size_t chunks = 0, clusters = 0;
  Vec3i cluster_blocks;
  int64_t pages = 0;
  int64_t binds = 0;   // see bindCount()
  uint64_t bytes = 0;  // of all chunks in whole pages
};

// The totals of a plan that has been made; the binds are those of a view from this eye.
PlanTotals totalsOf(const TexturePlan& plan, const EyePosition& eye);

// The totals of a plan that loads every block, in closed form: such a plan of a large volume takes
// far more memory than a plan of the blocks that show something. Throws Error when the texture
// cache has fewer pages than one block. Requires: loadsEveryBlock(), and of one process.
PlanTotals totalsOfEveryBlock(const PyramidLayout& pyramid, const VisibleBlocks& visible,
                              const PageGeometry& page, const PlanOptions& options);

}  // namespace sluice
