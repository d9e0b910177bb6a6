#include "src/texture/requests.h"

namespace sluice {

TraceRecord requestFor(const TexturePlan& plan, int64_t chunk, uint64_t name, int64_t cluster,
                       int64_t frame) {
  const Chunk& wanted = plan.chunks[static_cast<size_t>(chunk)];
  return {name, static_cast<uint32_t>(wanted.pages), static_cast<uint32_t>(cluster),
          static_cast<uint32_t>(frame), plan.loadBytes(wanted)};
}

std::vector<TraceRecord> frameRequests(const TexturePlan& plan, const std::vector<uint64_t>& names,
                                       const EyePosition& eye, int64_t frame) {
  std::vector<TraceRecord> records;
  for (const int64_t cluster : clusterOrder(plan, eye))
    for (const int64_t chunk : plan.clusters[static_cast<size_t>(cluster)].chunks)
      records.push_back(requestFor(plan, chunk, names[static_cast<size_t>(chunk)], cluster, frame));
  return records;
}

int64_t bindCount(const TexturePlan& plan, const EyePosition& eye) {
  int64_t binds = 0;
  if (plan.chunks.size() == plan.blocks.size()) {  // in any order
    for (const TextureBlock& block : plan.blocks) binds += block.cells.empty() ? 0 : 1;
    return binds;
  }
  for (const int64_t position : clusterOrder(plan, eye)) {
    const Cluster& cluster = plan.clusters[static_cast<size_t>(position)];
    int64_t bound = -1;
    for (const int64_t at : blockOrder(plan, cluster, eye)) {
      const TextureBlock& block = plan.blocks[static_cast<size_t>(at)];
      if (block.cells.empty() || block.chunk == bound) continue;
      bound = block.chunk;
      ++binds;
    }
  }
  return binds;
}

}  // namespace sluice
