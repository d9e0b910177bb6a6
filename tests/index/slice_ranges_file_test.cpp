#include "src/index/slice_ranges_file.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>

#include "tests/support/random_volume.h"

namespace sluice {
namespace {

SliceRanges someRanges(VoxelType type, int ghost = 0) {
  BlobOptions options;
  options.type = type;
  options.dims = {30, 25, 20};
  options.blobs = 2;
  const auto source = makeSparseBlobs(options);
  WorkerPool pool(1);
  ProgressMeter quiet;
  return buildSliceRanges(*source, 0, blockLayout(options.dims, 8, ghost), {pool, quiet});
}

void expectSame(const SliceRanges& a, const SliceRanges& b) {
  EXPECT_EQ(a.layout.dims, b.layout.dims);
  EXPECT_EQ(a.layout.grid, b.layout.grid);
  EXPECT_EQ(a.map.type, b.map.type);
  EXPECT_EQ(a.map.scale, b.map.scale);
  EXPECT_EQ(a.map.offset, b.map.offset);
  EXPECT_EQ(a.background, b.background);
  EXPECT_EQ(a.blocks, b.blocks);
  EXPECT_EQ(a.totals, b.totals);
  EXPECT_EQ(a.planes, b.planes);
  EXPECT_EQ(a.device_range, b.device_range);
  EXPECT_EQ(a.far_range, b.far_range);
  EXPECT_EQ(a.counts, b.counts);
}

TEST(SliceRangesFile, comesBackAsItWas) {
  for (const VoxelType type : {VoxelType::kU8, VoxelType::kI16, VoxelType::kF64})
    for (const int ghost : {0, 1}) {
      const SliceRanges ranges = someRanges(type, ghost);
      ASSERT_FALSE(ranges.blocks.empty());
      const auto read = deserialize(serialize(ranges), ranges.layout, ranges.map);
      ASSERT_TRUE(read.has_value());
      expectSame(*read, ranges);
    }
}

TEST(SliceRangesFile, volumeOfNothingComesBackToo) {
  const auto source = makeMemorySource<uint8_t>(Vec3i{9, 9, 9}, [](auto...) { return 4; });
  WorkerPool pool(1);
  ProgressMeter quiet;
  const SliceRanges ranges =
      buildSliceRanges(*source, 0, blockLayout({9, 9, 9}, 8, 0), {pool, quiet});
  const auto read = deserialize(serialize(ranges), ranges.layout, ranges.map);
  ASSERT_TRUE(read.has_value());
  expectSame(*read, ranges);
}

TEST(SliceRangesFile, everyTruncationIsRejected) {
  const SliceRanges ranges = someRanges(VoxelType::kU8);
  const std::vector<std::byte> bytes = serialize(ranges);
  for (size_t length = 0; length < bytes.size(); ++length)
    ASSERT_FALSE(deserialize(std::span(bytes).first(length), ranges.layout, ranges.map))
        << length << " of " << bytes.size();
}

TEST(SliceRangesFile, bytesAfterTheEndAreRejected) {
  const SliceRanges ranges = someRanges(VoxelType::kU8);
  std::vector<std::byte> bytes = serialize(ranges);
  bytes.push_back(std::byte{0});
  EXPECT_FALSE(deserialize(bytes, ranges.layout, ranges.map));
}

TEST(SliceRangesFile, anotherLayoutOrMapIsRejected) {
  const SliceRanges ranges = someRanges(VoxelType::kU8);
  const std::vector<std::byte> bytes = serialize(ranges);
  BlockLayout other = ranges.layout;
  other.dims.z += 1;
  EXPECT_FALSE(deserialize(bytes, other, ranges.map));
  EXPECT_FALSE(deserialize(bytes, blockLayout(ranges.layout.dims, 16, 0), ranges.map));
  EXPECT_FALSE(deserialize(bytes, blockLayout(ranges.layout.dims, 8, 1), ranges.map));
  ValueMap map = ranges.map;
  map.type = DeviceType::kU16;
  EXPECT_FALSE(deserialize(bytes, ranges.layout, map));
  map = ranges.map;
  map.scale = 2;
  EXPECT_FALSE(deserialize(bytes, ranges.layout, map));
  map = ranges.map;
  map.offset = -1;
  EXPECT_FALSE(deserialize(bytes, ranges.layout, map));
}

TEST(SliceRangesFile, blocksThatDoNotExistAreRejected) {
  const SliceRanges good = someRanges(VoxelType::kU8);
  ASSERT_GT(good.blocks.size(), 2U);
  const auto accepted = [&](std::vector<int64_t> blocks) {
    SliceRanges bad = good;
    bad.blocks = std::move(blocks);
    return deserialize(serialize(bad), good.layout, good.map).has_value();
  };
  EXPECT_TRUE(accepted(good.blocks));
  std::vector<int64_t> blocks = good.blocks;
  blocks.back() = good.layout.blockCount();
  EXPECT_FALSE(accepted(blocks));
  blocks = good.blocks;
  blocks.front() = -1;
  EXPECT_FALSE(accepted(blocks));
  blocks = good.blocks;
  blocks[1] = blocks[0];
  EXPECT_FALSE(accepted(blocks));
  std::reverse(blocks.begin(), blocks.end());
  EXPECT_FALSE(accepted(blocks));
}

TEST(SliceRangesFile, anyByteMayBeWrongWithoutHarm) {
  const SliceRanges ranges = someRanges(VoxelType::kU8);
  const std::vector<std::byte> bytes = serialize(ranges);
  // Lengths stand in the first part: none of these may make us allocate or read beyond the end.
  for (size_t at = 0; at < bytes.size(); at += at < 256 ? 1 : 97)
    for (const int bit : {0, 3, 7}) {
      std::vector<std::byte> damaged = bytes;
      damaged[at] ^= static_cast<std::byte>(1 << bit);
      const auto read = deserialize(damaged, ranges.layout, ranges.map);
      if (!read) continue;
      EXPECT_EQ(read->blocks.size() * 2, read->totals.size());
      EXPECT_EQ(read->totals.size() * 3 * static_cast<size_t>(ranges.layout.planes()),
                read->planes.size());
    }
}

}  // namespace
}  // namespace sluice
