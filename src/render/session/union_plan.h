// The plan of what several channels show together, whose clusters the plans of the channels share
// (PlanOptions::clusters): a frame that blends them makes the chunks of a cluster of all channels
// resident, and then draws its blocks. Pure function.
#pragma once

#include <span>

#include "cache/model/page_geometry.h"
#include "src/render/blocks/visible_blocks.h"
#include "src/texture/texture_plan.h"

namespace sluice {

// A channel: the blocks that it shows, and its texture cache.
struct ChannelBlocks {
  PyramidLayout pyramid;
  VisibleBlocksPtr visible;
  PageGeometry page;
};

// The blocks that show something in any channel, each with the hull of the channels' object boxes.
// Each channel's cache has room for a cluster. Requires: the channels' levels are alike
// (areAlike()), and where two of them have a block, it is of the same level. Throws as
// planTextures() does.
TexturePlan unionPlan(std::span<const ChannelBlocks> channels, PlanOptions options);

}  // namespace sluice
