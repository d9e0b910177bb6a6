// The requests that a frame makes of the texture cache: those of its clusters in visiting order.
// The renderer makes them of the model one by one and records them; the simulator makes the same
// list from a plan alone (design, point 1). Pure functions.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "cache/trace/trace.h"
#include "src/texture/texture_plan.h"

namespace sluice {

// The record for `chunk` of the plan, named `name`, wanted by `cluster`.
TraceRecord requestFor(const TexturePlan& plan, ChunkPosition chunk, ChunkName name,
                       ClusterPosition cluster, int64_t frame);

// All of a frame's. `names` are of plan.chunks.
std::vector<TraceRecord> frameRequests(const TexturePlan& plan, const ChunkNameList& names,
                                       const EyePosition& eye, int64_t frame);
// The same of a frame that visits the clusters in this order.
std::vector<TraceRecord> frameRequests(const TexturePlan& plan, const ChunkNameList& names,
                                       std::span<const ClusterPosition> order, int64_t frame);

// How often drawing the plan's blocks front to back changes from one chunk to another.
int64_t bindCount(const TexturePlan& plan, const EyePosition& eye);

}  // namespace sluice
