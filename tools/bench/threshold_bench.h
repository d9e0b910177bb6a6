// sluice bench threshold: from a changed transfer function to the finished picture, and the time of
// a renderer without min-max arrays for the same.
#pragma once

#include <nlohmann/json.hpp>

#include "src/render/camera/frame_options.h"
#include "tools/options/arguments.h"

namespace sluice {

struct ThresholdBench {
  VolumeArguments volume;
  LookArguments look;  // the threshold to start from; by default a share of the value range
  FrameOptions frame;
  ResourceArguments resources;
  int changes = 24;  // changes of each kind
};

// The names of the interface, and in addition `walk` and `band` changes, the parts of each change,
// with each picture drawn `again` and the processor's time of both, a threshold `raised_by_a_fifth`
// from ones drawn before, and the same changes `cold` (a session that holds nothing) and
// `out_of_core` (memory for a quarter of the picture's need). Throws Error.
nlohmann::json benchThreshold(const ThresholdBench& bench);
void printThreshold(const nlohmann::json& report);

}  // namespace sluice
