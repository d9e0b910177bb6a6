// Levels that nest: their blocks' regions tile the volume, hold whole regions of the next finer
// level, and each block stores all voxels that interpolation in its region takes.
#include "src/volume/pyramid.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <memory>
#include <random>
#include <vector>

#include "tests/support/memory_source.h"

namespace sluice {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

constexpr int kSize = 16;

LevelPlacement averaged(Vec3i times) {
  const Vec3d scale = toDouble(times);
  return {scale, (scale - Vec3d{1, 1, 1}) * 0.5};
}

// Checks the comment above.
void expectNests(const PyramidLayout& pyramid, int margin) {
  const Vec3i finest_cells = pyramid.finest().dims - Vec3i{1, 1, 1};
  for (int level = 0; level < pyramid.levels(); ++level) {
    const LevelLayout& at = pyramid.level(level);
    int64_t cells = 0;
    for (int64_t block = 0; block < at.blocks.blockCount(); ++block) {
      const BlockName name{.level = level, .block = block};
      const Vec3i index = at.blocks.indexOf(block);
      const Box3 region = pyramid.regionOf(name);
      ASSERT_FALSE(region.empty());
      ASSERT_TRUE(boxOf(finest_cells).contains(region));
      cells += region.count();
      // Positions in double precision, apart from the code's own rounding.
      const Box3 cube = at.blocks.cube(index);
      for (int a = 0; a < 3; ++a) {
        const double lo =
            (static_cast<double>(region.lo[a]) - at.placement.offset[a]) / at.placement.scale[a];
        const double hi =
            (static_cast<double>(region.hi[a]) - at.placement.offset[a]) / at.placement.scale[a];
        ASSERT_GE(lo - margin, static_cast<double>(cube.lo[a]) - 1e-5);
        // Beyond the last voxel all planes are alike, so that none more are missed.
        const double beside = hi > static_cast<double>(at.blocks.dims[a] - 1) ? 0 : margin;
        ASSERT_LE(hi + beside, static_cast<double>(cube.hi[a] - 1) + 1e-5);
      }
      const Box3 under = at.voxelsUnder(region);
      ASSERT_TRUE(cube.contains(under));
      if (level == 0) {
        ASSERT_EQ(region, at.blocks.ownedCells(index));
        continue;
      }
      const Box3 children = pyramid.childrenOf(level, index);
      Box3 together;
      int64_t child_cells = 0;
      for (int64_t z = children.lo.z; z < children.hi.z; ++z)
        for (int64_t y = children.lo.y; y < children.hi.y; ++y)
          for (int64_t x = children.lo.x; x < children.hi.x; ++x) {
            const Box3 child = pyramid.regionOf(level - 1, {x, y, z});
            together = unite(together, child);
            child_cells += child.count();
          }
      ASSERT_EQ(together, region);
      ASSERT_EQ(child_cells, region.count());
    }
    ASSERT_EQ(cells, volume(finest_cells)) << "level " << level;
  }
}

TEST(PyramidLayout, oneLevelIsTheBlocksThemselves) {
  for (const int ghost : {0, 1}) {
    const PyramidLayout pyramid(blockLayout({50, 36, 43}, 8, ghost));
    EXPECT_EQ(pyramid.levels(), 1);
    expectNests(pyramid, 0);
  }
}

TEST(PyramidLayout, averagesOfAnySizeNest) {
  std::mt19937 random(1);
  for (int trial = 0; trial < 60; ++trial) {
    Vec3i dims;
    for (int a = 0; a < 3; ++a) dims[a] = 2 + static_cast<int64_t>(random() % 120);
    const int ghost = trial % 2 + 1;
    const int64_t up = trial % 3 == 0 ? 0 : 1;  // odd sizes rounded down or up
    PyramidLayout pyramid(blockLayout(dims, kSize, ghost));
    Vec3i times{1, 1, 1}, size = dims;
    while (std::max({size.x, size.y, size.z}) > 12) {
      for (int a = 0; a < 3; ++a) {
        const int64_t by = size[a] < 4 ? 1 : 2 + static_cast<int64_t>(random() % 2);
        times[a] *= by;
        size[a] = (size[a] + up * (by - 1)) / by;
      }
      if (std::min({size.x, size.y, size.z}) < 2) break;
      ASSERT_THAT(pyramid.add(size, averaged(times)), IsEmpty())
          << dims.x << ' ' << dims.y << ' ' << dims.z;
    }
    expectNests(pyramid, ghost - 1);
    if (testing::Test::HasFatalFailure())
      FAIL() << "dims " << dims.x << ' ' << dims.y << ' ' << dims.z;
  }
}

// Writers that halve sizes and round down: what a level leaves out at the end grows from level to
// level, and blocks of any size have its values there.
TEST(PyramidLayout, halvesRoundedDownNestInBlocksOfAnySize) {
  for (const int size : {8, 16, 32, 64})
    for (const Vec3i dims : {Vec3i{139, 79, 115}, Vec3i{127, 63, 255}, Vec3i{95, 191, 111}}) {
      SCOPED_TRACE(fmt::format("blocks of {}, {} x {} x {}", size, dims.x, dims.y, dims.z));
      std::vector<std::unique_ptr<MemorySource>> sources;
      std::vector<CoarserLevel> levels;
      for (int64_t times = 2; times <= 16; times *= 2) {
        sources.push_back(
            makeMemorySource<uint8_t>(dims / times, [](auto, auto, auto) { return 0; }));
        levels.push_back({sources.back().get(), averaged({times, times, times})});
      }
      PyramidLayout pyramid(blockLayout(dims, size, ghostOfLevels(dims, size, levels)));
      for (const CoarserLevel& level : levels)
        ASSERT_THAT(pyramid.add(level.source->layout().dims, level.placement), IsEmpty());
      expectNests(pyramid, 1);
    }
}

TEST(PyramidLayout, keptVoxelsAndScalesOfRoundedSizesNest) {
  PyramidLayout kept(blockLayout({101, 64, 77}, kSize, 1));
  ASSERT_THAT(kept.add({51, 32, 39}, {{2, 2, 2}, {0, 0, 0}}), IsEmpty());
  expectNests(kept, 0);
  // Writers that divide the sizes: 101 / 50.
  PyramidLayout divided(blockLayout({101, 64, 77}, kSize, 1));
  const Vec3d scale{101.0 / 50, 2, 77.0 / 38};
  ASSERT_THAT(divided.add({50, 32, 38}, {scale, (scale - Vec3d{1, 1, 1}) * 0.5}), IsEmpty());
  expectNests(divided, 0);
}

TEST(PyramidLayout, anAxisMayStayAsItIs) {
  PyramidLayout pyramid(blockLayout({90, 90, 20}, kSize, 2));
  ASSERT_THAT(pyramid.add({45, 45, 20}, averaged({2, 2, 1})), IsEmpty());
  ASSERT_THAT(pyramid.add({15, 22, 10}, averaged({6, 4, 2})), IsEmpty());
  expectNests(pyramid, 1);
  EXPECT_EQ(pyramid.level(2).width, (Vec3i{6 * 11, 4 * 11, 2 * 11}));
}

TEST(PyramidLayout, levelsThatDoNotNestAreLeftOutWithAReason) {
  PyramidLayout pyramid(blockLayout({100, 100, 100}, kSize, 1));
  EXPECT_THAT(pyramid.add({67, 67, 67}, {{1.49, 1, 1}, {0.245, 0, 0}}),
              HasSubstr("along x its voxels are 1.49 times as wide"));
  EXPECT_THAT(pyramid.add({50, 50, 50}, {{2, 2, 2}, {20, 0, 0}}),
              HasSubstr("along x its first voxel lies at 20 among those of level 0, expected 0 to "
                        "0.5"));
  EXPECT_THAT(pyramid.add({30, 50, 50}, averaged({2, 2, 2})),
              HasSubstr("along x its 30 voxels, 2 times as wide as those of level 0, end elsewhere "
                        "than the 100 of level 0"));
  EXPECT_THAT(pyramid.add({100, 100, 100}, {}), HasSubstr("no larger"));
  EXPECT_THAT(pyramid.add({50, 50, 1}, averaged({2, 2, 100})), HasSubstr("fewer than 2"));
  EXPECT_THAT(pyramid.add({200, 100, 100}, {{0.4, 1, 1}, {0, 0, 0}}), HasSubstr("finer"));
  EXPECT_EQ(pyramid.levels(), 1);
}

TEST(LevelLayout, cellsAndVoxelsOfAnAverage) {
  PyramidLayout pyramid(blockLayout({64, 64, 64}, kSize, 1));
  ASSERT_THAT(pyramid.add({32, 32, 32}, averaged({2, 2, 2})), IsEmpty());
  const LevelLayout& level = pyramid.level(1);
  // Finest cells 4 and 5 lie from 4 to 6, which is from 1.75 to 2.75 of the level.
  EXPECT_EQ(level.voxelsUnder({{4, 4, 4}, {6, 6, 6}}), (Box3{{1, 1, 1}, {4, 4, 4}}));
  // Cell 3 of the level lies from 6.5 to 8.5.
  EXPECT_EQ(level.cellsOver({{3, 3, 3}, {4, 4, 4}}), (Box3{{6, 6, 6}, {9, 9, 9}}));
}

}  // namespace
}  // namespace sluice
