// The cost of a picture, from the plan alone: bytes to read, peak memory, and whether this machine
// has that much. Pure functions.
#pragma once

#include <nlohmann/json.hpp>

#include <cstdint>

#include "src/classify/blocks/classification.h"
#include "src/render/camera/frame_options.h"
#include "tools/scene/scene.h"

namespace sluice {

struct Forecast {
  int64_t blocks = 0;        // blocks that show something
  uint64_t voxel_bytes = 0;  // decoded bytes of those blocks, as a first frame reads them
  // The memory that --memory bounds: its value, the least that works, and the frame's need.
  uint64_t budget_bytes = 0, least_bytes = 0, buffer_bytes = 0;
  uint64_t index_bytes = 0;  // the part of buffer_bytes for the min-max arrays
  // The part of buffer_bytes for the picture, or for a strip of it, until it is written.
  uint64_t picture_bytes = 0;
  uint64_t program_bytes = 0;  // in addition to it: the program and its driver
  uint64_t machine_bytes = 0;  // limit for this process

  uint64_t peakBytes() const { return buffer_bytes + program_bytes; }
  bool fits() const { return least_bytes <= budget_bytes && peakBytes() <= machine_bytes; }
};

// `plan_bytes`: bytes of the textures that the chosen algorithm makes, which count on software GL,
// whose textures live in memory. `others_bytes`: see othersBytes().
Forecast forecastOf(const IndexedVolume& volume, const VisibleBlocks& shown, uint64_t plan_bytes,
                    uint64_t others_bytes, const FrameOptions& frame,
                    const ResourceArguments& resources);

// `read` and `memory` of plan's JSON.
nlohmann::json readJson(const Forecast& forecast);
nlohmann::json memoryJson(const Forecast& forecast);
void printForecast(const Forecast& forecast);

}  // namespace sluice
