// Brick ranges as bytes.
#include "src/index/brick_ranges_file.h"

#include <gtest/gtest.h>

#include "tests/support/random_volume.h"

namespace sluice {
namespace {

constexpr Vec3i kDims{20, 17, 13};

BrickRanges someBricks(VoxelType type) {
  const auto source = makeWhiteNoise(kDims, type, 3);
  WorkerPool pool(1);
  ProgressMeter quiet;
  BrickRanges bricks;
  buildSliceRanges(*source, 0, blockLayout(kDims, 8, 0), {pool, quiet}, bricks);
  return bricks;
}

TEST(BrickRangesFile, comesBackAsItWas) {
  for (const auto& [type, device] : {std::pair{VoxelType::kU8, DeviceType::kU8},
                                     {VoxelType::kI16, DeviceType::kU16},
                                     {VoxelType::kF64, DeviceType::kF32}}) {
    const BrickRanges bricks = someBricks(type);
    const auto read = deserializeBricks(serialize(bricks), kDims, device);
    ASSERT_TRUE(read.has_value());
    EXPECT_EQ(read->cells, bricks.cells);
    EXPECT_EQ(read->side, bricks.side);
    EXPECT_EQ(read->ranges, bricks.ranges);
  }
  EXPECT_TRUE(deserializeBricks(serialize(BrickRanges{}), kDims, DeviceType::kU8).has_value());
}

TEST(BrickRangesFile, bytesOfAnotherVolumeAreRejected) {
  const BrickRanges bricks = someBricks(VoxelType::kU8);
  std::vector<std::byte> bytes = serialize(bricks);
  EXPECT_FALSE(deserializeBricks(bytes, kDims, DeviceType::kU16));
  EXPECT_FALSE(deserializeBricks(bytes, kDims - Vec3i{1, 0, 0}, DeviceType::kU8));
  for (size_t length = 0; length < bytes.size(); length += 7)
    EXPECT_FALSE(deserializeBricks(std::span(bytes).first(length), kDims, DeviceType::kU8));
  bytes.push_back(std::byte{0});
  EXPECT_FALSE(deserializeBricks(bytes, kDims, DeviceType::kU8));
}

}  // namespace
}  // namespace sluice
