#include "src/classify/blocks/object_boxes.h"

#include "src/base/memory/large_pages.h"
#include "src/classify/blocks/classifier.h"

namespace sluice {
namespace {

// The cells that blocks own, for blocks in ascending order: most lie in the row of the last one.
class OwnedCells {
 public:
  explicit OwnedCells(const BlockLayout& layout) : layout_(layout) {}

  Box3 of(int64_t block) {
    if (block < row_begin_ || block >= row_begin_ + layout_.grid.x) {
      index_ = layout_.indexOf(block);
      row_begin_ = block - index_.x;
    }
    index_.x = block - row_begin_;
    return layout_.ownedCells(index_);
  }

 private:
  const BlockLayout& layout_;
  Vec3i index_;
  int64_t row_begin_ = INT64_MAX;
};

}  // namespace

ObjectBoxes::ObjectBoxes(const SliceRanges& ranges, const OpacityTable& table, const Box3& crop,
                         WorkerPool& pool)
    : layout_(ranges.layout) {
  const auto count = static_cast<size_t>(layout_.blockCount());
  reserveLarge(boxes_, count);
  boxes_.resize(count);
  visitDeviceType(ranges.map.type, [&](auto tag) {
    const Classifier<decltype(tag)> classifier(ranges, table, crop);
    classifyInTasks(ranges, pool, [&](size_t, size_t from, size_t to) {
      OwnedCells owned_cells(layout_);
      for (size_t held = from; held < to; ++held) {
        if (!classifier.mayShow(held)) continue;
        const int64_t block = ranges.blocks[held];
        const Box3 owned = owned_cells.of(block);
        set(block, owned, classifier.shownCells(held, owned));
      }
    });
  });
  OwnedCells owned_cells(layout_);
  visitWhole(ranges, table, crop, [&](int64_t block) {
    const Box3 owned = owned_cells.of(block);
    set(block, owned, intersect(owned, crop));
  });
}

void ObjectBoxes::set(int64_t block, const Box3& owned, const Box3& cells) {
  if (cells.empty()) return;
  PackedBox& box = boxes_[static_cast<size_t>(block)];
  for (int a = 0; a < 3; ++a) {
    const auto axis = static_cast<size_t>(a);
    box.lo[axis] = static_cast<uint16_t>(cells.lo[a] - owned.lo[a]);
    box.hi[axis] = static_cast<uint16_t>(cells.hi[a] - owned.lo[a]);
  }
}

Vec3i ObjectBoxes::extentWithNeighbors(Vec3i index) const {
  const int64_t block = layout_.idOf(index);
  const PackedBox& box = at(block);
  const auto side = static_cast<uint16_t>(layout_.cells());
  const std::array<int64_t, 3> strides{1, layout_.grid.x, layout_.grid.x * layout_.grid.y};
  // Neighbours along an axis count cells of the other two from the same planes.
  const auto touches = [&](const PackedBox& next, size_t axis) {
    for (const size_t other : {(axis + 1) % 3, (axis + 2) % 3})
      if (box.lo[other] > next.hi[other] || next.lo[other] > box.hi[other]) return false;
    return true;
  };
  Vec3i extent;
  for (int a = 0; a < 3; ++a) {
    const auto axis = static_cast<size_t>(a);
    extent[a] = box.hi[axis] - box.lo[axis];
    if (box.lo[axis] == 0 && index[a] > 0)
      if (const PackedBox& next = at(block - strides[axis]);
          next.hi[axis] == side && touches(next, axis))
        extent[a] += next.hi[axis] - next.lo[axis];
    if (box.hi[axis] == side && index[a] + 1 < layout_.grid[a])
      if (const PackedBox& next = at(block + strides[axis]);
          !next.empty() && next.lo[axis] == 0 && touches(next, axis))
        extent[a] += next.hi[axis] - next.lo[axis];
  }
  return extent;
}

}  // namespace sluice
