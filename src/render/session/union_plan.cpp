#include "src/render/session/union_plan.h"

#include <algorithm>
#include <map>
#include <utility>

namespace sluice {
namespace {

VisibleBlocks unionOf(std::span<const ChannelBlocks> channels) {
  std::map<std::pair<int32_t, int64_t>, ObjectBlock> blocks;  // channels may show other time steps
  for (const ChannelBlocks& channel : channels)
    for (const ObjectBlock& object : channel.visible->blocks) {
      const auto [found, fresh] =
          blocks.emplace(std::pair(object.name.level, object.name.block), object);
      if (!fresh) found->second.cells = unite(found->second.cells, object.cells);
    }
  VisibleBlocks all;
  all.share = channels.front().visible->share;  // the same of all channels
  const int64_t time = blocks.empty() ? 0 : blocks.begin()->second.name.time;
  for (auto& [place, object] : blocks) {
    object.name.time = time;
    object.trimming_axis = shortestAxis(object.cells.size());
    all.blocks.push_back(object);
  }
  return all;
}

}  // namespace

TexturePlan unionPlan(std::span<const ChannelBlocks> channels, PlanOptions options) {
  const VisibleBlocks all = unionOf(channels);
  const auto capacity = [&](const ChannelBlocks& channel) {
    return clusterCapacity(channel.pyramid, all, channel.page);
  };
  const auto tightest = std::ranges::min_element(channels, {}, capacity);
  // Chunks are the channels' own.
  if (options.algorithm == Algorithm::kMerged) options.algorithm = Algorithm::kTrimmed;
  return planTextures(tightest->pyramid, all, tightest->page, options);
}

}  // namespace sluice
