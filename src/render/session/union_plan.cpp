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
      // The texture block of the union must hold what any channel shows.
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
  // A cluster must fit the cache of each channel.
  const auto tightest = std::ranges::min_element(channels, {}, capacity);
  // Chunks are the channels' own.
  if (options.algorithm == Algorithm::kMerged) options.algorithm = Algorithm::kTrimmed;
  return planTextures(tightest->pyramid, all, tightest->page, options);
}

Algorithm blendedAlgorithm(Algorithm asked, std::span<const VisibleBlocksPtr> channels) {
  const bool has_coarse = std::ranges::any_of(
      channels, [](const VisibleBlocksPtr& visible) { return areOfSeveralLevels(*visible); });
  return has_coarse && loadsWholeBlocks(asked) ? Algorithm::kTrimmed : asked;
}

ClusterPlace placeOf(const Cluster& cluster) {
  const Vec3i at = cluster.index;
  return {static_cast<int64_t>(cluster.grid), at.x, at.y, at.z};
}

std::vector<ClusterPosition> ownClusters(const TexturePlan& own, const TexturePlan& all,
                                         std::span<const ClusterPosition> order) {
  std::map<ClusterPlace, ClusterPosition> places;
  // Own clusters are found by their place in the grids, since positions differ between plans.
  for (const ClusterPosition i : own.clusters.indices())
    places.emplace(placeOf(own.clusters[i]), i);
  std::vector<ClusterPosition> clusters;
  clusters.reserve(places.size());
  for (const ClusterPosition each : order)
    if (const auto found = places.find(placeOf(all.clusters[each])); found != places.end())
      clusters.push_back(found->second);
  return clusters;
}

}  // namespace sluice
