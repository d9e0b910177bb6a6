// Ranges of bricks equal those computed voxel by voxel, whatever the blocks.
#include "src/volume/ranges/brick_ranges.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>

#include "tests/support/function_source.h"
#include "tests/support/random_volume.h"
#include "tests/volume/slice_ranges_check.h"

namespace sluice::brick_ranges_test {
namespace {

constexpr std::array kTypes = {VoxelType::kU8, VoxelType::kI16, VoxelType::kF32, VoxelType::kF64};

BrickRanges bricksOf(VolumeSource& source, int64_t block, int ghost = 0, int threads = 2) {
  WorkerPool pool(threads);
  ProgressMeter quiet;
  BrickRanges bricks;
  buildSliceRanges(source, 0, blockLayout(source.layout().dims, block, ghost), {pool, quiet},
                   bricks);
  return bricks;
}

template <class T>
void expectBricksOf(const BrickRanges& bricks, const VoxelAt& voxel) {
  const Vec3i grid = bricks.grid();
  ASSERT_EQ(bricks.rangesAs<T>().size(), static_cast<size_t>(volume(grid)));
  size_t at = 0;
  for (int64_t z = 0; z < grid.z; ++z)
    for (int64_t y = 0; y < grid.y; ++y)
      for (int64_t x = 0; x < grid.x; ++x, ++at) {
        const Box3 cells = bricks.cellsOf({x, y, z});
        const VoxelRange expected = rangeOf({cells.lo, cells.hi + Vec3i{1, 1, 1}}, voxel);
        ASSERT_EQ(static_cast<double>(bricks.rangesAs<T>()[at].lo), expected.lo);
        ASSERT_EQ(static_cast<double>(bricks.rangesAs<T>()[at].hi), expected.hi);
      }
}

TEST(BrickRanges, agreeWithALookAtEachVoxel) {
  uint64_t seed = 1;
  for (const VoxelType type : kTypes)
    for (const Vec3i dims : {Vec3i{2, 2, 2}, Vec3i{31, 15, 20}, Vec3i{300, 60, 70}}) {
      const auto source = makeWhiteNoise(dims, type, seed++);
      const BrickRanges bricks = bricksOf(*source, 16);
      EXPECT_EQ(bricks.cells, boxOf(dims - Vec3i{1, 1, 1}));
      EXPECT_EQ(bricks.side, dims.x == 300 ? 2 : 1);
      visitDeviceType(deviceMap(source->layout()).type, [&](auto tag) {
        expectBricksOf<decltype(tag)>(bricks, [&](Vec3i p) { return voxelAt(*source, 0, p); });
      });
      if (HasFatalFailure()) FAIL() << name(type);
    }
}

TEST(BrickRanges, areTheSameForAllBlocks) {
  const auto source = makeWhiteNoise({130, 90, 75}, VoxelType::kU16, 7);
  const BrickRanges expected = bricksOf(*source, 128);
  for (const int64_t block : {8, 16, 64})
    for (const int ghost : {0, 1}) {
      const BrickRanges bricks = bricksOf(*source, block, ghost, 3);
      EXPECT_EQ(bricks.cells, expected.cells);
      EXPECT_EQ(bricks.side, expected.side);
      EXPECT_EQ(bricks.ranges, expected.ranges) << block << " ghost " << ghost;
    }
}

TEST(BrickRanges, notANumberDoesNotCount) {
  const auto nan = std::numeric_limits<double>::quiet_NaN();
  const auto source = makeMemorySource<float>(Vec3i{12, 4, 4}, [&](auto x, auto y, auto) {
    return x < 6 || (x + y) % 2 == 0 ? nan : static_cast<double>(x);
  });
  const BrickRanges bricks = bricksOf(*source, 8);
  const auto ranges = bricks.rangesAs<float>();
  EXPECT_GT(ranges[0].lo, ranges[0].hi) << "NaN alone";
  EXPECT_EQ(ranges[8].lo, 8);
  EXPECT_EQ(ranges[8].hi, 9);
}

TEST(BrickRanges, missingChunksChangeNoBricks) {
  Occupancy occupancy;
  occupancy.boxes = {{{1000, 0, 0}, {1008, 8, 8}}};
  const Vec3i dims{4096, 4096, 4096};
  EXPECT_EQ(brickCells(dims, occupancy), boxOf(dims - Vec3i{1, 1, 1}));
}

// The stored boxes have no voxel of the background, 7.
TEST(BrickRanges, includeTheBackgroundOnlyWithMissingVoxels) {
  const Vec3i dims{150, 140, 130};
  const std::vector<Box3> boxes{{{0, 0, 0}, {150, 40, 130}}, {{33, 50, 20}, {61, 99, 100}}};
  const auto valueAt = [&](Vec3i p) {
    const bool is_stored = boxes[0].contains(p) || boxes[1].contains(p);
    return is_stored ? static_cast<double>(20 + (p.x * 7 + p.y * 5 + p.z) % 200) : 7.0;
  };
  FunctionSource sparse(
      functionLayout(dims, VoxelType::kU8), [&](int64_t, Vec3i p) { return valueAt(p); },
      Occupancy{7, boxes});
  for (const int64_t block : {4, 16, 64})
    for (const int ghost : {0, 1}) {
      const BrickRanges bricks = bricksOf(sparse, block, ghost);
      EXPECT_EQ(bricks.side, 3);
      expectBricksOf<uint8_t>(bricks, valueAt);
      if (HasFatalFailure()) FAIL() << block << " ghost " << ghost;
    }
}

TEST(BrickRanges, aSparseVolumeHasThemWhereItHasVoxels) {
  const Vec3i far{int64_t{1} << 30, int64_t{1} << 30, int64_t{1} << 30};
  Occupancy occupancy;
  EXPECT_TRUE(brickCells(far, occupancy).empty());
  EXPECT_EQ(volume(brickGrid({}).grid()), 0);
  occupancy.boxes = {{{1000, 0, 0}, {1008, 8, 8}}, {}, {{1100, 50, 60}, {1108, 58, 68}}};
  const Box3 cells = brickCells(far, occupancy);
  EXPECT_EQ(cells, (Box3{{999, 0, 0}, {1108, 58, 68}}));
  occupancy.boxes.push_back({far - Vec3i{8, 8, 8}, far});
  const BrickRanges grid = brickGrid(brickCells(far, occupancy));
  EXPECT_LE(volume(grid.grid()), kMostRangeBricks);
  EXPECT_GE(volume(grid.grid()), kMostRangeBricks / 2);
}

}  // namespace
}  // namespace sluice::brick_ranges_test
