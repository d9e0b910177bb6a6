// VolumePass: the threads, the watcher, the limit and the stop token of a pass over a volume's
// voxels.
#pragma once

#include <cstdint>
#include <functional>

#include "src/base/threads/progress_meter.h"
#include "src/base/threads/stop_token.h"
#include "src/base/threads/worker_pool.h"

namespace sluice {

// The memory of a pass that is refused, and the budgets that the refusal names for all of the
// volume.
struct PassNeeds {
  double array_bytes = 0;  // of min-max arrays, which stay in memory
  double least_bytes = 0;  // with which the pass is made
};
struct PassBudgets {
  double look_bytes = 0;  // at least those of the pass
  double draw_bytes = 0;  // whatever a picture shows
};

// Refers to the caller's pool and meter, which must outlive the pass.
struct VolumePass {
  WorkerPool& pool;
  ProgressMeter& progress;             // its total grows by the bytes that the pass reads
  uint64_t memory_bytes = UINT64_MAX;  // limit for all threads together
  StopToken stop = {};                 // ends the pass with Interrupted
  // Asked if the limit does not even suffice for the pass; null: the least of the pass is named.
  std::function<PassBudgets(const PassNeeds& needs)> budgets = {};
};

}  // namespace sluice
