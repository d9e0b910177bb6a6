// The plan of what several channels show together, whose clusters the plans of the channels share
// (PlanOptions::clusters): a frame that blends them makes the chunks of a cluster of all channels
// resident, and then draws its blocks. Pure function.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

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
// Each channel's cache has room for a cluster. Requires: the blocks are of levels
// that the channels have in common (levelsInCommon()), and where two of them have a block, it is
// of the same level. Throws as
// planTextures() does.
TexturePlan unionPlan(std::span<const ChannelBlocks> channels, PlanOptions options);

// The algorithm of all channels that show these blocks. No algorithm loads blocks that show nothing
// of a picture of several levels, and a channel whose own blocks are all of the finest level must
// not do so either.
Algorithm blendedAlgorithm(Algorithm asked, std::span<const VisibleBlocksPtr> channels);

// A cluster's place in the grids that all of the plans share.
using ClusterPlace = std::array<int64_t, 4>;
ClusterPlace placeOf(const Cluster& cluster);
// The clusters of a channel's plan in the order of a visit to those of unionPlan().
std::vector<ClusterPosition> ownClusters(const TexturePlan& own, const TexturePlan& all,
                                         std::span<const ClusterPosition> order);

}  // namespace sluice
