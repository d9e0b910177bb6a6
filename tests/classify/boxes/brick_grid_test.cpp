// Bricks against plain loops over the voxels and over interpolated samples.
#include "src/classify/boxes/brick_grid.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tests/classify/device_volume.h"
#include "tests/support/random_volume.h"

namespace sluice::brick_grid_test {
namespace {

Vec3d gradientAt(const DeviceVolume& volume, Vec3i p, Vec3d voxel_size) {
  Vec3d gradient;
  for (int a = 0; a < 3; ++a) {
    Vec3i up = p, down = p;
    ++up[a];
    --down[a];
    gradient[a] = (static_cast<double>(volume.at(up)) - volume.at(down)) / 2 / voxel_size[a];
  }
  return gradient;
}

// Between the corners of `cell`, at `t` in [0, 1]^3.
Vec3d interpolatedGradient(const DeviceVolume& volume, Vec3i cell, Vec3d t, Vec3d voxel_size) {
  Vec3d sum;
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3i offset{corner & 1, corner >> 1 & 1, corner >> 2};
    double weight = 1;
    for (int a = 0; a < 3; ++a) weight *= offset[a] == 1 ? t[a] : 1 - t[a];
    sum = sum + gradientAt(volume, cell + offset, voxel_size) * weight;
  }
  return sum;
}

void expectRight(const DeviceVolume& volume, const BrickGrid& grid, Vec3d voxel_size) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> share(0, 1);
  for (int64_t z = 0; z < grid.size.z; ++z)
    for (int64_t y = 0; y < grid.size.y; ++y)
      for (int64_t x = 0; x < grid.size.x; ++x) {
        const Vec3i brick{x, y, z};
        const Box3 cells = translate(grid.cellsOf({brick, brick + Vec3i{1, 1, 1}}), grid.cells.lo);
        float lo = std::numeric_limits<float>::max(), hi = std::numeric_limits<float>::lowest();
        double greatest = 0;
        for (int64_t k = cells.lo.z; k <= cells.hi.z; ++k)
          for (int64_t j = cells.lo.y; j <= cells.hi.y; ++j)
            for (int64_t i = cells.lo.x; i <= cells.hi.x; ++i) {
              lo = std::min(lo, volume.at({i, j, k}));
              hi = std::max(hi, volume.at({i, j, k}));
              greatest = std::max(greatest, length(gradientAt(volume, {i, j, k}, voxel_size)));
            }
        const CellRange& range = grid.at(brick);
        ASSERT_EQ(range.lo, lo);
        ASSERT_EQ(range.hi, hi);
        ASSERT_NEAR(range.gradient_hi, greatest, 1e-5 * greatest);
        for (int sample = 0; sample < 8; ++sample) {
          const Vec3d t{share(random), share(random), share(random)};
          const Vec3i cell = cells.lo + Vec3i{static_cast<int64_t>(random() % cells.size().x),
                                              static_cast<int64_t>(random() % cells.size().y),
                                              static_cast<int64_t>(random() % cells.size().z)};
          const double magnitude = length(interpolatedGradient(volume, cell, t, voxel_size));
          ASSERT_GE(magnitude, range.gradient_lo * (1 - 1e-5));
          ASSERT_LE(magnitude, range.gradient_hi * (1 + 1e-5));
        }
      }
}

TEST(BrickGrid, boundsValuesAndGradientsOfEachBrickForEveryType) {
  for (const VoxelType type : {VoxelType::kU8, VoxelType::kI16, VoxelType::kU16, VoxelType::kF32})
    for (const int64_t side : {1, 3, 4, 8}) {
      SCOPED_TRACE(fmt::format("{} side {}", name(type), side));
      const auto noise = makeWhiteNoise({21, 18, 16}, type, 3);
      const DeviceVolume volume(*noise);
      const Vec3d size{1, 1.5, 2};
      expectRight(volume, brickGrid(volume.span(), {{3, 2, 5}, {20, 15, 14}}, side, size), size);
      expectRight(volume, brickGrid(volume.span(), volume.cells(), side, size), size);
    }
}

TEST(BrickGrid, aSlopeHasTheGradientThatItHas) {
  const auto source = makeMemorySource<uint8_t>(
      Vec3i{16, 16, 16}, [](int64_t x, int64_t y, int64_t) { return 3 * x + 4 * y; });
  const DeviceVolume volume(*source);
  const BrickGrid grid = brickGrid(volume.span(), {{4, 4, 4}, {12, 12, 12}}, 4);
  EXPECT_EQ(grid.size, (Vec3i{2, 2, 2}));
  for (const CellRange& range : grid.bricks) {
    EXPECT_FLOAT_EQ(range.gradient_lo, 5);
    EXPECT_FLOAT_EQ(range.gradient_hi, 5);
    EXPECT_FLOAT_EQ(range.width(), 28);
  }
}

// The magnitude at both corners of a cell is 10, and 0 where the gradients meet in the middle.
TEST(BrickGrid, oppositeGradientsMayCancelBetweenVoxels) {
  const auto source = makeMemorySource<uint8_t>(
      Vec3i{8, 8, 8}, [](int64_t x, int64_t, int64_t) { return 10 * (x < 4 ? x : 7 - x); });
  const DeviceVolume volume(*source);
  const BrickGrid grid = brickGrid(volume.span(), {{2, 2, 2}, {5, 5, 5}}, 3);
  EXPECT_EQ(grid.bricks.front().gradient_lo, 0);
  EXPECT_EQ(grid.bricks.front().gradient_hi, 10);
}

TEST(BrickGrid, notANumberStaysFinite) {
  const auto source =
      makeMemorySource<float>(Vec3i{9, 9, 9}, [](int64_t x, int64_t y, int64_t z) -> float {
        if (x == 4) return std::numeric_limits<float>::quiet_NaN();
        if (y == 7) return std::numeric_limits<float>::infinity();
        return static_cast<float>(z);
      });
  const DeviceVolume volume(*source);
  for (const CellRange& range : brickGrid(volume.span(), volume.cells(), 4).bricks) {
    EXPECT_LE(kNotANumber, range.lo);
    EXPECT_LE(range.lo, range.hi);
    EXPECT_LE(range.hi, kLargest);
    EXPECT_LE(0, range.gradient_lo);
    EXPECT_LE(range.gradient_lo, range.gradient_hi);
    EXPECT_LE(range.gradient_hi, kLargest);
  }
}

TEST(BrickGrid, largeBlocksHaveLargerBricks) {
  const auto source =
      makeMemorySource<uint8_t>(Vec3i{301, 3, 5}, [](int64_t x, auto...) { return x % 251; });
  const DeviceVolume volume(*source);
  const BrickGrid grid = brickGrid(volume.span(), volume.cells(), 4);
  EXPECT_EQ(grid.side, 8);
  EXPECT_EQ(grid.size, (Vec3i{38, 1, 1}));
  expectRight(volume, grid, {1, 1, 1});
}

TEST(BrickGrid, boxesOfBricksAndOfCellsCorrespond) {
  BrickGrid grid;
  grid.cells = {{10, 20, 30}, {10 + 63, 20 + 13, 30 + 4}};
  grid.side = 4;
  grid.size = {16, 4, 1};
  const Box3 bricks{{3, 2, 0}, {16, 4, 1}};
  EXPECT_EQ(grid.cellsOf(bricks), (Box3{{12, 8, 0}, {63, 13, 4}}));
  EXPECT_EQ(grid.bricksOf(grid.cellsOf(bricks)), bricks);
}

}  // namespace
}  // namespace sluice::brick_grid_test
