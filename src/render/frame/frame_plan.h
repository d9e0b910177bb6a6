// FramePlan: what a frame will draw and load, the fourth value of its chain: texture blocks, chunks
// and clusters (texture_plan.h), the chunks' names, and values that follow from these alone. No
// voxel is touched. Immutable.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "src/render/blocks/time_step.h"
#include "src/render/frame/frame_report.h"
#include "src/texture/chunk_names.h"
#include "src/texture/texture_plan.h"

namespace sluice {

struct FramePlan {
  TexturePlan textures;
  ChunkNameList names;  // names of textures.chunks
  int64_t pages = 0;    // pages of all chunks
  MovedBytes rebuild;   // bytes that a frame moves if it starts from nothing
  Box3 hull;            // hull of the cells that are drawn; empty: nothing is
  int64_t cells = 0;    // cells that are drawn
};
using FramePlanPtr = std::shared_ptr<const FramePlan>;

// Throws Error when the texture cache has fewer pages than one block.
FramePlan makeFramePlan(const TimeStep& step, const VisibleBlocks& visible,
                        const PageGeometry& page, const PlanOptions& options, ChunkNames& names);

}  // namespace sluice
