// indexedRanges: the min-max arrays of a volume and its brick ranges, from its index if there is
// one, otherwise built in one pass over the voxels and kept for the next opening.
//
// src/index/index_file.h documents where the index lies.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "src/base/sources/voxel_taker.h"
#include "src/index/index_file.h"
#include "src/volume/passes/volume_pass.h"
#include "src/volume/ranges/brick_ranges.h"
#include "src/volume/ranges/slice_ranges.h"

namespace sluice {

struct IndexedRanges {
  SliceRanges ranges;
  BrickRanges bricks;          // the same for any size of block
  std::filesystem::path path;  // the index file; empty when none could be kept
  IndexOrigin origin = IndexOrigin::kNotMade;
  // A line for people that tells why an older index was not believed or why this one was not kept.
  // Empty when the index was read, or built where it belongs.
  std::string note;

  uint64_t bytes() const { return ranges.bytes() + bricks.bytes(); }
};

// The index that was kept, if there is an intact one of this volume; nothing is read of the volume.
std::optional<IndexedRanges> keptRanges(const VolumeSource& source, const IndexPlaces& places,
                                        int64_t time, const BlockLayout& layout);

// The same of blocks of any size, with any border: the largest blocks that are kept. Range, counts
// and bricks are those of an index of other blocks.
std::optional<IndexedRanges> keptRangesOfAnyBlocks(const VolumeSource& source,
                                                   const IndexPlaces& places, int64_t time);

// Ranges of some blocks, which pictures have learnt (src/volume/ranges/learnt_ranges.h), for a
// volume that has no index: nullopt if none are kept, or not of its present state. Range and counts
// of the values are those that keepLearnt() was given.
std::optional<SliceRanges> keptLearnt(const VolumeSource& source, const IndexPlaces& places,
                                      int64_t time, const BlockLayout& layout);
// Keeps them for later openings, if that is possible.
void keepLearnt(const VolumeSource& source, const IndexPlaces& places, int64_t time,
                const SliceRanges& ranges);

// `places`: where the index is kept, by the user's name for the volume (the first of several
// names). Throws Error when the source cannot be read, Interrupted. A damaged or stale index is
// rebuilt within the memory of the pass (first_pass.h, whose Error names the least that works); one
// that cannot be kept is no failure. `taker`, if there is one, gets the voxels in the same pass, or
// in one of its own if there is an index already.
IndexedRanges indexedRanges(VolumeSource& source, const IndexPlaces& places, int64_t time,
                            const BlockLayout& layout, const VolumePass& pass,
                            VoxelTaker* taker = nullptr);

}  // namespace sluice
