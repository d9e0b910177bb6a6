// Prefetch models: the gain and the harm of loading chunks ahead of their cluster.
//
// The chunks of a visit (a cluster in a frame) are requested and pinned. Then the model names
// another visit, whose chunks that are not resident are loaded without evicting pinned ones. Chunks
// that do not fit in addition to these are left out. A pure function, like the simulator; it has no
// clock, so it tells which loads come ahead of time, not how many seconds that hides.
//   next-cluster    the next visit of the same frame: the plan gives the order
//   next-time-step  the same cluster in the next frame: each frame shows the next time step
//   last-order      the visit that followed this cluster in the frame before: no plan needed, wrong
//                   if the view changes the order
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

#include "cache/policies/policy.h"
#include "cache/trace/trace.h"

namespace sluice {

enum class PrefetchModel { kNextCluster, kNextTimeStep, kLastOrder };
std::string_view name(PrefetchModel model);

struct PrefetchConfig {
  PrefetchModel model = PrefetchModel::kNextCluster;
  PolicyKind policy = PolicyKind::kLru;  // an online one
  uint64_t pages = 256;
  uint64_t seed = 1;
  bool pin_clusters = true;  // see SimulationConfig
};

// Counts of page requests and pages.
struct PrefetchResult {
  uint64_t requests = 0;        // by demand
  uint64_t misses = 0;          // by demand, with prefetching
  uint64_t misses_without = 0;  // misses of the same cache without prefetching
  uint64_t prefetched = 0;      // loaded ahead
  uint64_t used = 0;            // prefetched, then requested before they were evicted
  uint64_t polluted = 0;        // demand misses that are hits without prefetching

  // The share of the chunks loaded ahead that was used; nullopt if nothing was loaded ahead.
  std::optional<double> accuracy() const {
    if (prefetched == 0) return std::nullopt;
    return share(used, prefetched);
  }
  // Share of the chunks' loads that were ahead of time; 0 when there were none.
  double coverage() const { return share(used, used + misses); }
  // Share of the demand requests that prefetching turned from hits into misses.
  double pollution() const { return share(polluted, requests); }

 private:
  static double share(uint64_t part, uint64_t whole) {
    return whole == 0 ? 0 : static_cast<double>(part) / static_cast<double>(whole);
  }
};

// Requires: config.pages > 0; the trace carries clusters.
PrefetchResult simulatePrefetch(const Trace& trace, const PrefetchConfig& config);

}  // namespace sluice
