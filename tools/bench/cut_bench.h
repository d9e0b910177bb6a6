// sluice bench cut: the time to plan a picture of a volume that is too large for any disk at hand.
#pragma once

#include <nlohmann/json.hpp>

#include "src/base/values/vec.h"
#include "src/render/camera/frame_options.h"

namespace sluice {

struct CutBench {
  Vec3i dims{16821, 7494, 2070};
  FrameOptions frame;
  int threads = 0;  // 0: one a core
  int frames = 9;   // plans measured for each kind
};

// Plans pictures of a pyramid of means with spreads: an ellipsoid of nested shells. Its min-max
// arrays come from a function, and no voxel exists. Measures the first plan, plans of other
// thresholds, and plans of other views: of the whole volume, and from close by. Throws Error.
nlohmann::json benchCut(const CutBench& bench);
void printCut(const nlohmann::json& report);

}  // namespace sluice
