// SimulationReport: everything that the HTML report of a simulation shows, as plain data.
// makeReport() is a pure function of its arguments, like the simulator.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "cache/miss_ratio_curve.h"
#include "cache/simulator.h"
#include "cache/texture_cache.h"
#include "cache/trace.h"

namespace sluice {

struct SimulationReport {
  std::string title;  // for people: the trace's name
  // What was replayed and under which options, shown as they are.
  std::vector<std::pair<std::string, std::string>> facts;

  uint64_t page_bytes = 0;
  PolicyKind chosen_policy = PolicyKind::kLru;  // an online one
  uint64_t chosen_pages = 0;
  std::vector<SimulationRow> rows;  // policies x sizes
  MissRatioCurve lru;               // at every size

  // Of the chosen policy and size, sampled evenly over the requests.
  struct Sample {
    uint64_t request = 0;     // chunk requests so far
    uint64_t this_frame = 0;  // pages of chunks requested in the current frame
    uint64_t earlier = 0;     // pages kept from earlier frames
  };
  std::vector<Sample> residency;
  // At the end of the trace, a chunk a page, TextureCache::kNoChunk where free.
  std::vector<ChunkId> page_map;
};

// Simulates every policy at every size, and replays the trace through a TextureCache under `chosen`
// for the residency and the page map. Requires: chosen.policy is an online one; chosen.pages > 0.
SimulationReport makeReport(const Trace& trace, std::string title,
                            std::span<const PolicyKind> policies,
                            std::span<const uint64_t> sizes_pages, const SimulationConfig& chosen);

// Sizes for a table: the powers of two from the first that holds the heaviest chunk to the first
// that holds all, at most 20, and `chosen_pages`. Ascending.
std::vector<uint64_t> defaultSizes(const PreparedTrace& trace, uint64_t chosen_pages);

}  // namespace sluice
