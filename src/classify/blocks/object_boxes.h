// ObjectBoxes: the object box of every block of a layout, in 12 bytes a block, as classify() finds
// it: for a volume of a million blocks of which few are drawn.
//
// Immutable once made; any thread may read.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "src/base/threads/worker_pool.h"
#include "src/classify/transfer/opacity_table.h"
#include "src/volume/slice_ranges.h"

namespace sluice {

class ObjectBoxes {
 public:
  // Runs on all threads of `pool`. Throws Error as classify() does.
  ObjectBoxes(const SliceRanges& ranges, const OpacityTable& table, const Box3& crop,
              WorkerPool& pool);

  // The object box of the block at this index of the grid, cut by the crop, in cells of the volume;
  // empty: the block is white.
  Box3 of(Vec3i index) const {
    const PackedBox& box = at(layout_.idOf(index));
    if (box.empty()) return {};
    const Vec3i lo = index * layout_.cells();
    return {lo + Vec3i{box.lo[0], box.lo[1], box.lo[2]},
            lo + Vec3i{box.hi[0], box.hi[1], box.hi[2]}};
  }
  // The size of a block's object box, and along each axis in addition that of the boxes in the next
  // blocks to both sides which have part of a face in common with it. Requires: not white.
  Vec3i extentWithNeighbors(Vec3i index) const;

 private:
  // In cells of the block, which has fewer than 2^16 along an axis. All 0: nothing shows.
  struct PackedBox {
    std::array<uint16_t, 3> lo, hi;
    bool empty() const { return hi[0] == 0; }
  };
  const PackedBox& at(int64_t block) const { return boxes_[static_cast<size_t>(block)]; }
  void set(int64_t block, const Box3& owned, const Box3& cells);

  const BlockLayout layout_;
  std::vector<PackedBox> boxes_;  // of each block of the grid
};

}  // namespace sluice
