// VolumePass: the threads, the watcher, the limit and the stop token of a pass over a volume's
// voxels.
#pragma once

#include <cstdint>

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
};

}  // namespace sluice
