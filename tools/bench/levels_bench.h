// sluice bench levels: what drawing coarser levels of resolution costs and saves.
#pragma once

#include <nlohmann/json.hpp>

#include "tools/bench/frame_bench.h"

namespace sluice {

// Pictures at pixel errors of 0.5, 1, 2 and 4 and of level 0, each compared with the truth: level 0
// with four pixels for one along each axis and half the distance between slices. `read_bytes`:
// stored voxels of the blocks that a picture needs. `detail` and `truth_detail`: see PictureError.
// Throws Error if the volume has one level.
nlohmann::json benchLevels(const FrameBench& bench);
void printLevels(const nlohmann::json& report);

}  // namespace sluice
