// The plan of a picture as people and scripts read it.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include <optional>
#include <vector>

#include "src/library/drawing/cost/planned_channels.h"
#include "tools/plan/plan_boxes.h"

namespace sluice {

struct PlanToReport {
  const std::vector<PlannedChannel>& channels;
  const std::vector<PlannedBoxes>& boxes;  // of each channel, or empty
  Algorithm algorithm = Algorithm::kMerged;
};

// The report but for the command and its options: of all channels, and of each if there are
// several.
nlohmann::json reportOf(const PlanToReport& plan);
// The tables of all channels.
void printTables(const PlanToReport& plan);
// The lines about the channels' indices and their growing boxes.
void printIndices(const PlanToReport& plan);

}  // namespace sluice
