#include "src/texture/frame_trace.h"

namespace sluice {

TraceRecord requestFor(const TexturePlan& plan, ChunkPosition chunk, ChunkName name,
                       ClusterPosition cluster, int64_t frame) {
  const Chunk& wanted = plan.chunks[chunk];
  return {static_cast<uint64_t>(name.value()),
          static_cast<uint32_t>(wanted.pages),
          static_cast<uint32_t>(cluster.value()),
          static_cast<uint32_t>(frame),
          plan.loadBytes(wanted),
          static_cast<uint32_t>(plan.blocks[wanted.blocks.front()].name.level)};
}

std::vector<TraceRecord> frameRequests(const TexturePlan& plan, const ChunkNameList& names,
                                       const EyePosition& eye, int64_t frame) {
  return frameRequests(plan, names, clusterOrder(plan, eye), frame);
}

std::vector<TraceRecord> frameRequests(const TexturePlan& plan, const ChunkNameList& names,
                                       std::span<const ClusterPosition> order, int64_t frame) {
  std::vector<TraceRecord> records;
  for (const ClusterPosition cluster : order)
    for (const ChunkPosition chunk : plan.clusters[cluster].chunks)
      records.push_back(requestFor(plan, chunk, names[chunk], cluster, frame));
  return records;
}

int64_t bindCount(const TexturePlan& plan, const EyePosition& eye) {
  int64_t binds = 0;
  // One block a chunk (algorithms I to III): each block that is drawn binds once, whatever the
  // order.
  if (plan.chunks.size() == plan.blocks.size()) {  // in any order
    for (const TextureBlock& block : plan.blocks)
      binds += block.cells.empty() || block.isOfSeam() ? 0 : 1;
    return binds;
  }
  for (const ClusterPosition position : clusterOrder(plan, eye)) {
    const Cluster& cluster = plan.clusters[position];
    // Boxes are drawn block by block, so that neighbours in the order that share a chunk bind once.
    ChunkPosition bound(int64_t{-1});
    for (const BlockPosition at : blockOrder(plan, cluster, eye)) {
      const TextureBlock& block = plan.blocks[at];
      if (block.cells.empty() || block.chunk == bound) continue;
      bound = block.chunk;
      ++binds;
    }
  }
  return binds;
}

}  // namespace sluice
