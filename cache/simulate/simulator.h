// The simulator: a pure function of (trace, configuration). No clock, no device, no thread; the
// same arguments give the same row on every machine.
//
// The model leaves out: time (nothing overlaps, see cost_model.h), levels 1 to 3, the processor's
// own texture caches, placement (any free page takes any part of a chunk, so memory never fragments
// outside pages), and a driver that evicts on its own. Residency starts empty.
//
// Misses by class, in pages, so that compulsory + capacity + conflict = misses:
//   compulsory  the first request of a chunk
//   capacity    further misses of a fully associative LRU cache of the same pages
//   conflict    the rest: the loss of the policy at hand against that LRU. Negative if it does
//               better; zero for LRU itself
// A request that does not fit, even with only the pinned chunks resident, is a failure: the
// renderer would stop there and report it. Each time it counts as missed and costs as much as
// loading the chunk, as if it went through memory that is not the cache's; it is never resident.
//
// The model draws nothing, so it does not know how often the renderer goes back and forth between a
// cluster's chunks (the renderer's `binds`): the seconds take one bind a chunk request, the least.
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "cache/policies/policy.h"
#include "cache/simulate/cost_model.h"
#include "cache/trace/prepared_trace.h"
#include "src/base/threads/counters.h"

namespace sluice {

struct SimulationConfig {
  PolicyKind policy = PolicyKind::kLru;
  uint64_t pages = 256;  // > 0
  // Keep the chunks of a cluster once requested until the next cluster, as the renderer does, if
  // the trace carries clusters. Ignored by kBeladyPages.
  bool pin_clusters = false;
  uint64_t seed = 1;  // for kRandom
  CostModel costs = {};
};

struct SimulationRow {
  PolicyKind policy = PolicyKind::kLru;
  uint64_t pages = 0;  // capacity
  // Page requests.
  uint64_t requests = 0, hits = 0, misses = 0;
  int64_t compulsory = 0, capacity = 0, conflict = 0;
  // Chunk requests, loads and evictions; bytes are whole pages. For kBeladyPages, which loads
  // parts of chunks, all of it counts pages instead, and a load of pages of a chunk that had been
  // loaded before is redundant.
  CacheCounters chunks;
  uint64_t pages_loaded = 0;
  // The bytes that loads moved, by cause: moved is bytes_moved, needed is bytes_needed. Failed
  // requests are included.
  LoadBytes bytes;
  // Chunk requests that did not fit, their pages, and the bytes moved for them.
  uint64_t failures = 0, failed_pages = 0, failed_bytes = 0;
  double modelled_seconds = 0;
  // The cache size in pages that the chunks were planned for, if they were planned.
  std::optional<uint64_t> planned_pages;
  // The trace, the page size and the channel of this row, if several are simulated; else empty.
  std::string trace, page, channel;

  // Page misses of all page requests; 1 for an empty trace.
  double missRatio() const {
    return requests == 0 ? 1 : static_cast<double>(misses) / static_cast<double>(requests);
  }
};

// Requires: config.pages > 0. `lru_misses`: page misses of LRU at this size if the caller knows
// them; simulated otherwise.
SimulationRow simulate(const PreparedTrace& trace, const SimulationConfig& config,
                       std::optional<uint64_t> lru_misses = std::nullopt);
// Every policy at every size, sizes in the outer loop. `config` gives all but policy and pages.
std::vector<SimulationRow> simulateTable(const PreparedTrace& trace,
                                         std::span<const PolicyKind> policies,
                                         std::span<const uint64_t> sizes_pages,
                                         SimulationConfig config);

// Counts another cache with `more`, under the same policy: everything is added up, pages and
// seconds, too.
void add(SimulationRow& sum, const SimulationRow& more);

// Empty, or one line that names the broken identity of the header or of the counters.
std::string brokenIdentity(const SimulationRow& row);

// "policy,pages,requests,...": a header line and a line a row, ended by newlines. Rows that name
// their trace, page size or channel have it in columns at the end; names with commas or quotes are
// quoted.
std::string toCsv(std::span<const SimulationRow> rows);
// The same as a list of objects, less the labels. Unknown values are empty there, null here.
nlohmann::json rowsJson(std::span<const SimulationRow> rows);

}  // namespace sluice
