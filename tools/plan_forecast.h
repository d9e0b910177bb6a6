// What a picture will take, from the plan alone: bytes to read, memory at its peak, and whether
// this machine has that much. Pure functions.
#pragma once

#include <nlohmann/json.hpp>

#include <cstdint>

#include "src/classify/blocks/classification.h"
#include "src/render/frame_options.h"
#include "tools/scene.h"

namespace sluice {

struct Forecast {
  int64_t blocks = 0;        // that show something
  uint64_t voxel_bytes = 0;  // of them, decoded: what a first frame reads of an uncompressed file
  // What --memory bounds: its value, the least that works, and what the frame comes to.
  uint64_t budget_bytes = 0, least_bytes = 0, buffer_bytes = 0;
  uint64_t index_bytes = 0;  // of buffer_bytes: the min-max arrays
  // Of buffer_bytes: the picture, or a strip of it, until it is written.
  uint64_t picture_bytes = 0;
  uint64_t program_bytes = 0;  // in addition to it: the program and its driver
  uint64_t machine_bytes = 0;  // what this process may have

  uint64_t peakBytes() const { return buffer_bytes + program_bytes; }
  bool fits() const { return least_bytes <= budget_bytes && peakBytes() <= machine_bytes; }
};

// What a frame holds beside the levels and the picture: min-max arrays and the plan.
uint64_t othersBytes(const IndexedVolume& volume, const VisibleBlocks& shown);

// `plan_bytes`: of the textures that the chosen algorithm makes. On software GL, where textures
// live in memory.
Forecast forecastOf(const IndexedVolume& volume, const VisibleBlocks& shown, uint64_t plan_bytes,
                    const FrameOptions& frame, const ResourceArguments& resources);

// `read` and `memory` of plan's JSON.
nlohmann::json readJson(const Forecast& forecast);
nlohmann::json memoryJson(const Forecast& forecast);
void printForecast(const Forecast& forecast);

}  // namespace sluice
