#include "cache/simulate/bench_simulate.h"

#include <algorithm>
#include <ctime>

#include "cache/policies/random.h"
#include "cache/simulate/miss_ratio_curve.h"
#include "cache/simulate/simulator.h"

namespace sluice {
namespace {

double threadSeconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + static_cast<double>(now.tv_nsec) * 1e-9;
}

}  // namespace

SimulateBenchResult benchSimulate(const SimulateBenchOptions& options) {
  Random random(options.seed);
  std::vector<Key> keys(options.requests);
  for (Key& key : keys) key = random.below(options.distinct);
  const PreparedTrace trace = prepareUnit(keys);
  const auto count = static_cast<double>(options.requests);
  SimulationConfig config;
  config.pages = options.cache_pages;
  SimulateBenchResult result;
  for (int i = 0; i < options.repeats; ++i) {
    const double start_s = threadSeconds();
    result.lru_misses = simulate(trace, config).misses;
    const double middle_s = threadSeconds();
    const MissRatioCurve curve = lruCurve(trace);
    const double end_s = threadSeconds();
    result.lru = std::max(result.lru, count / (middle_s - start_s));
    result.curve = std::max(result.curve, count / (end_s - middle_s));
    result.curve_misses = static_cast<uint64_t>(curve.missesAt(options.cache_pages));
  }
  return result;
}

}  // namespace sluice
