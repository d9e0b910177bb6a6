// The memory that the first pass over a volume's voxels may take, decided before any is taken.
//
// A pure function of the source's properties; nothing is read.
#pragma once

#include <cstdint>
#include <functional>

#include "src/base/sources/volume_source.h"
#include "src/volume/block_layout.h"
#include "src/volume/passes/volume_pass.h"

namespace sluice {

struct FirstPass {
  int threads = 1;           // threads that may read at once
  uint64_t voxel_bytes = 0;  // limit for all, in addition to the source's own
};

// Fits the pass into `memory_bytes`, of which the source keeps a quarter for its caches
// (holdAtMost). Throws Error, which names the least that works: a thread's decoded chunks and a
// block do not fit, or the min-max arrays of a volume whose blocks may all differ are larger than
// that memory. `threads`: as many as there are. `budgets`: see VolumePass.
FirstPass planFirstPass(VolumeSource& source, int64_t time, const BlockLayout& layout,
                        uint64_t memory_bytes, int threads,
                        const std::function<PassBudgets(const PassNeeds&)>& budgets = {});

// The needs of such a pass.
PassNeeds firstPassNeeds(VolumeSource& source, int64_t time, const BlockLayout& layout);

}  // namespace sluice
