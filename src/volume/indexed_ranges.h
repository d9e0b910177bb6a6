// indexedRanges: the min-max arrays of a volume, from its index where there is one, otherwise built
// in one pass over the voxels and kept for the next opening.
//
// The index lies where io/index_file.h says: beside the volume; in the user's cache folder where
// that cannot be written, and for synthetic volumes, which have no place of their own.
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
  // One line for a person; empty when the index was read, or built where it belongs: why an older
  // one was not believed, why this one was not kept, or not beside the volume.
  std::string note;
};

// `volume_name` is what the user called the volume (the first of several names): where its index
// is kept. Throws Error when the source cannot be read, Interrupted. A damaged or stale index is
// rebuilt, which holds at most `most_bytes` of voxels; one that cannot be kept is no failure.
IndexedRanges indexedRanges(VolumeSource& source, const std::string& volume_name, int64_t time,
                            const BlockLayout& layout, WorkerPool& pool,
                            uint64_t most_bytes = kMostIndexingBytes);

}  // namespace sluice
