// sluice bench threshold: from a changed transfer function to the finished picture, and what a
// renderer without min-max arrays takes for the same.
#pragma once

#include <nlohmann/json.hpp>

#include "src/render/frame_options.h"
#include "tools/arguments.h"

namespace sluice {

struct ThresholdBench {
  VolumeArguments volume;
  LookArguments
      look;  // the threshold to start from; a share of the value range where none is given
  FrameOptions frame;
  ResourceArguments resources;
  int changes = 24;  // of each kind
};

// The names of the interface, and beside them `walk` and `band` changes, the parts of each change,
// a threshold `raised_by_a_fifth` from ones drawn before, and the same changes `cold` (a session
// that holds nothing) and `out_of_core` (memory for a quarter of what the picture takes). Throws
// Error.
nlohmann::json benchThreshold(const ThresholdBench& bench);
void printThreshold(const nlohmann::json& report);

}  // namespace sluice
