// The HTML report of a simulation: one file, nothing loaded from outside, drawings as inline SVG.
#pragma once

#include <string>

#include "cache/simulate/simulation_report.h"

namespace sluice {

// The page: facts, miss ratio by cache size (the optimum and the chosen size marked), residency
// over time, how chunks lie in pages, bytes by cause, and the rows as a table. A pure function;
// the title and facts are escaped.
std::string htmlReport(const SimulationReport& report);

}  // namespace sluice
