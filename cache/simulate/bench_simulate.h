// The two speeds that `sluice bench simulate` prints: unit page requests a second, on one core.
//
// lru    simulate() with LRU at `cache_pages` pages
// curve  lruCurve(), the exact curve
// over the same trace: `requests` requests of `distinct` pages drawn evenly with `seed`, which is
// the worst case, since nothing is near in memory or in the stack. The trace is made beforehand and
// not counted. Seconds are the thread's own on the processor and the best of `repeats` runs is
// given, since the machine may be shared.
#pragma once

#include <cstddef>
#include <cstdint>

namespace sluice {

struct SimulateBenchOptions {
  size_t requests = 20'000'000;
  uint32_t distinct = 1'000'000;
  uint64_t cache_pages = 500'000;
  uint64_t seed = 1;
  int repeats = 3;
};

struct SimulateBenchResult {
  double lru = 0;
  double curve = 0;
  // LRU's page misses by simulation and from the curve. They must be equal, which checks the
  // replay.
  uint64_t lru_misses = 0;
  uint64_t curve_misses = 0;
};

// Requires: all counts > 0.
SimulateBenchResult benchSimulate(const SimulateBenchOptions& options);

}  // namespace sluice
