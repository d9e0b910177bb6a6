// Partitions against plain loops over voxels, on random volumes and on the real ones.
#include "src/classify/boxes/growing_boxes.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "tests/classify/boxes/partition.h"
#include "tests/classify/device_volume.h"
#include "tests/support/random_volume.h"

namespace sluice {
namespace {

TEST(GrowingBoxes, partitionRandomVolumesOfEveryType) {
  for (const VoxelType type : {VoxelType::kU8, VoxelType::kI16, VoxelType::kU16, VoxelType::kF32})
    for (const uint64_t seed : {1, 2, 3}) {
      SCOPED_TRACE(fmt::format("{} seed {}", name(type), seed));
      const auto blobs = makeSparseBlobs({.type = type, .seed = seed});
      const DeviceVolume volume(*blobs);
      for (const int64_t block_vox : {16, 32})
        expectRight(volume, grownPartition(volume, block_vox));
      const auto noise = makeWhiteNoise({33, 29, 18}, type, seed);
      const DeviceVolume rough(*noise);
      expectRight(rough, grownPartition(rough, 32));
    }
}

TEST(GrowingBoxes, oneValueIsOneUniformBox) {
  const auto source = makeMemorySource<uint8_t>(Vec3i{32, 32, 32}, [](auto...) { return 7; });
  const DeviceVolume volume(*source);
  const auto boxes = grownPartition(volume, 32);
  ASSERT_EQ(boxes.size(), 1U);
  EXPECT_EQ(boxes[0].box.type, BoxType::kUniform);
  EXPECT_EQ(boxes[0].box.range, (CellRange{7, 7, 0, 0}));
}

TEST(GrowingBoxes, aSurfaceIsCutFromWhatItDivides) {
  const auto source = makeMemorySource<uint8_t>(
      Vec3i{65, 65, 65}, [](int64_t x, auto...) { return x < 33 ? 10 : 200; });
  const DeviceVolume volume(*source);
  int64_t uniform_cells = 0;
  for (const auto& [cells, box] : grownPartition(volume, 64)) {
    const bool holds_surface = cells.lo.x <= 32 && cells.hi.x > 32;
    if (holds_surface) {
      EXPECT_EQ(box.type, BoxType::kGradient);
    }
    if (holds_surface) {
      EXPECT_LE(cells.size().x, 4 * kSide) << "three bricks in vain for one";
    }
    if (box.type == BoxType::kUniform) uniform_cells += cells.count();
  }
  EXPECT_GE(uniform_cells, volume.cells().count() * 8 / 10);
}

TEST(GrowingBoxes, faintValuesAreCutFromTheBackground) {
  const auto source = makeMemorySource<uint8_t>(
      Vec3i{65, 65, 65}, [](int64_t x, int64_t y, auto...) { return x < 33 ? 0 : 1 + y % 2; });
  const DeviceVolume volume(*source);
  int64_t empty = 0;
  for (const auto& [cells, box] : grownPartition(volume, 64))
    if (box.range.hi == 0) empty += cells.count();
  EXPECT_EQ(empty, 32 * 64 * 64);
}

TEST(GrowingBoxes, everyBoxKeepsWithinItsLimits) {
  const auto source = makeSparseBlobs({.dims = {64, 64, 64}, .blobs = 12, .radius_vox = 9});
  const DeviceVolume volume(*source);
  const BrickGrid grid = brickGrid(volume.span(), boxOf({63, 63, 63}), kSide);
  const GrowingParameters parameters;
  for (const GrownBox& box : growBoxes(grid, parameters)) {
    const double cost = costOf(grid, grid.bricksOf(box.local()), box.range, parameters);
    EXPECT_TRUE(isWithinLimits(cost, box.local().count(), parameters)) << cost;
  }
}

TEST(GrowingBoxes, parametersFollowTheRangeOfWiderTypes) {
  EXPECT_EQ(growingParameters(DeviceType::kU8, {0, 100}).uniform_range, 32);
  EXPECT_EQ(growingParameters(DeviceType::kU16, {1000, 1000 + 25600}).uniform_range, 3200);
  EXPECT_FLOAT_EQ(growingParameters(DeviceType::kF32, {-1, 1}).gradient_floor, 1.F / 16);
}

TEST(GrowingBoxes, typesAreThePapers) {
  const GrowingParameters p;
  EXPECT_EQ(typeOf({0, 32, 0, 0}, 512, p), BoxType::kUniform);
  EXPECT_EQ(typeOf({0, 33, 0, 0}, 512, p), BoxType::kOther) << "too wide in values";
  EXPECT_EQ(typeOf({0, 32, 0, 0}, 511, p), BoxType::kOther) << "too small";
  EXPECT_EQ(typeOf({0, 32, 0, 8.5F}, 512, p), BoxType::kGradient);
}

}  // namespace
}  // namespace sluice
