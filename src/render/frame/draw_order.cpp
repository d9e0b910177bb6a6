#include "src/render/frame/draw_order.h"

namespace sluice {

DrawOrder makeDrawOrder(const TexturePlan& plan, const EyePosition& eye, Arrangement arrangement) {
  DrawOrder order{eye, {}};
  for (const ClusterPosition position : clusterOrder(plan, eye)) {
    const Cluster& cluster = plan.clusters[position];
    Visit visit{.cluster = position, .draws = arrangement != Arrangement::kWhole, .blocks = {}};
    if (arrangement == Arrangement::kRows) visit.blocks = blockOrder(plan, cluster, eye);
    if (arrangement == Arrangement::kLayers) visit.blocks = layerOrder(plan, cluster.blocks, eye);
    order.visits.push_back(std::move(visit));
  }
  if (arrangement == Arrangement::kWhole && !order.visits.empty()) {
    std::vector<BlockPosition> all;
    for (const BlockPosition block : plan.blocks.indices())
      if (!plan.blocks[block].isOfSeam()) all.push_back(block);
    order.visits.back().blocks = layerOrder(plan, all, eye);
    order.visits.back().draws = true;
  }
  return order;
}

}  // namespace sluice
