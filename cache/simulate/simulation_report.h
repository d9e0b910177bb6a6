// SimulationReport: everything that the HTML report of a simulation shows, as plain data. All in it
// but the rows is made for that report alone. Pure functions of their arguments, like the
// simulator.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "cache/model/texture_cache.h"
#include "cache/simulate/miss_ratio_curve.h"
#include "cache/simulate/simulator.h"

namespace sluice {

struct SimulationReport {
  std::string title;  // for people: the trace's name
  // The trace that was replayed and the options, shown as they are.
  std::vector<std::pair<std::string, std::string>> facts;

  uint64_t page_bytes = 0;
  PolicyKind chosen_policy = PolicyKind::kLru;  // an online one
  uint64_t chosen_pages = 0;
  std::vector<SimulationRow> rows;    // policies x sizes
  std::optional<MissRatioCurve> lru;  // at every size, if all rows belong to one trace

  // The cache under the chosen policy and size, sampled evenly over the requests.
  struct Sample {
    uint64_t request = 0;     // requests so far
    uint64_t this_frame = 0;  // pages requested in the current frame; 0 if frames are not known
    uint64_t earlier = 0;     // pages kept from earlier frames
  };
  std::vector<Sample> residency;
  bool knows_frames = false;
  // The first pages at the end of the trace, a chunk a page, TextureCache::kNoChunk if free.
  static constexpr uint64_t kMostPagesShown = 4096;
  std::vector<ChunkId> page_map;
};

// The trace that was replayed and the options, for people.
std::vector<std::pair<std::string, std::string>> factsOf(const PreparedTrace& trace,
                                                         const SimulationConfig& chosen);

// Replays the trace under `chosen` for the residency and the page map. `rows` are taken as they
// are; `is_one_trace`: all of them are of `trace`. Requires: chosen.policy is an online one;
// chosen.pages > 0.
SimulationReport makeReport(const PreparedTrace& trace, std::string title,
                            std::vector<SimulationRow> rows, bool is_one_trace,
                            const SimulationConfig& chosen);

// Sizes for a table: the powers of two from the first that holds the heaviest chunk to the first
// that holds all, at most 20, and `chosen_pages`. Ascending.
std::vector<uint64_t> defaultSizes(const PreparedTrace& trace, uint64_t chosen_pages);

}  // namespace sluice
