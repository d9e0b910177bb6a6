// Runs of the simulator as people, scripts and spreadsheets read them. Pure functions except for
// printing.
#pragma once

#include <nlohmann/json.hpp>

#include <span>
#include <string>

#include "tools/commands/simulation_run.h"

namespace sluice {

// The interface's `rows` and `pinned`; `curves`: miss ratios by cache size; `runs` if there are
// several; `sum`: rows of all channels together, if there are several.
nlohmann::json simulationJson(std::span<const SimulatedRun> runs,
                              const SimulateArguments& arguments);
std::string simulationCsv(std::span<const SimulatedRun> runs);
void printSimulation(const SimulatedRun& run, const SimulateArguments& arguments);
// The table of all channels together, if there are several.
void printSum(std::span<const SimulatedRun> runs);

}  // namespace sluice
