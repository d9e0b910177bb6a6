// SliceRanges: the three min-max arrays of every block (Tong 1999, section 3.2.1), always resident.
//
// For each block and axis, element i is the least and the greatest voxel of the block's owned plane
// i orthogonal to that axis. Blocks whose voxels all equal one `background` are not held: on disk,
// in memory and in every loop over blocks, a volume costs only its other blocks. Immutable once
// built; any thread may read.
//
// The folder: block_ranges.h is the inner loop that makes the arrays, learnt_ranges.h makes them of
// blocks that pictures read, and brick_ranges.h has ranges of bricks for any size of block.
// far_voxels.h tells which voxels are left out, and byte_order_hint.h whether the values look as if
// their bytes were swapped.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <vector>

#include "src/base/sources/volume_source.h"
#include "src/base/values/value_counts.h"
#include "src/volume/block_layout.h"
#include "src/volume/passes/volume_pass.h"
#include "src/volume/voxels/device_voxel.h"

namespace sluice {

// An element of a min-max array, in device voxels.
template <class T>
struct PlaneRange {
  T lo, hi;
};

struct SliceRanges {
  BlockLayout layout;
  ValueMap map;
  double background = 0;        // device value of every voxel of the blocks that are not held
  std::vector<int64_t> blocks;  // ids of the held blocks, ascending
  // PlaneRange<T> of each held block, of all its owned voxels.
  std::vector<std::byte> totals;
  // PlaneRange<T>[held][axis][plane], layout.planes() an axis.
  std::vector<std::byte> planes;
  // Ids of the blocks whose values are not known, ascending; none of them is held, and anything may
  // show in them. Only a volume whose finest level has not been read has such blocks.
  std::vector<int64_t> unknown;
  // False: nobody has asked the source yet which blocks it knows to be background without reading a
  // voxel. They are among the unknown ones, and all known blocks are held. See listedRanges().
  bool is_listed = true;
  ValueRange device_range;  // range of all voxels but NaN and infinities; 0, 0 if there are none
  // The range of the finite stored values beyond kLargest, which device voxels cannot tell from
  // infinities; lo > hi: there are none. Only floats have such values.
  ValueRange far_range{1, 0};
  // Device values of all voxels, each counted once though blocks share planes: the same for any
  // size of block. Voxels that stand for NaN or an infinity are left out.
  ValueCounts counts;
  // The index that they were read from; empty: they were made from the voxels.
  std::filesystem::path index_file = {};

  template <class T>
  std::span<const PlaneRange<T>> totalsAs() const {
    return {reinterpret_cast<const PlaneRange<T>*>(totals.data()), blocks.size()};
  }
  // The array of one held block (by its position in `blocks`) and axis.
  template <class T>
  std::span<const PlaneRange<T>> planesAs(size_t held, int axis) const {
    const size_t count = static_cast<size_t>(layout.planes());
    const auto* first = reinterpret_cast<const PlaneRange<T>*>(planes.data());
    return {first + (held * 3 + static_cast<size_t>(axis)) * count, count};
  }
  // Whether a voxel may be a finite number.
  bool mayHoldNumbers() const {
    return !unknown.empty() || !is_listed || !counts.entries.empty() ||
           far_range.lo <= far_range.hi;
  }
  bool isKnown(int64_t block) const { return !std::ranges::binary_search(unknown, block); }
  uint64_t bytes() const {
    return (blocks.size() + unknown.size()) * sizeof(int64_t) + totals.size() + planes.size();
  }
};

// More makes the pass no faster.
inline constexpr uint64_t kMostIndexingBytes = uint64_t{128} << 20;

// Reads the blocks that may hold something else than the background, each once, in rows of blocks
// on all threads of the pass, and holds at most its memory of voxels (or a block a thread)
// meanwhile. Throws Error from the source, Interrupted.
SliceRanges buildSliceRanges(VolumeSource& source, int64_t time, const BlockLayout& layout,
                             const VolumePass& pass);

// When a source is asked which blocks may hold something else than the background, which takes long
// if its chunks are many files.
enum class Listing { kNow, kLater };
// The arrays of a volume of which nothing has been read: every block that may hold something else
// than the background is unknown, or every block if the listing comes later. The range and the
// counts of the values are empty. Throws Error from the source.
SliceRanges unknownRanges(VolumeSource& source, int64_t time, const BlockLayout& layout,
                          Listing listing = Listing::kNow);
// The same ranges after the listing; `ranges` itself if they are listed. Throws Error from the
// source.
std::shared_ptr<const SliceRanges> listedRanges(std::shared_ptr<const SliceRanges> ranges,
                                                VolumeSource& source, int64_t time);

}  // namespace sluice
