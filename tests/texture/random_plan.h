// Volumes cut into blocks, with made-up visible parts of each, for making plans in tests.
#pragma once

#include <algorithm>
#include <random>

#include "src/base/error.h"
#include "src/texture/texture_plan.h"

namespace sluice {

inline Box3 allCells(const BlockLayout& layout) {
  return {{0, 0, 0}, layout.dims - Vec3i{1, 1, 1}};
}

// The block that classify() would make: the kind and the trimming axis follow from the box.
inline ObjectBlock objectBlock(const BlockLayout& layout, int64_t block, const Box3& cells) {
  ObjectBlock object;
  object.name.block = block;
  object.cells = cells;
  object.kind =
      cells == layout.ownedCells(layout.indexOf(block)) ? BlockClass::kBlack : BlockClass::kGrey;
  const Vec3i size = cells.size();
  object.trimming_axis = 2;
  for (int axis = 1; axis >= 0; --axis)
    if (size[axis] < size[object.trimming_axis]) object.trimming_axis = axis;
  return object;
}

inline VisibleBlocks visibleBlocksOf(const BlockLayout& layout, std::vector<ObjectBlock> visible) {
  VisibleBlocks result;
  result.blocks = std::move(visible);
  for (const ObjectBlock& object : result.blocks)
    ++(object.kind == BlockClass::kBlack ? result.black : result.grey);
  result.white = layout.blockCount() - result.black - result.grey;
  return result;
}

// Every cell visible.
inline VisibleBlocks allBlack(const BlockLayout& layout) {
  std::vector<ObjectBlock> visible;
  for (int64_t block = 0; block < layout.blockCount(); ++block)
    visible.push_back(objectBlock(layout, block, layout.ownedCells(layout.indexOf(block))));
  return visibleBlocksOf(layout, std::move(visible));
}

// About `share` of the blocks visible, each in a random box of its cells.
inline VisibleBlocks randomVisibleBlocks(const BlockLayout& layout, double share,
                                         std::mt19937_64& random) {
  const auto below = [&](int64_t n) {
    return static_cast<int64_t>(random() % static_cast<uint64_t>(n));
  };
  std::vector<ObjectBlock> visible;
  for (int64_t block = 0; block < layout.blockCount(); ++block) {
    if (static_cast<double>(random() >> 11) * 0x1p-53 >= share) continue;
    const Box3 owned = layout.ownedCells(layout.indexOf(block));
    Box3 cells = owned;
    if (below(5) > 0)
      for (int a = 0; a < 3; ++a) {
        cells.lo[a] += below(owned.size()[a]);
        cells.hi[a] = cells.lo[a] + 1 + below(owned.hi[a] - cells.lo[a]);
      }
    visible.push_back(objectBlock(layout, block, cells));
  }
  return visibleBlocksOf(layout, std::move(visible));
}

// Three levels, each the average of the one below, an odd size rounded up. `numbers`: a voxel of
// the two coarser ones.
inline PyramidLayout threeLevels(Vec3i dims, int64_t size, int ghost, int numbers = 1) {
  PyramidLayout pyramid(blockLayout(dims, size, ghost));
  for (const int64_t times : {2, 4}) {
    const double scale = static_cast<double>(times);
    Vec3i coarse;
    for (int a = 0; a < 3; ++a) coarse[a] = ceilDiv(dims[a], times);
    const double offset = (scale - 1) / 2;
    SLUICE_CHECK(
        pyramid.add(coarse, {{scale, scale, scale}, {offset, offset, offset}}, numbers).empty());
  }
  return pyramid;
}

// A cut through a pyramid: every part of the volume at one level, chosen by chance; about `share`
// of its blocks, in random boxes of their regions.
inline VisibleBlocks randomCut(const PyramidLayout& pyramid, double share,
                               std::mt19937_64& random) {
  const auto chance = [&] { return static_cast<double>(random() >> 11) * 0x1p-53; };
  const auto below = [&](int64_t n) {
    return static_cast<int64_t>(random() % static_cast<uint64_t>(n));
  };
  VisibleBlocks cut;
  const auto add = [&](const auto& self, int level, Vec3i index) -> void {
    if (level > 0 && chance() < 0.6) {
      const Box3 children = pyramid.childrenOf(level, index);
      for (int64_t z = children.lo.z; z < children.hi.z; ++z)
        for (int64_t y = children.lo.y; y < children.hi.y; ++y)
          for (int64_t x = children.lo.x; x < children.hi.x; ++x) self(self, level - 1, {x, y, z});
      return;
    }
    if (chance() >= share) return;
    ObjectBlock object;
    object.name = {.level = level, .block = pyramid.level(level).blocks.idOf(index)};
    object.cells = pyramid.regionOf(object.name);
    const Vec3i size = object.cells.size();
    for (int a = 0; a < 3; ++a) {
      object.cells.lo[a] += below(size[a]);
      object.cells.hi[a] -= below(object.cells.size()[a]);
    }
    object.trimming_axis = static_cast<int>(below(3));
    cut.blocks.push_back(object);
  };
  const int top = pyramid.levels() - 1;
  const BlockLayout& blocks = pyramid.level(top).blocks;
  for (int64_t block = 0; block < blocks.blockCount(); ++block)
    add(add, top, blocks.indexOf(block));
  std::ranges::sort(cut.blocks, {}, &ObjectBlock::name);
  cut.grey = static_cast<int64_t>(cut.blocks.size());
  return cut;
}

inline PlanOptions planOptions(const BlockLayout& layout, Algorithm algorithm,
                               MergeOrder order = MergeOrder::kPaper) {
  PlanOptions options;
  options.algorithm = algorithm;
  options.merge_order = order;
  options.crop = allCells(layout);
  return options;
}

}  // namespace sluice
