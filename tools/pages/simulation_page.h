// The HTML page of simulations: one file, nothing loaded from outside, drawings as inline SVG.
#pragma once

#include <span>
#include <string>

#include "cache/simulate/simulation_report.h"

namespace sluice {

// The page: for each report its facts, miss ratio by cache size (a line a policy, the optimum, LRU
// at every size and the chosen size marked), residency over time, how chunks lie in pages, bytes by
// cause, and the rows as a table. After several reports of the channels of a picture, the rows
// of all channels together (`sums`) as a table. A pure function; titles and facts are escaped.
// Requires: at least one report.
std::string simulationPage(std::span<const SimulationReport> reports,
                           std::span<const SimulationRow> sums = {});

}  // namespace sluice
