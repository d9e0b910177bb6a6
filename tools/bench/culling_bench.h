// sluice bench culling: the results of Gao 2004 on culling over a series: blocks drawn per step
// with culling and without (Figure 7), coherent blocks (Figure 9), pixels checked (Figure 10), the
// optimum against POF and OPOF over 18 views (Figure 11), fusion thresholds (Table 1), blocks a
// rank (Figure 12), and the time of the whole series.
#pragma once

#include <nlohmann/json.hpp>

#include "src/render/camera/frame_options.h"
#include "tools/options/arguments.h"

namespace sluice {

struct CullingBench {
  VolumeArguments volume;
  LookArguments look;
  FrameOptions frame;
  ResourceArguments resources;
  CullingArguments culling;
  int views = 18;              // views of a turn
  bool no_optimum = false;     // early ray termination at block level: reads every step whole
  bool no_series = false;      // drawn with each way of culling, from cold files
  bool no_thresholds = false;  // Table 1: makes the functions five times
};

// The names of the interface, and in addition `views` [{`azimuth`, `blocks_nonempty`, `visible`}]
// of the first step and `average` [{`time`, `blocks_nonempty`, `visible`}] over all views, and
// `ranks` [{`ranks`, `blocks` of each over all steps, `most_to_mean`, `most_to_mean_dealt_once`,
// `steps`}]. Throws Error.
nlohmann::json benchCulling(const CullingBench& bench);
void printCulling(const nlohmann::json& report);

}  // namespace sluice
