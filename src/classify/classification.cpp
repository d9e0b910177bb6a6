#include "src/classify/classification.h"

#include <algorithm>
#include <array>

#include "src/base/error.h"

namespace sluice {
namespace {

// Blocks classified by one call of a worker: long enough to outweigh handing it out.
constexpr size_t kBlocksPerTask = 1024;
// Most blocks that a visible background may fill.
constexpr int64_t kMostBackgroundBlocks = int64_t{1} << 24;

// Device value to table entry, a look-up for bytes.
template <class T>
class EntryOf {
 public:
  explicit EntryOf(const OpacityTable& table) : table_(table) {
    if constexpr (sizeof(T) == 1)
      for (size_t v = 0; v < entries_.size(); ++v)
        entries_[v] = table.entryOf(static_cast<double>(v));
  }
  int operator()(T v) const {
    if constexpr (sizeof(T) == 1) {
      return entries_[v];
    } else {
      return table_.entryOf(v);
    }
  }

 private:
  const OpacityTable& table_;
  std::array<int, sizeof(T) == 1 ? 256 : 1> entries_{};
};

template <class T>
class Classifier {
 public:
  Classifier(const SliceRanges& ranges, const OpacityTable& table, const Box3& crop)
      : ranges_(ranges), table_(table), crop_(crop), entry_of_(table) {}

  // White blocks come back with an empty box.
  ObjectBlock classifyHeld(size_t held) const {
    ObjectBlock result;
    result.block = ranges_.blocks[held];
    const PlaneRange<T> total = ranges_.totalsAs<T>()[held];
    if (!opaque(total)) return result;
    const Box3 owned = ranges_.layout.ownedCells(ranges_.layout.indexOf(result.block));
    for (int axis = 0; axis < 3; ++axis) {
      const auto planes = ranges_.planesAs<T>(held, axis);
      int64_t first = 0, last = owned.hi[axis] - owned.lo[axis];
      while (first < last && !slabShows(planes, first)) ++first;
      while (last > first && !slabShows(planes, last - 1)) --last;
      if (first == last) return result;  // stays white
      result.cells.lo[axis] = owned.lo[axis] + first;
      result.cells.hi[axis] = owned.lo[axis] + last;
    }
    finish(result, owned);
    return result;
  }

  // Every cell of a block of nothing but visible background shows.
  ObjectBlock backgroundBlock(int64_t block) const {
    ObjectBlock result;
    result.block = block;
    const Box3 owned = ranges_.layout.ownedCells(ranges_.layout.indexOf(block));
    result.cells = owned;
    finish(result, owned);
    return result;
  }

 private:
  bool opaque(PlaneRange<T> range) const {
    return table_.anyOpaqueEntry(entry_of_(range.lo), entry_of_(range.hi));
  }
  bool slabShows(std::span<const PlaneRange<T>> planes, int64_t slab) const {
    const PlaneRange<T> a = planes[static_cast<size_t>(slab)];
    const PlaneRange<T> b = planes[static_cast<size_t>(slab) + 1];
    return opaque({std::min(a.lo, b.lo), std::max(a.hi, b.hi)});
  }
  void finish(ObjectBlock& result, const Box3& owned) const {
    result.cells = intersect(result.cells, crop_);
    if (result.cells.empty()) return;
    result.kind = result.cells == owned ? BlockClass::kBlack : BlockClass::kGrey;
    const Vec3i size = result.cells.size();
    result.trimming_axis = 2;
    for (int axis = 1; axis >= 0; --axis)
      if (size[axis] < size[result.trimming_axis]) result.trimming_axis = axis;
  }

  const SliceRanges& ranges_;
  const OpacityTable& table_;
  const Box3& crop_;
  const EntryOf<T> entry_of_;
};

// The grid's blocks that own cells of `cells`.
Box3 blocksOf(const BlockLayout& layout, const Box3& cells) {
  const Box3 inside = intersect(cells, {{0, 0, 0}, layout.dims - Vec3i{1, 1, 1}});
  if (inside.empty()) return {};
  const int64_t side = layout.cells();
  return {inside.lo / side, (inside.hi - Vec3i{1, 1, 1}) / side + Vec3i{1, 1, 1}};
}

template <class T>
void addVisibleBackground(const SliceRanges& ranges, const Box3& crop,
                          const Classifier<T>& classifier, std::vector<ObjectBlock>& visible) {
  const BlockLayout& layout = ranges.layout;
  const Box3 blocks = blocksOf(layout, crop);
  if (blocks.count() > kMostBackgroundBlocks)
    fail(
        "the value outside the stored region ({}) is visible under this transfer function and "
        "would fill {} blocks; make its opacity 0 or crop the volume",
        ranges.map.valueOf(ranges.background), blocks.count());
  for (int64_t z = blocks.lo.z; z < blocks.hi.z; ++z)
    for (int64_t y = blocks.lo.y; y < blocks.hi.y; ++y) {
      // Ids ascend along the row, so that one look finds the first held one.
      int64_t block = layout.idOf({blocks.lo.x, y, z});
      const int64_t end = block + blocks.size().x;
      auto held = std::lower_bound(ranges.blocks.begin(), ranges.blocks.end(), block);
      for (; block < end; ++block) {
        if (held != ranges.blocks.end() && *held == block) {
          ++held;
          continue;
        }
        const ObjectBlock object = classifier.backgroundBlock(block);
        if (!object.cells.empty()) visible.push_back(object);
      }
    }
  std::sort(visible.begin(), visible.end(),
            [](const ObjectBlock& a, const ObjectBlock& b) { return a.block < b.block; });
}

}  // namespace

Classification classify(const SliceRanges& ranges, const OpacityTable& table, const Box3& crop,
                        WorkerPool& pool) {
  Classification result;
  const size_t held_count = ranges.blocks.size();
  const size_t tasks = (held_count + kBlocksPerTask - 1) / kBlocksPerTask;
  std::vector<std::vector<ObjectBlock>> parts(tasks);
  visitDeviceType(ranges.map.type, [&](auto tag) {
    const Classifier<decltype(tag)> classifier(ranges, table, crop);
    pool.parallelFor(static_cast<int64_t>(tasks), [&](int64_t task) {
      const size_t from = static_cast<size_t>(task) * kBlocksPerTask;
      const size_t to = std::min(held_count, from + kBlocksPerTask);
      for (size_t held = from; held < to; ++held) {
        const ObjectBlock object = classifier.classifyHeld(held);
        if (!object.cells.empty()) parts[static_cast<size_t>(task)].push_back(object);
      }
    });
    for (const auto& part : parts)
      result.visible.insert(result.visible.end(), part.begin(), part.end());
    if (table.anyOpaque(ranges.background, ranges.background) &&
        static_cast<int64_t>(held_count) < ranges.layout.blockCount())
      addVisibleBackground(ranges, crop, classifier, result.visible);
  });
  for (const ObjectBlock& object : result.visible)
    ++(object.kind == BlockClass::kBlack ? result.black : result.grey);
  result.white = ranges.layout.blockCount() - result.grey - result.black;
  return result;
}

}  // namespace sluice
