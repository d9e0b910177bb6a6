// sluice bench simulate and bench slicing: the speed of the models that need no picture.
#include "cache/simulate/bench_simulate.h"
#include "src/slicing/slicing_cost.h"
#include "tools/bench/bench.h"
#include "tools/command_line/console.h"

namespace sluice {
namespace {

using nlohmann::json;

json simulatorReport() {
  const SimulateBenchResult result = benchSimulate({});
  return {{"requests_per_second", {{"lru", result.lru}, {"curve", result.curve}}}};
}

void printSimulator(const json& report) {
  const json& rates = report["requests_per_second"];
  say("LRU {:.1f}, exact curve {:.1f} million page requests a second on one core\n",
      rates["lru"].get<double>() / 1e6, rates["curve"].get<double>() / 1e6);
}

json slicingReport() {
  constexpr int kViews = 9;
  constexpr uint64_t kSeed = 1;
  const SlicingCost cost = slicingCost(kViews, kSeed);
  return {{"slices", cost.slices},
          {"plain_ns", cost.plain_ns},
          {"incremental_ns", cost.incremental_ns},
          {"ratio", cost.ratio()}};
}

void printSlicing(const json& report) {
  say("{:.1f} ns a slice incrementally, {:.1f} ns from scratch: {:.2f} of it; {} slices a view\n",
      report["incremental_ns"].get<double>(), report["plain_ns"].get<double>(),
      report["ratio"].get<double>(), report["slices"].get<int64_t>());
}

}  // namespace

Bench addSimulatorBench(CLI::App& app) {
  return {app.add_subcommand("simulate",
                             "Measures the simulator's page requests per second, on one core"),
          [](const Show& show) { return show(simulatorReport(), printSimulator); }};
}

Bench addSlicingBench(CLI::App& app) {
  return {
      app.add_subcommand(
          "slicing",
          "Measures cutting boxes by a view's slices, incrementally and from scratch, on one core"),
      [](const Show& show) { return show(slicingReport(), printSlicing); }};
}

}  // namespace sluice
