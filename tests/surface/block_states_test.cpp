#include "src/surface/block_states.h"

#include <gtest/gtest.h>

#include <limits>

#include "src/base/threads/worker_pool.h"
#include "tests/support/function_source.h"
#include "tests/support/memory_source.h"

namespace sluice {
namespace {

SliceRanges rangesOf(VolumeSource& source, int64_t block) {
  WorkerPool pool(1);
  ProgressMeter progress;
  return buildSliceRanges(source, 0, blockLayout(source.layout().dims, block, 1), {pool, progress});
}

TEST(InsideSet, holdsTheValuesOfAtLeastTheThreshold) {
  VolumeLayout layout;
  const InsideSet bytes = insideSet(deviceMap(layout), 40);
  EXPECT_TRUE(bytes.contains(40));
  EXPECT_FALSE(bytes.contains(39));
  const InsideSet between = insideSet(deviceMap(layout), 39.5);
  EXPECT_TRUE(between.contains(40));
  EXPECT_FALSE(between.contains(39));
  layout.value_scale = 0.1;  // 3 * 0.1 is a little more than 0.3
  EXPECT_TRUE(insideSet(deviceMap(layout), 0.3).contains(3));
  layout.value_scale = -2;
  layout.value_offset = 10;
  const InsideSet falling = insideSet(deviceMap(layout), 4);
  EXPECT_TRUE(falling.contains(3));
  EXPECT_FALSE(falling.contains(4));
}

TEST(InsideSet, neverHoldsNotANumber) {
  VolumeLayout layout;
  layout.type = VoxelType::kF32;
  EXPECT_FALSE(insideSet(deviceMap(layout), -1e38).contains(kNotANumber));
  layout.value_scale = -1;
  EXPECT_FALSE(insideSet(deviceMap(layout), 0).contains(kNotANumber));
  EXPECT_TRUE(insideSet(deviceMap(layout), 0).contains(-kLargest));
}

TEST(BlockStates, areThoseOfTheVoxels) {
  // Values rise along x by 1 a voxel.
  auto source = makeMemorySource<uint8_t>({40, 20, 20}, [](auto x, auto, auto) { return x; });
  const SliceRanges ranges = rangesOf(*source, 8);
  const BlockStates states =
      blockStates(ranges, insideSet(deviceMap(source->layout()), 15), nullptr);
  const BlockLayout& layout = states.layout;
  for (int64_t id = 0; id < layout.blockCount(); ++id) {
    const Box3 voxels = layout.ownedVoxels(layout.indexOf(id));
    const RangeState expected = voxels.hi.x - 1 < 15 ? RangeState::kOutside
                                : voxels.lo.x >= 15  ? RangeState::kInside
                                                     : RangeState::kMixed;
    EXPECT_EQ(states.stateOf(id), expected) << id;
  }
}

TEST(BlockStates, backgroundInsideIsMixedAtTheBorderOfAClosedSurface) {
  auto source = makeMemorySource<uint8_t>(
      {40, 40, 40}, [](auto x, auto y, auto z) { return x == 20 && y == 20 && z == 20 ? 0 : 9; });
  const SliceRanges ranges = rangesOf(*source, 8);
  const Box3 region = boxOf(Vec3i{39, 39, 39});
  const BlockStates states =
      blockStates(ranges, insideSet(deviceMap(source->layout()), 5), &region);
  const BlockLayout& layout = states.layout;
  for (int64_t id = 0; id < layout.blockCount(); ++id) {
    const Vec3i index = layout.indexOf(id);
    const Box3 voxels = layout.ownedVoxels(index);
    bool is_mixed = voxels.contains(Vec3i{20, 20, 20});
    for (int a = 0; a < 3; ++a)
      is_mixed = is_mixed || index[a] == 0 || index[a] + 1 == layout.grid[a];
    EXPECT_EQ(states.stateOf(id), is_mixed ? RangeState::kMixed : RangeState::kInside) << id;
  }
}

TEST(BlockStates, ofACoarserLevelMissNoBlock) {
  const Vec3i dims{64, 50, 40};
  auto finest = makeMemorySource<float>(dims, [](auto x, auto y, auto z) {
    return std::sin(x * 0.08) + std::cos(y * 0.05) + z * 0.02;
  });
  const LevelPlacement placement{{2, 2, 2}, {0.5, 0.5, 0.5}};
  const auto* voxels = reinterpret_cast<const float*>(finest->bytes().data());
  auto level = makeMemorySource<float>({32, 25, 20}, [&](auto x, auto y, auto z) {
    double sum = 0;
    for (int c = 0; c < 8; ++c)
      sum +=
          voxels[((2 * z + (c >> 2)) * dims.y + 2 * y + (c >> 1 & 1)) * dims.x + 2 * x + (c & 1)];
    return sum / 8;
  });
  const InsideSet inside = insideSet(deviceMap(finest->layout()), 1.4);
  const BlockLayout blocks = blockLayout(level->layout().dims, 8, 1);
  const BlockStates found =
      blockStates(rangesOf(*finest, 8), inside, nullptr, blocks, placement, LevelValues::kMeans);
  const BlockStates exact = blockStates(rangesOf(*level, 8), inside, nullptr);
  int64_t known = 0;
  for (int64_t id = 0; id < blocks.blockCount(); ++id) {
    if (found.stateOf(id) == RangeState::kMixed) continue;
    ++known;
    EXPECT_EQ(found.stateOf(id), exact.stateOf(id)) << id;
  }
  EXPECT_GT(known, blocks.blockCount() / 8);
  const BlockStates unknown =
      blockStates(rangesOf(*finest, 8), inside, nullptr, blocks, placement, LevelValues::kUnknown);
  EXPECT_EQ(static_cast<int64_t>(unknown.blocks.size()), blocks.blockCount());
  // No value of 8 bits reaches 300.
  const InsideSet none = insideSet({DeviceType::kU8, 1, 0}, 300);
  EXPECT_TRUE(
      blockStates(rangesOf(*finest, 8), none, nullptr, blocks, placement, LevelValues::kUnknown)
          .blocks.empty());
}

}  // namespace
}  // namespace sluice
