// sluice bench limit and bench render: this machine's sampling rate, and the frames of a turn.
#pragma once

#include <nlohmann/json.hpp>

#include "tools/scene/scene.h"

namespace sluice {

struct FrameBench {
  VolumeArguments volume;  // not of benchLimit()
  LookArguments look;      // nor this
  FrameOptions frame;
  ResourceArguments resources;
  int frames = 9;  // measured, after 2 warm ones
};

// Full-screen slices of one resident texture: `samples_per_second`. Throws Error.
nlohmann::json benchLimit(const FrameBench& bench);
void printLimit(const nlohmann::json& report);

// The frames of a turn, warm: their seconds, the processor's, their samples, and their share of the
// sampling rate, which is measured too; the last frame's report. Throws Error.
nlohmann::json benchFrames(const FrameBench& bench);
void printFrames(const nlohmann::json& report);

}  // namespace sluice
