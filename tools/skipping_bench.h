// sluice bench skipping: Li's Table 1 for any set of volumes: frames a second of every block drawn
// whole with every sample lit and blended, as without any skipping (Basic), and of the visible
// growing boxes alone (ESS), whose rays go on over samples that show nothing.
#pragma once

#include <nlohmann/json.hpp>

#include <string>
#include <vector>

#include "tools/options.h"

namespace sluice {

struct SkippingBench {
  std::vector<std::string> volumes;  // FILE or FILE@THRESHOLD
  LookArguments look;                // threshold of those without one
  FrameOptions frame;
  ResourceArguments resources;
  OpenOptions open;
  int64_t time = 0;
  int frames = 9;
};

// {"rows": [...], "mean_speedup": ...}: one object a volume, the names of the interface; samples
// and boxes beside them, whole blocks whose rays go on as well ("whole"), and object boxes
// (what `--partition blocks` draws). The ways take turns frame by frame, so that a machine that
// drifts favours none. Throws Error.
nlohmann::json benchSkipping(const SkippingBench& bench);
void printSkipping(const nlohmann::json& report);

}  // namespace sluice
