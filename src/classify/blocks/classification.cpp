#include "src/classify/blocks/classification.h"

#include <algorithm>

#include "src/base/error.h"
#include "src/base/memory/large_pages.h"
#include "src/classify/transfer/visible_values.h"

namespace sluice {
namespace {

// Blocks classified by one call of a worker: long enough to outweigh handing it out.
constexpr size_t kBlocksPerTask = 1024;
// Most blocks that a visible background may fill.
constexpr int64_t kMostBackgroundBlocks = int64_t{1} << 24;

template <class T>
class Classifier {
 public:
  Classifier(const SliceRanges& ranges, const OpacityTable& table, const Box3& crop)
      : ranges_(ranges), crop_(crop), visible_(table) {}

  // White blocks come back with an empty box.
  ObjectBlock classifyHeld(size_t held) const {
    ObjectBlock result;
    result.name.block = ranges_.blocks[held];
    const PlaneRange<T> total = ranges_.totalsAs<T>()[held];
    if (!visible_.any(total.lo, total.hi)) return result;
    const Box3 owned = ranges_.layout.ownedCells(ranges_.layout.indexOf(result.name.block));
    for (int axis = 0; axis < 3; ++axis) {
      const auto planes = ranges_.planesAs<T>(held, axis);
      const int64_t slabs = owned.hi[axis] - owned.lo[axis];
      int64_t first = 0, last = slabs;
      while (first < slabs && !slabShows(planes.data() + first)) ++first;
      if (first == slabs) return result;  // stays white
      while (!slabShows(planes.data() + last - 1)) --last;
      result.cells.lo[axis] = owned.lo[axis] + first;
      result.cells.hi[axis] = owned.lo[axis] + last;
    }
    finish(result, owned);
    return result;
  }

  // A block of nothing but visible background, or of unknown values: every cell may show.
  ObjectBlock wholeBlock(int64_t block) const {
    ObjectBlock result;
    result.name.block = block;
    const Box3 owned = ranges_.layout.ownedCells(ranges_.layout.indexOf(block));
    result.cells = owned;
    finish(result, owned);
    return result;
  }

 private:
  // The slab between this plane and the next.
  bool slabShows(const PlaneRange<T>* plane) const {
    return visible_.any(std::min(plane[0].lo, plane[1].lo), std::max(plane[0].hi, plane[1].hi));
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
  const Box3& crop_;
  const VisibleValues<T> visible_;
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
        if (!ranges.isKnown(block)) continue;
        const ObjectBlock object = classifier.wholeBlock(block);
        if (!object.cells.empty()) visible.push_back(object);
      }
    }
}

}  // namespace

VisibleBlocks classify(const SliceRanges& ranges, const OpacityTable& table, const Box3& crop,
                       WorkerPool& pool, int64_t time) {
  VisibleBlocks result;
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
    size_t visible = 0;
    for (const auto& part : parts) visible += part.size();
    reserveLarge(result.blocks, visible);
    for (const auto& part : parts)
      result.blocks.insert(result.blocks.end(), part.begin(), part.end());
    const size_t classified = result.blocks.size();
    for (const int64_t block : ranges.unknown)
      if (const ObjectBlock object = classifier.wholeBlock(block); !object.cells.empty())
        result.blocks.push_back(object);
    if (table.anyOpaque(ranges.background, ranges.background) &&
        static_cast<int64_t>(held_count + ranges.unknown.size()) < ranges.layout.blockCount())
      addVisibleBackground(ranges, crop, classifier, result.blocks);
    if (result.blocks.size() > classified) std::ranges::sort(result.blocks, {}, &ObjectBlock::name);
  });
  for (ObjectBlock& object : result.blocks) {
    object.name.time = time;
    ++(object.kind == BlockClass::kBlack ? result.black : result.grey);
  }
  result.white = ranges.layout.blockCount() - result.grey - result.black;
  return result;
}

}  // namespace sluice
