// A channel of the picture that the plan command plans, and what several of them cost together.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include <cstdint>
#include <optional>
#include <vector>

#include "src/library/drawing/picture_cost.h"
#include "tools/plan/plan_boxes.h"

namespace sluice {

// A channel of the picture with its look and its plans. Most volumes have one.
struct PlannedChannel {
  IndexedVolume volume;
  TransferFunction transfer;
  PlannedBlocks shown = {};
  uint64_t others_bytes = 0;  // held in addition to the levels and the picture
  AlgorithmCosts costs = {};
  Forecast forecast = {};
  std::optional<PlannedBoxes> boxes = {};
};

// The cost of all channels together.
struct PlannedSum {
  int64_t white = 0, grey = 0, black = 0;
  AlgorithmCosts costs = {};
  Forecast forecast;
  double classify_seconds = 0;
};
PlannedSum sumOf(const std::vector<PlannedChannel>& channels);

// The report but for the command and its options: of all channels, and of each if there are
// several.
nlohmann::json reportOf(const std::vector<PlannedChannel>& channels, Algorithm algorithm);

void print(const PlannedChannel& channel, Algorithm algorithm);
// The lines about the channel's index and its growing boxes.
void printIndex(const PlannedChannel& channel);

}  // namespace sluice
