// sluice bench occlusion: Li's Table 2 and the data of Figure 6 for any set of volumes: frames a
// second of every block drawn whole (Basic), of the visible growing boxes (ESS), of these with the
// opacity map asked in vain (ESS+M), with hidden boxes culled (ESS+C), and clipped too (ESS+CC). In
// addition the device's own methods without a map: object boxes, and if the device can, rays that
// leap inside them and end behind opaque matter.
#pragma once

#include <nlohmann/json.hpp>

#include "src/render/frame/frame_run.h"
#include "tools/bench/volumes_bench.h"

namespace sluice {

struct OcclusionBench {
  VolumesBench volumes;
  int adapt_frames = 0;
  // The number of map updates that frames begin with, from which it adapts in a window of 3 to
  // either side (section 4.4). The paper's is 9.
  int updates = FrameLessons::kUpdates.first;
};

// {"rows": [...], "mean": {...}}: one object a volume, the names of the interface. Percentages are
// of what ESS draws: culled and clipped of its cells, skipped of its samples; `stopped_percent` of
// its samples, those in boxes that ESS+CC drew but did not take, since the ray had ended or the
// pixel was opaque; `map_updates` those that ESS+CC wanted and made. Under `updates`: the numbers
// of map updates wanted and made, frame by frame, of `adapt_frames` frames of each of four views.
//
// Transfer functions of a threshold or of none become surface-like: 80 times as opaque. Each way
// draws its frames in a row, since the number of updates adapts from frame to frame. Throws Error.
nlohmann::json benchOcclusion(const OcclusionBench& bench);
void printOcclusion(const nlohmann::json& report);

}  // namespace sluice
