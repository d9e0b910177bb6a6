// Classifier finds the object box of single blocks; the functions below visit all blocks that may
// have one. For classify() and ObjectBoxes.
//
// Pure functions of the ranges; any thread may call them.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "src/base/error.h"
#include "src/base/threads/worker_pool.h"
#include "src/base/values/shown_values.h"
#include "src/classify/transfer/opacity_table.h"
#include "src/volume/ranges/slice_ranges.h"

namespace sluice {

// Blocks classified by one call of a worker: long enough to outweigh handing it out.
inline constexpr size_t kBlocksPerTask = 1024;
// Most blocks that a visible background may fill.
inline constexpr int64_t kMostBackgroundBlocks = int64_t{1} << 24;

inline size_t tasksOf(const SliceRanges& ranges) {
  return (ranges.blocks.size() + kBlocksPerTask - 1) / kBlocksPerTask;
}

// The box of a held block's cells, which are `owned`, from the first to the last slab along each
// axis for whose least and greatest value `holds` is true; empty: there is none.
template <class T, class Holds>
Box3 cellsBetween(const SliceRanges& ranges, size_t held, const Box3& owned, const Holds& holds) {
  Box3 cells;
  for (int axis = 0; axis < 3; ++axis) {
    const auto planes = ranges.planesAs<T>(held, axis);
    const int64_t slabs = owned.hi[axis] - owned.lo[axis];
    // The slab lies between this plane and the next.
    const auto holdsSlab = [&](int64_t slab) {
      const PlaneRange<T>* const plane = planes.data() + slab;
      return holds(std::min(plane[0].lo, plane[1].lo), std::max(plane[0].hi, plane[1].hi));
    };
    int64_t first = 0, last = slabs;
    while (first < slabs && !holdsSlab(first)) ++first;
    if (first == slabs) return {};
    while (!holdsSlab(last - 1)) --last;
    cells.lo[axis] = owned.lo[axis] + first;
    cells.hi[axis] = owned.lo[axis] + last;
  }
  return cells;
}

template <class T>
class Classifier {
 public:
  Classifier(const SliceRanges& ranges, const OpacityTable& table, const Box3& crop)
      : ranges_(ranges), crop_(crop), shown_(table.shown()) {}

  // The object box of a held block, whose cells are `owned`, cut by the crop; empty: it is white.
  Box3 shownCells(size_t held, const Box3& owned) const {
    const PlaneRange<T> total = ranges_.totalsAs<T>()[held];
    // Without a look at the planes of a block that is solid.
    if (shown_.allPartsOf(total.lo, total.hi)) return intersect(owned, crop_);
    const Box3 cells =
        cellsBetween<T>(ranges_, held, owned, [&](T lo, T hi) { return shown_.any(lo, hi); });
    return intersect(cells, crop_);
  }

  // False only if the block is white; O(1).
  bool mayShow(size_t held) const {
    const PlaneRange<T> total = ranges_.totalsAs<T>()[held];
    return shown_.any(total.lo, total.hi);
  }
  // The same for any block whose values lie between these; and whether all of its cells show.
  bool anyBetween(T lo, T hi) const { return shown_.any(lo, hi); }
  bool allBetween(T lo, T hi) const { return shown_.allPartsOf(lo, hi); }

 private:
  const SliceRanges& ranges_;
  const Box3& crop_;
  const ShownVoxels<T> shown_;
};

// The grid's blocks that own cells of `cells`.
inline Box3 blocksOf(const BlockLayout& layout, const Box3& cells) {
  const Box3 inside = intersect(cells, {{0, 0, 0}, layout.dims - Vec3i{1, 1, 1}});
  if (inside.empty()) return {};
  const int64_t side = layout.cells();
  return {inside.lo / side, (inside.hi - Vec3i{1, 1, 1}) / side + Vec3i{1, 1, 1}};
}

// Whether there are known blocks that are not held, and their value shows. Throws Error if there
// may be too many of them in the crop.
inline bool showsBackground(const SliceRanges& ranges, const OpacityTable& table,
                            const Box3& crop) {
  const auto others = static_cast<int64_t>(ranges.blocks.size() + ranges.unknown.size());
  if (!table.shown().anyIn(ranges.background, ranges.background) ||
      others >= ranges.layout.blockCount())
    return false;
  const int64_t blocks = blocksOf(ranges.layout, crop).count();
  if (blocks > kMostBackgroundBlocks)
    failRequest(
        "the value outside the stored region ({}) is visible under this transfer function and "
        "would fill {} blocks; make its opacity 0 or crop the volume",
        ranges.map.valueOf(ranges.background), blocks);
  return true;
}

// Calls `call` with each known block of the crop that is not held.
template <class Call>
void visitBackground(const SliceRanges& ranges, const Box3& crop, const Call& call) {
  const BlockLayout& layout = ranges.layout;
  const Box3 blocks = blocksOf(layout, crop);
  for (int64_t z = blocks.lo.z; z < blocks.hi.z; ++z)
    for (int64_t y = blocks.lo.y; y < blocks.hi.y; ++y) {
      // Ids ascend along the row, so that one look finds the first held one.
      int64_t block = layout.idOf({blocks.lo.x, y, z});
      const int64_t end = block + blocks.size().x;
      auto held = std::lower_bound(ranges.blocks.begin(), ranges.blocks.end(), block);
      for (; block < end; ++block) {
        if (held != ranges.blocks.end() && *held == block)
          ++held;
        else if (ranges.isKnown(block))
          call(block);
      }
    }
}

// Calls `held_task` with the number of a task, and the first and the end of the held blocks that
// it is to classify, on all threads of `pool`.
template <class Call>
void classifyInTasks(const SliceRanges& ranges, WorkerPool& pool, const Call& held_task) {
  pool.parallelFor(static_cast<int64_t>(tasksOf(ranges)), [&](int64_t number) {
    const auto task = static_cast<size_t>(number);
    const size_t from = task * kBlocksPerTask;
    held_task(task, from, std::min(ranges.blocks.size(), from + kBlocksPerTask));
  });
}

// Calls `call` with each block that is drawn whole though it is not held: blocks of unknown values,
// and the background's if that is visible.
template <class Call>
void visitWhole(const SliceRanges& ranges, const OpacityTable& table, const Box3& crop,
                const Call& call) {
  for (const int64_t block : ranges.unknown) call(block);
  if (showsBackground(ranges, table, crop)) visitBackground(ranges, crop, call);
}

}  // namespace sluice
