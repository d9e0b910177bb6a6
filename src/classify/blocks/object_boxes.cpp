#include "src/classify/blocks/object_boxes.h"

#include <algorithm>
#include <atomic>
#include <new>
#include <span>
#include <utility>

#include "src/base/memory/large_pages.h"

namespace sluice {

ObjectBoxes::ObjectBoxes(std::shared_ptr<const SliceRanges> ranges, const OpacityTable& table,
                         const Box3& crop)
    : ranges_(std::move(ranges)),
      crop_(crop),
      classifier_(visitDeviceType(ranges_->map.type,
                                  [&](auto tag) {
                                    return AnyClassifier(
                                        Classifier<decltype(tag)>(*ranges_, table, crop_));
                                  })),
      shows_background_(showsBackground(*ranges_, table, crop)),
      // Zeros are boxes that were not made. calloc() gives pages that nobody has touched, so that a
      // million blocks cost nothing before they are asked for.
      boxes_(static_cast<PackedBox*>(
          std::calloc(static_cast<size_t>(layout().blockCount()), sizeof(PackedBox)))) {
  if (boxes_ == nullptr) throw std::bad_alloc();
  // The few boxes that are asked for lie far apart: each would cost a small page of its own.
  preferLargePages(
      std::as_writable_bytes(std::span(boxes_.get(), static_cast<size_t>(layout().blockCount()))));
}

Box3 ObjectBoxes::shownCells(int64_t block, const Box3& owned) const {
  const std::vector<int64_t>& all = ranges_->blocks;
  // Most volumes have no gaps before most blocks.
  auto held = static_cast<size_t>(block);
  if (held >= all.size() || all[held] != block)
    held = static_cast<size_t>(std::ranges::lower_bound(all, block) - all.begin());
  if (held < all.size() && all[held] == block)
    return std::visit(
        [&](const auto& classifier) {
          return classifier.mayShow(held) ? classifier.shownCells(held, owned) : Box3();
        },
        classifier_);
  if (shows_background_ || !ranges_->isKnown(block)) return intersect(owned, crop_);
  return {};
}

void ObjectBoxes::make(int64_t block, PackedBox& box) const {
  const Box3 owned = layout().ownedCells(layout().indexOf(block));
  const Box3 cells = shownCells(block, owned);
  if (cells.empty()) {
    box.lo[0] = 1;  // made, and empty
    return;
  }
  for (int a = 0; a < 3; ++a) {
    const auto axis = static_cast<size_t>(a);
    box.lo[axis] = static_cast<uint16_t>(cells.lo[a] - owned.lo[a]);
    box.hi[axis] = static_cast<uint16_t>(cells.hi[a] - owned.lo[a]);
  }
}

ObjectBoxes::Shown ObjectBoxes::shownBetween(double lo, double hi) const {
  // lo > hi says that no block of these is known.
  if (lo > hi) return Shown::kNothing;
  return std::visit(
      [&]<class T>(const Classifier<T>& classifier) {
        const auto from = static_cast<T>(lo), to = static_cast<T>(hi);
        if (!classifier.anyBetween(from, to)) return Shown::kNothing;
        return classifier.allBetween(from, to) ? Shown::kEverything : Shown::kSomething;
      },
      classifier_);
}

int64_t ObjectBoxes::cellCount(WorkerPool& pool) const {
  std::atomic<int64_t> cells = 0;
  const int64_t parts = (layout().blockCount() + kPart - 1) / kPart;
  pool.parallelFor(parts, [&](int64_t part) {
    // Each task adds once, not at each block: the threads would wait for one another's cache line.
    int64_t of_part = 0;
    const int64_t end = std::min(layout().blockCount(), (part + 1) * kPart);
    for (int64_t block = part * kPart; block < end; ++block) {
      const PackedBox& box = at(block);
      if (box.empty()) continue;
      int64_t of_box = 1;
      for (size_t axis = 0; axis < 3; ++axis) of_box *= box.hi[axis] - box.lo[axis];
      of_part += of_box;
    }
    cells += of_part;
  });
  return cells;
}

Vec3i ObjectBoxes::extentWithNeighbors(Vec3i index) const {
  const int64_t block = layout().idOf(index);
  const PackedBox& box = at(block);
  const auto side = static_cast<uint16_t>(layout().cells());
  const Vec3i grid = layout().grid;
  const std::array<int64_t, 3> strides{1, grid.x, grid.x * grid.y};
  // Cells are counted from each block's own first plane, which is the same for neighbours along the
  // axis.
  const auto touches = [&](const PackedBox& next, size_t axis) {
    for (const size_t other : {(axis + 1) % 3, (axis + 2) % 3})
      if (box.lo[other] > next.hi[other] || next.lo[other] > box.hi[other]) return false;
    return true;
  };
  Vec3i extent;
  for (int a = 0; a < 3; ++a) {
    const auto axis = static_cast<size_t>(a);
    extent[a] = box.hi[axis] - box.lo[axis];
    // A neighbour counts if its box reaches the face between them and meets this one there.
    if (box.lo[axis] == 0 && index[a] > 0)
      if (const PackedBox& next = at(block - strides[axis]);
          next.hi[axis] == side && touches(next, axis))
        extent[a] += next.hi[axis] - next.lo[axis];
    if (box.hi[axis] == side && index[a] + 1 < grid[a])
      if (const PackedBox& next = at(block + strides[axis]);
          !next.empty() && next.lo[axis] == 0 && touches(next, axis))
        extent[a] += next.hi[axis] - next.lo[axis];
  }
  return extent;
}

}  // namespace sluice
