// VolumePass: the threads, the watcher, the limit and the stop token of a pass over a volume's
// voxels.
#pragma once

#include <cstdint>
#include <functional>

#include "src/base/threads/progress_meter.h"
#include "src/base/threads/stop_token.h"
#include "src/base/threads/worker_pool.h"

namespace sluice {

// Refers to the caller's pool and meter, which must outlive the pass.
struct VolumePass {
  WorkerPool& pool;
  ProgressMeter& progress;             // its total grows by the bytes that the pass reads
  uint64_t memory_bytes = UINT64_MAX;  // limit for all threads together
  StopToken stop = {};                 // ends the pass with Interrupted
  // The bytes that are enough to draw the volume, if it has so many of min-max arrays; named if the
  // limit does not even suffice for the pass. May be null.
  std::function<uint64_t(uint64_t array_bytes)> enough_to_draw = {};
};

}  // namespace sluice
