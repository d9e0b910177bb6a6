// ObjectBoxes: the object boxes of single blocks of a layout, as classify() finds them, each made
// when it is first asked for: for a volume of a million blocks of which few are looked at.
//
// One thread at a time; several at once if no two of them ask for the same block.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <variant>

#include "src/base/threads/worker_pool.h"
#include "src/classify/blocks/classifier.h"
#include "src/classify/transfer/opacity_table.h"
#include "src/volume/ranges/slice_ranges.h"

namespace sluice {

class ObjectBoxes {
 public:
  // Throws Error as classify() does.
  ObjectBoxes(std::shared_ptr<const SliceRanges> ranges, const OpacityTable& table,
              const Box3& crop);

  const BlockLayout& layout() const { return ranges_->layout; }
  // The object box of the block at this index of the grid, cut by the crop, in cells of the volume;
  // empty: the block is white.
  Box3 of(Vec3i index) const {
    const PackedBox& box = at(layout().idOf(index));
    if (box.empty()) return {};
    const Vec3i lo = index * layout().cells();
    return {lo + Vec3i{box.lo[0], box.lo[1], box.lo[2]},
            lo + Vec3i{box.hi[0], box.hi[1], box.hi[2]}};
  }
  // The size of a block's object box, and along each axis in addition that of the boxes in the next
  // blocks to both sides which have part of a face in common with it. Requires: not white.
  Vec3i extentWithNeighbors(Vec3i index) const;
  // Cells in all object boxes, on all threads of `pool`.
  int64_t cellCount(WorkerPool& pool) const;

  // How much blocks show whose values all lie between two device values. A cell shows if a value
  // between those of its voxels does.
  enum class Shown { kNothing, kSomething, kEverything };
  Shown shownBetween(double lo, double hi) const;

 private:
  // A box in cells of its block, which has fewer than 2^16 along an axis. All 0: not made yet.
  struct PackedBox {
    std::array<uint16_t, 3> lo, hi;
    bool isMade() const { return hi[0] != 0 || lo[0] != 0; }
    bool empty() const { return hi[0] == 0; }
  };
  struct Free {
    void operator()(PackedBox* boxes) const { std::free(boxes); }
  };
  using AnyClassifier = std::variant<Classifier<uint8_t>, Classifier<uint16_t>, Classifier<float>>;
  // Blocks that one call of a worker looks at.
  static constexpr int64_t kPart = 1024;

  const PackedBox& at(int64_t block) const {
    PackedBox& box = boxes_[static_cast<size_t>(block)];
    if (!box.isMade()) make(block, box);
    return box;
  }
  void make(int64_t block, PackedBox& box) const;
  Box3 shownCells(int64_t block, const Box3& owned) const;

  const std::shared_ptr<const SliceRanges> ranges_;
  const Box3 crop_;
  const AnyClassifier classifier_;
  const bool shows_background_;
  // A box for each block of the grid, in zeroed memory that the system gives as it is touched.
  const std::unique_ptr<PackedBox[], Free> boxes_;
};

}  // namespace sluice
