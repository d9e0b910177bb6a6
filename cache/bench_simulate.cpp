#include "cache/bench_simulate.h"

#include <algorithm>
#include <utility>

#include "cache/miss_ratio_curve.h"
#include "cache/random.h"
#include "cache/simulator.h"
#include "src/base/clock.h"

namespace sluice {

SimulateBenchResult benchSimulate(const SimulateBenchOptions& options) {
  Random random(options.seed);
  std::vector<Key> keys(options.requests);
  for (Key& key : keys) key = random.below(options.distinct);
  const PreparedTrace trace = prepareUnit(std::move(keys));
  const auto count = static_cast<double>(options.requests);
  SimulationConfig config;
  config.pages = options.cache_pages;
  SimulateBenchResult result;
  for (int i = 0; i < options.repeats; ++i) {
    Stopwatch watch;
    result.lru_misses = simulate(trace, config).misses;
    result.lru = std::max(result.lru, count / watch.lap());
    const MissRatioCurve curve = lruCurve(trace);
    result.curve = std::max(result.curve, count / watch.lap());
    result.curve_misses = static_cast<uint64_t>(curve.missesAt(options.cache_pages));
  }
  return result;
}

}  // namespace sluice
