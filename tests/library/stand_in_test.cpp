// A coarse level in place of a finest one that was not read.
#include "src/library/opening/levels/stand_in.h"

#include <gtest/gtest.h>

#include "io/synth/mean_levels.h"
#include "src/base/threads/progress_meter.h"
#include "src/classify/blocks/classification.h"
#include "src/index/stale_check.h"
#include "src/library/opening/indexed_volume.h"
#include "tests/support/function_source.h"

namespace sluice {
namespace {

ValueRange meansOf(const CoarserLevel& level) {
  WorkerPool pool(2);
  ProgressMeter progress;
  const BlockLayout layout = blockLayout(level.source->layout().dims, 16, 0);
  return buildSliceRanges(*level.source, 0, layout, {pool, progress}).device_range;
}

// Channels of one file have one line if it holds for all of them.
TEST(StandIn, isToldOncePerVolumeOrOfTheChannelsThatHaveOne) {
  std::vector<IndexedVolume> volumes(3);
  std::vector<const IndexedVolume*> all;
  for (size_t i = 0; i < volumes.size(); ++i) {
    volumes[i].name = "cells.zarr";
    volumes[i].channel.number = static_cast<int64_t>(i);
    volumes[i].channel.name = i == 1 ? "GFP" : "";
    all.push_back(&volumes[i]);
  }
  EXPECT_TRUE(standInNotes(all).empty());
  const std::string told =
      "level 0 has no index yet; the range of values, the look and the fit come from level 2 and "
      "may differ a little from those of level 0";
  for (const size_t i : {1U, 2U})
    volumes[i].stand_in = {.level = 2, .index = {}, .device_range = {}};
  EXPECT_EQ(standInNotes(all), (std::vector<std::string>{"cells.zarr: channel 1 (GFP): " + told,
                                                         "cells.zarr: channel 2: " + told}));
  volumes[0].stand_in = volumes[1].stand_in;
  EXPECT_EQ(standInNotes(all), std::vector<std::string>{"cells.zarr: " + told});
}

TEST(StandIn, spreadsTellTheRangeOfTwoValues) {
  WorkerPool pool(2);
  for (const VoxelType type : {VoxelType::kU8, VoxelType::kU16, VoxelType::kF32})
    for (const bool dark_lines : {false, true}) {
      // Lines two voxels wide, which no coarse voxel is full of.
      FunctionSource net(functionLayout({64, 60, 56}, type), [&](int64_t, Vec3i v) {
        const bool on_line = v.x % 16 < 2 && v.y % 16 < 4;
        return on_line != dark_lines ? 180.0 : 20.0;
      });
      const MeanLevels levels(net, 4, Spreads::kKept);
      for (const CoarserLevel& level : levels.levels()) {
        const ValueRange means = meansOf(level);
        const Box3 cells = brickCells(level.source->layout().dims, std::nullopt);
        const ValueRange range = reachOfSpreads(level, means, cells, 0, pool).range;
        if (level.placement.scale.x > 2) {
          EXPECT_GT(means.hi - means.lo, 1);
          EXPECT_LT(means.hi - means.lo, 150);
        }
        EXPECT_NEAR(range.lo, 20, 8) << name(type);
        EXPECT_NEAR(range.hi, 180, 8) << name(type);
      }
    }
}

TEST(StandIn, withoutSpreadTheRangeIsThatOfTheMeans) {
  WorkerPool pool(1);
  FunctionSource steps(functionLayout({32, 32, 32}, VoxelType::kU8),
                       [](int64_t, Vec3i v) { return 10.0 * static_cast<double>(v.z / 8); });
  const MeanLevels levels(steps, 3, Spreads::kKept);
  const Box3 cells = brickCells(levels.levels()[1].source->layout().dims, std::nullopt);
  const ValueRange range = reachOfSpreads(levels.levels()[1], {0, 30}, cells, 0, pool).range;
  EXPECT_EQ(range, (ValueRange{0, 30}));
}

// A fit looks at these bricks: a thin vessel shows by its spread, not by its mean.
TEST(StandIn, bricksHaveTheValuesThatSpreadsAreDrawnWith) {
  WorkerPool pool(2);
  for (const VoxelType type : {VoxelType::kU8, VoxelType::kU16, VoxelType::kF32}) {
    SCOPED_TRACE(name(type));
    FunctionSource vessel(functionLayout({64, 64, 64}, type),
                          [&](int64_t, Vec3i v) { return v.x == 40 && v.y == 24 ? 220.0 : 20.0; });
    const MeanLevels levels(vessel, 3, Spreads::kKept);
    const CoarserLevel& level = levels.levels()[1];
    const Box3 cells = brickCells(level.source->layout().dims, std::nullopt);
    const ValueRange means = meansOf(level);
    EXPECT_LT(means.hi, 40);
    const SpreadReach reach = reachOfSpreads(level, means, cells, 0, pool);
    const Vec3i grid = reach.drawn.bricks.grid();
    const auto shows = [&](Vec3i cell) {
      const Vec3i brick = cell / reach.drawn.bricks.side;
      const auto at = static_cast<size_t>((brick.z * grid.y + brick.y) * grid.x + brick.x);
      return visitDeviceType(deviceMap(level.source->layout()).type, [&](auto tag) {
        return static_cast<double>(reach.drawn.bricks.rangesAs<decltype(tag)>()[at].hi) > 100;
      });
    };
    EXPECT_TRUE(shows({10, 6, 0}));
    EXPECT_TRUE(shows({9, 5, 14})) << "interpolated from the vessel's voxels";
    EXPECT_FALSE(shows({12, 6, 0}));
    EXPECT_FALSE(shows({2, 2, 2}));
  }
}

TEST(StandIn, theCoarsestLevelThatIsLargeEnoughStandsIn) {
  const auto levelOf = [](int64_t side) {
    PyramidLayout pyramid(blockLayout({side, side, side}, 64, 1));
    for (double scale = 2; side / scale >= 64; scale *= 2) {
      const auto dims = static_cast<int64_t>(static_cast<double>(side) / scale);
      const double offset = (scale - 1) / 2;
      EXPECT_EQ(pyramid.add({dims, dims, dims}, {{scale, scale, scale}, {offset, offset, offset}}),
                "");
    }
    return standInLevel(pyramid);
  };
  EXPECT_EQ(levelOf(128), 1) << "there is no larger one";
  EXPECT_EQ(levelOf(512), 2);
  EXPECT_EQ(levelOf(4096), 5);
}

// Nothing is known of a block: every cell may show something, whatever the transfer function.
TEST(StandIn, anythingMayShowInBlocksWithoutKnownValues) {
  FunctionSource source(functionLayout({40, 33, 20}, VoxelType::kU8),
                        [](int64_t, Vec3i) -> double { throw Error("a voxel is read"); });
  WorkerPool pool(2);
  const BlockLayout layout = blockLayout({40, 33, 20}, 16, 1);
  const SliceRanges ranges = unknownRanges(source, 0, layout);
  EXPECT_EQ(static_cast<int64_t>(ranges.unknown.size()), layout.blockCount());
  TransferFunction transfer;
  transfer.colors = {{0, {1, 1, 1}}};
  transfer.opacities = {{200, 0}, {201, 1}};
  const OpacityTable table(transfer, ranges.map, {0, 100});
  const Box3 crop{{3, 0, 0}, {39, 32, 19}};
  const VisibleBlocks shown = classify(ranges, table, crop, pool);
  int64_t cells = 0;
  for (const ObjectBlock& block : shown.blocks) cells += block.cells.count();
  EXPECT_EQ(cells, crop.count());
  EXPECT_TRUE(std::ranges::is_sorted(shown.blocks, {}, &ObjectBlock::name));
}

}  // namespace
}  // namespace sluice
