// RangeTree against a plain look at every finest block in each region.
#include "src/render/blocks/cut/range_tree.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <random>

#include "src/volume/voxels/device_voxel.h"

namespace sluice {
namespace {

template <class T>
struct Known {
  bool is_unknown = false;
  PlaneRange<T> range{};
};

// Ranges of some blocks; the others are background, or unknown.
template <class T>
SliceRanges rangesOf(const BlockLayout& layout, DeviceType type, int held_in_8, int unknown_in_8,
                     std::vector<Known<T>>& blocks) {
  std::mt19937 random(7);
  SliceRanges ranges;
  ranges.layout = layout;
  ranges.map.type = type;
  ranges.background = 3;
  std::vector<PlaneRange<T>> totals;
  for (int64_t block = 0; block < layout.blockCount(); ++block) {
    const int kind = static_cast<int>(random() % 8);
    Known<T> known{false, {T{3}, T{3}}};
    if (kind < held_in_8) {
      const auto lo = static_cast<T>(random() % 200);
      known.range = {lo, static_cast<T>(lo + static_cast<T>(random() % 50))};
      ranges.blocks.push_back(block);
      totals.push_back(known.range);
    } else if (kind < held_in_8 + unknown_in_8) {
      known.is_unknown = true;
      ranges.unknown.push_back(block);
    }
    blocks.push_back(known);
  }
  ranges.totals.resize(totals.size() * sizeof(PlaneRange<T>));
  if (!totals.empty()) std::memcpy(ranges.totals.data(), totals.data(), ranges.totals.size());
  return ranges;
}

template <class T>
void expectNodes(const PyramidLayout& pyramid, DeviceType type, int held_in_8, int unknown_in_8) {
  std::vector<Known<T>> blocks;
  const SliceRanges ranges = rangesOf<T>(pyramid.finest(), type, held_in_8, unknown_in_8, blocks);
  WorkerPool pool(2);
  const RangeTree tree(ranges, pyramid, pool);
  for (int level = 1; level < pyramid.levels(); ++level)
    for (int64_t block = 0; block < pyramid.level(level).blocks.blockCount(); ++block) {
      RangeTree::Node expected;
      const Box3 inside = pyramid.finestBlocksOf({.level = level, .block = block});
      for (int64_t finest = 0; finest < pyramid.finest().blockCount(); ++finest) {
        if (!inside.contains(pyramid.finest().indexOf(finest))) continue;
        const Known<T>& known = blocks[static_cast<size_t>(finest)];
        if (known.is_unknown) {
          expected.has_unknown = true;
          continue;
        }
        const bool is_first = expected.lo > expected.hi;
        const auto lo = static_cast<float>(known.range.lo), hi = static_cast<float>(known.range.hi);
        expected.lo = is_first ? lo : std::min(expected.lo, lo);
        expected.hi = is_first ? hi : std::max(expected.hi, hi);
      }
      const RangeTree::Node& node = tree.of(level, block);
      EXPECT_EQ(node.lo, expected.lo) << "level " << level << " block " << block;
      EXPECT_EQ(node.hi, expected.hi) << "level " << level << " block " << block;
      EXPECT_EQ(node.has_unknown, expected.has_unknown) << "level " << level << " block " << block;
    }
}

// Grids of odd numbers of blocks, the last of which belong to no pair, and levels that halve some
// axes alone.
TEST(RangeTree, holdsTheRangesOfAllBlocksBelow) {
  for (const Vec3i dims : {Vec3i{150, 120, 97}, Vec3i{40, 200, 13}, Vec3i{310, 14, 30}}) {
    PyramidLayout pyramid(blockLayout(dims, 16, 1));
    ASSERT_EQ(pyramid.add({dims.x / 2, dims.y / 2, dims.z}, {{2, 2, 1}, {0.5, 0.5, 0}}), "");
    ASSERT_EQ(pyramid.add({dims.x / 4, dims.y / 4, dims.z / 2}, {{4, 4, 2}, {1.5, 1.5, 0.5}}), "");
    for (const auto& [held, unknown] : {std::pair(8, 0), std::pair(4, 0), std::pair(0, 3),
                                        std::pair(3, 3), std::pair(0, 8), std::pair(0, 0)}) {
      SCOPED_TRACE(testing::Message() << dims.x << ": held " << held << ", unknown " << unknown);
      expectNodes<uint8_t>(pyramid, DeviceType::kU8, held, unknown);
      expectNodes<uint16_t>(pyramid, DeviceType::kU16, held, unknown);
      expectNodes<float>(pyramid, DeviceType::kF32, held, unknown);
    }
  }
}

}  // namespace
}  // namespace sluice
