// DrawOrder: in which order a view visits a plan, the fifth value of a frame's chain. Immutable.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "src/texture/texture_plan.h"

namespace sluice {

enum class Arrangement {
  kRows,    // a cluster's blocks row by row
  kLayers,  // a cluster's blocks in layers across the view: the front layer comes first all over it
  kWhole,   // the same over all clusters, which are there at once
};

// A cluster whose chunks are made resident, and the blocks drawn then: all chunks since the last
// visit that drew stay resident until it has drawn.
struct Visit {
  ClusterPosition cluster;
  bool draws = true;
  std::vector<BlockPosition> blocks;  // front to back
};

struct DrawOrder {
  EyePosition eye;
  std::vector<Visit> visits;  // front to back
};
using DrawOrderPtr = std::shared_ptr<const DrawOrder>;

// Visits each cluster of the plan once, and each block once, in the order from the eye. Pure.
DrawOrder makeDrawOrder(const TexturePlan& plan, const EyePosition& eye, Arrangement arrangement);

}  // namespace sluice
