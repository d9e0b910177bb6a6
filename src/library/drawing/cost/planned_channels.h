// The plan of a picture: what each of its channels costs before it is drawn, and all of them
// together. The library's plan() and the plan command make it here. Pure functions.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "src/library/drawing/cost/picture_cost.h"
#include "src/library/drawing/scene/channel_shares.h"

namespace sluice {

// A channel of the picture with its plans. Most pictures have one.
struct PlannedChannel {
  ChannelShare share;
  PlannedBlocks shown;
  AlgorithmCosts costs;
  Forecast forecast;

  const AlgorithmCost& chosen() const { return costs[static_cast<size_t>(share.frame.algorithm)]; }
};

// `chooser`: of a picture of one channel, see Planner::chooseBlocksBy(). `texels`: of the device
// that draws. Throws Error before a block is listed if the memory has no room for the plans.
std::vector<PlannedChannel> plannedChannels(const std::vector<ChannelShare>& shares,
                                            Combine combine, BlockChooser* chooser,
                                            TexelPlace texels, WorkerPool& pool);

// The cost of a channel, or of all channels together.
struct PlannedSum {
  int64_t white = 0, grey = 0, black = 0;
  AlgorithmCosts costs = {};
  Forecast forecast = {};
  double classify_seconds = 0;
};
PlannedSum costOf(const PlannedChannel& channel);
// Requires: at least one channel.
PlannedSum sumOf(std::span<const PlannedChannel> channels);

}  // namespace sluice
