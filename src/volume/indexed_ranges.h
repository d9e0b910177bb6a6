// indexedRanges: the min-max arrays of a volume, from its index where there is one, otherwise built
// in one pass over the voxels and kept for the next opening.
#pragma once

#include <filesystem>
#include <string>

#include "src/base/worker_pool.h"
#include "src/volume/slice_ranges.h"

namespace sluice {

struct IndexedRanges {
  SliceRanges ranges;
  std::filesystem::path path;  // of the index file; empty when none could be kept
  std::string state;           // "read", "built", or "built, not kept"
  std::string note;            // why it was not kept, or not beside the volume; empty otherwise
};

// Throws Error when the source cannot be read, Interrupted. A damaged or stale index is rebuilt.
IndexedRanges indexedRanges(VolumeSource& source, int64_t time, const BlockLayout& layout,
                            WorkerPool& pool);

}  // namespace sluice
