// The pass over a volume's blocks against bricks of the whole volume at once, and its costs against
// plain sums.
#include "src/index/volume_boxes.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <mutex>
#include <numeric>
#include <set>

#include "src/classify/transfer/transfer_makers.h"
#include "tests/classify/boxes/partition.h"
#include "tests/support/counting_source.h"
#include "tests/support/function_source.h"
#include "tests/support/random_volume.h"

namespace sluice::volume_boxes_test {
namespace {

std::vector<int64_t> allBlocks(const BlockLayout& layout) {
  std::vector<int64_t> blocks(static_cast<size_t>(layout.blockCount()));
  std::iota(blocks.begin(), blocks.end(), int64_t{0});
  return blocks;
}

TEST(VolumeBoxes, eachBlockOnceWithTheBricksThatTheWholeVolumeHas) {
  for (const VoxelType type : {VoxelType::kU8, VoxelType::kI16, VoxelType::kF64})
    for (const int ghost : {0, 1}) {
      SCOPED_TRACE(fmt::format("{} ghost {}", name(type), ghost));
      const auto source = makeSparseBlobs({.dims = {61, 40, 35}, .type = type});
      const DeviceVolume volume(*source);
      const BlockLayout layout = blockLayout(volume.dims, 16, ghost);
      WorkerPool pool(3);
      ProgressMeter progress;
      std::mutex mutex;
      std::set<int64_t> taken;
      forEachBlockBricks(*source, 0, layout, allBlocks(layout), {pool, progress},
                         [&](int64_t block, const BrickGrid& grid) {
                           const std::lock_guard lock(mutex);
                           EXPECT_TRUE(taken.insert(block).second);
                           const Box3 cells = layout.ownedCells(layout.indexOf(block));
                           EXPECT_EQ(grid.cells, cells);
                           EXPECT_EQ(grid.bricks,
                                     brickGrid(volume.span(), cells, kGrowingBrickSide).bricks);
                         });
      EXPECT_EQ(taken.size(), static_cast<size_t>(layout.blockCount()));
    }
}

TEST(VolumeBoxes, onlyTheBlocksAskedForAreRead) {
  const auto blobs = makeSparseBlobs({.dims = {61, 40, 35}});
  CountingSource source(*blobs);
  const BlockLayout layout = blockLayout({61, 40, 35}, 16, 0);
  WorkerPool pool(2);
  ProgressMeter progress;
  const std::vector<int64_t> blocks{1, 2, 5};
  std::atomic<int> taken = 0;
  forEachBlockBricks(source, 0, layout, blocks, {pool, progress},
                     [&](int64_t, const BrickGrid&) { ++taken; });
  EXPECT_EQ(taken, 3);
  // 1 and 2 of the row of four as one: 32 voxels and one more on each side, 17 of y and z. 5
  // likewise, in the second row: 18 of y.
  EXPECT_EQ(source.storedBytesRead(), uint64_t{33 * 17 * 17 + 18 * 18 * 17});
}

// Each thread has its part, and a block if that is too little for one.
TEST(VolumeBoxes, readsStayWithinTheMemoryGiven) {
  const auto blobs = makeSparseBlobs({.dims = {200, 30, 30}, .type = VoxelType::kF64});
  const BlockLayout layout = blockLayout({200, 30, 30}, 16, 0);
  const uint64_t block_bytes = growingBytes(blobs->layout(), layout);
  EXPECT_EQ(block_bytes, uint64_t{18 * 18 * 18 * (8 + 4)}) << "as stored, and as floats";
  constexpr int kThreads = 3;
  for (const uint64_t blocks_a_thread : {0, 1, 4}) {
    SCOPED_TRACE(blocks_a_thread);
    CountingSource source(*blobs);
    WorkerPool pool(kThreads);
    ProgressMeter progress;
    forEachBlockBricks(source, 0, layout, allBlocks(layout),
                       {pool, progress, kThreads * blocks_a_thread * block_bytes},
                       [](int64_t, const BrickGrid&) {});
    uint64_t most = 0;
    for (const CountingSource::Read& read : source.reads())
      most = std::max(most, static_cast<uint64_t>(read.box.count()) * (8 + 4));
    const uint64_t blocks = std::max<uint64_t>(1, blocks_a_thread);
    EXPECT_LE(most, blocks * block_bytes);
    EXPECT_GT(most, (blocks - 1) * block_bytes) << "what is given is used";
    EXPECT_LE(source.counts().max_at_once, kThreads);
  }
}

// Opaque from `threshold` on.
OpacityTable tableOf(const SliceRanges& ranges, double threshold) {
  return {thresholdTransfer(threshold, {0, 255}, 0.05, kDefaultColorMap), ranges.map,
          ranges.device_range};
}

TEST(VolumeBoxes, costsAreThoseOfPlainSums) {
  const auto source = makeSparseBlobs({.dims = {61, 60, 58}, .blobs = 40});
  const DeviceVolume volume(*source);
  const BlockLayout layout = blockLayout(volume.dims, 32, 0);
  WorkerPool pool(2);
  ProgressMeter progress;
  const SliceRanges ranges = buildSliceRanges(*source, 0, layout, {pool, progress});
  ASSERT_EQ(ranges.blocks.size(), static_cast<size_t>(layout.blockCount()));
  const OpacityTable table = tableOf(ranges, 60);
  for (const Box3& crop : {volume.cells(), Box3{{10, 3, 5}, {50, 53, 40}}}) {
    const PartitionCost cost = partitionCost(*source, 0, ranges, table, crop, {pool, progress});
    int64_t boxes = 0, cells = 0, all = 0;
    for (const auto& [box, grown] : treePartition(volume, 32)) {
      ++all;
      if (!table.shown().anyIn(grown.range.lo, grown.range.hi)) continue;
      if (intersect(box, crop).empty()) continue;
      ++boxes;
      cells += intersect(box, crop).count();
    }
    EXPECT_EQ(cost.boxes, all);
    EXPECT_EQ(cost.types[0] + cost.types[1] + cost.types[2], all);
    EXPECT_EQ(cost.grown, static_cast<int64_t>(grownPartition(volume, 32).size()));
    EXPECT_EQ(cost.visible_boxes, boxes);
    EXPECT_EQ(cost.visible_cells, cells);
    int64_t bricks = 0, brick_cells = 0;
    for (int64_t block = 0; block < layout.blockCount(); ++block) {
      const Box3 owned = layout.ownedCells(layout.indexOf(block));
      const BrickGrid grid = brickGrid(volume.span(), owned, 8);
      for (int64_t z = 0; z < grid.size.z; ++z)
        for (int64_t y = 0; y < grid.size.y; ++y)
          for (int64_t x = 0; x < grid.size.x; ++x) {
            const Vec3i at{x, y, z};
            const Box3 brick =
                intersect(translate(grid.cellsOf({at, at + Vec3i{1, 1, 1}}), owned.lo), crop);
            if (brick.empty() || !table.shown().anyIn(grid.at(at).lo, grid.at(at).hi)) continue;
            ++bricks;
            brick_cells += brick.count();
          }
    }
    EXPECT_EQ(cost.perfect_bricks, bricks);
    EXPECT_EQ(cost.perfect_cells, brick_cells);
    EXPECT_GT(brick_cells, 0);
    EXPECT_LT(brick_cells, crop.count());
  }
}

// A sparse volume whose outside is visible costs as much as the same volume stored densely.
TEST(VolumeBoxes, aVisibleBackgroundIsCountedWithoutBeingRead) {
  VolumeLayout layout;
  layout.dims = {70, 65, 40};
  const Box3 stored{{20, 20, 10}, {28, 28, 18}};
  const auto value = [&](int64_t, Vec3i p) { return stored.contains(p) ? 10.0 : 200.0; };
  FunctionSource sparse(layout, value, Occupancy{200, {stored}}), dense(layout, value);
  const BlockLayout blocks = blockLayout(layout.dims, 16, 0);
  WorkerPool pool(2);
  ProgressMeter progress;
  const SliceRanges ranges = buildSliceRanges(sparse, 0, blocks, {pool, progress});
  ASSERT_LT(ranges.blocks.size(), static_cast<size_t>(blocks.blockCount()) / 2);
  ASSERT_EQ(ranges.map.type, DeviceType::kU8);
  std::vector<PlaneRange<uint8_t>> totals(static_cast<size_t>(blocks.blockCount()), {200, 200});
  for (size_t i = 0; i < ranges.blocks.size(); ++i)
    totals[static_cast<size_t>(ranges.blocks[i])] = ranges.totalsAs<uint8_t>()[i];
  SliceRanges all = ranges;
  all.blocks = allBlocks(blocks);
  const auto bytes = std::as_bytes(std::span(totals));
  all.totals.assign(bytes.begin(), bytes.end());
  const OpacityTable table = tableOf(ranges, 100);
  for (const Box3& crop : {boxOf({69, 64, 39}), Box3{{3, 17, 9}, {41, 62, 38}}}) {
    const PartitionCost a = partitionCost(sparse, 0, ranges, table, crop, {pool, progress});
    const PartitionCost b = partitionCost(dense, 0, all, table, crop, {pool, progress});
    EXPECT_LT(a.blocks, b.blocks);
    EXPECT_EQ(a.visible_cells, b.visible_cells);
    EXPECT_EQ(a.visible_boxes, b.visible_boxes);
    EXPECT_EQ(a.perfect_bricks, b.perfect_bricks);
    EXPECT_EQ(a.perfect_cells, b.perfect_cells);
    EXPECT_EQ(a.boxes, b.boxes);
    EXPECT_EQ(a.grown, b.grown);
  }
}

}  // namespace
}  // namespace sluice::volume_boxes_test
