// How slice ranges are read: each row of blocks once and in pieces that fit, of sparse volumes only
// the stored parts, and the effect of a failed read.
#include <gtest/gtest.h>

#include <array>
#include <cstring>
#include <map>
#include <random>

#include "src/base/error.h"
#include "src/base/threads/stop_token.h"
#include "src/volume/ranges/slice_ranges.h"
#include "tests/support/counting_source.h"
#include "tests/support/failing_source.h"
#include "tests/support/function_source.h"
#include "tests/support/random_volume.h"
#include "tests/volume/slice_ranges_check.h"

namespace sluice {
namespace {

// --- reading

TEST(SliceRanges, eachRowOfBlocksIsReadOnce) {
  const auto memory = makeWhiteNoise({50, 40, 30}, VoxelType::kU8, 3);
  CountingSource source(*memory);
  const SliceRanges ranges = buildRanges(source, 8);
  // Neighbours share a plane: both rows read the shared planes of y and z.
  const Vec3i grid = ranges.layout.grid;
  EXPECT_EQ(source.counts().calls, grid.y * grid.z);
  EXPECT_EQ(source.counts().bytes, 50 * (40 + grid.y - 1) * (30 + grid.z - 1));
}

TEST(SliceRanges, blocksOf64ReadLittleMoreThanTheVolume) {
  const auto memory = makeMemorySource<uint8_t>(Vec3i{127, 127, 127}, [](auto...) { return 1; });
  CountingSource source(*memory);
  buildRanges(source, 64);
  EXPECT_LE(static_cast<double>(source.counts().bytes), 1.04 * 127 * 127 * 127);
}

TEST(SliceRanges, longRowsAreReadInPieces) {
  VolumeLayout layout;
  layout.dims = {63 * 100 + 1, 2, 2};
  FunctionSource computed(layout, [](int64_t, Vec3i p) { return p.x % 251; });
  // 64^3 blocks of a byte stored and a byte converted: 67 in 32 MiB, 16 in a sixteenth of 128 MiB.
  CountingSource source(computed);
  const SliceRanges two_threads = buildRanges(source, 64, 0, 2);
  EXPECT_EQ(source.counts().calls, 2);
  source.reset();
  const SliceRanges sixteen_threads = buildRanges(source, 64, 0, 16);
  EXPECT_EQ(source.counts().calls, 7);
  EXPECT_EQ(two_threads.planes, sixteen_threads.planes);
  expectRangesOf(sixteen_threads, [](Vec3i p) { return static_cast<double>(p.x % 251); });
}

TEST(SliceRanges, hugeBlocksAreReadOneAtATime) {
  VolumeLayout layout;
  layout.dims = {1100, 3, 3};
  layout.type = VoxelType::kF64;
  FunctionSource computed(layout, [](int64_t, Vec3i p) { return static_cast<double>(p.x); });
  CountingSource source(computed);
  const SliceRanges ranges = buildRanges(source, 512);
  EXPECT_EQ(source.counts().calls, 3);
  expectRangesOf(ranges, [](Vec3i p) { return static_cast<double>(p.x); });
}

// --- sparse volumes

FunctionSource sparseSource(Vec3i dims, VoxelType type, double background,
                            const std::vector<Box3>& boxes, FunctionSource::Value value) {
  VolumeLayout layout;
  layout.dims = dims;
  layout.type = type;
  return {layout,
          [=](int64_t time, Vec3i p) {
            for (const Box3& box : boxes)
              if (box.contains(p)) return value(time, p);
            return background;
          },
          Occupancy{background, boxes}};
}

TEST(SliceRanges, occupancyGivesWhatReadingEverythingGives) {
  std::mt19937 random(4);
  for (int trial = 0; trial < 20; ++trial) {
    const Vec3i dims{40, 33, 29};
    std::vector<Box3> boxes;
    for (int i = 0; i < 3; ++i) {
      Box3 box;
      for (int a = 0; a < 3; ++a) {
        box.lo[a] = static_cast<int64_t>(random() % static_cast<unsigned>(dims[a]));
        box.hi[a] = std::min(dims[a], box.lo[a] + 1 + static_cast<int64_t>(random() % 6));
      }
      boxes.push_back(box);
    }
    const auto valueAt = [&](Vec3i p) {
      for (const Box3& box : boxes)
        if (box.contains(p)) return static_cast<double>(100 + p.x + p.y + p.z);
      return 7.0;
    };
    FunctionSource sparse = sparseSource(dims, VoxelType::kU16, 7, boxes, [](int64_t, Vec3i p) {
      return static_cast<double>(100 + p.x + p.y + p.z);
    });
    FunctionSource dense(sparse.layout(), [&](int64_t, Vec3i p) { return valueAt(p); });
    for (const int ghost : {0, 1}) {
      const SliceRanges ranges = buildRanges(sparse, 8, ghost), all = buildRanges(dense, 8, ghost);
      EXPECT_EQ(ranges.counts, all.counts);
      EXPECT_LT(sparse.storedBytesRead(), dense.storedBytesRead());
      EXPECT_EQ(ranges.background, 7);
      expectRangesOf(ranges, valueAt);
      if (HasFatalFailure()) FAIL() << "trial " << trial << " ghost " << ghost;
    }
  }
}

TEST(SliceRanges, aTinyPartOfAnEnormousIndexSpaceCostsItself) {
  const int64_t billion = 1'000'000'000;
  const std::vector<Box3> boxes{{{5, 6, 7}, {9, 9, 9}},
                                {{billion - 4, billion - 4, 996}, {billion, billion, 1000}}};
  FunctionSource computed = sparseSource({billion, billion, 1000}, VoxelType::kF32, 0.25, boxes,
                                         [](int64_t, Vec3i p) { return static_cast<double>(p.z); });
  CountingSource source(computed);
  const SliceRanges ranges = buildRanges(source, 64);
  EXPECT_EQ(ranges.blocks, (std::vector<int64_t>{0, ranges.layout.blockCount() - 1}));
  EXPECT_EQ(ranges.device_range, (ValueRange{0.25, 999}));
  EXPECT_EQ(ranges.totalsAs<float>()[0].hi, 8);
  EXPECT_EQ(ranges.totalsAs<float>()[1].hi, 999);
  EXPECT_LE(source.counts().voxels, 2 * 64 * 64 * 64);
  EXPECT_GT(ranges.counts.entries.front().count, 1'000'000'000'000U)
      << "background not read counts";
  EXPECT_LE(ranges.bytes(), 2U * (8 + 8 + 3 * 64 * 8));
}

TEST(SliceRanges, aVoxelOnASharedPlaneIsInBothBlocks) {
  FunctionSource source = sparseSource({30, 8, 8}, VoxelType::kU8, 0, {{{14, 0, 0}, {15, 1, 1}}},
                                       [](int64_t, Vec3i) { return 9.0; });
  EXPECT_EQ(buildRanges(source, 8).blocks, (std::vector<int64_t>{1, 2}));
}

TEST(SliceRanges, backgroundOfDoublesIsComparedAsItIsHeld) {
  // 0.1 is not a float: blocks of it are still background.
  FunctionSource source = sparseSource({60, 60, 60}, VoxelType::kF64, 0.1,
                                       {{{0, 0, 0}, {60, 60, 60}}}, [](int64_t, Vec3i p) {
                                         return p == Vec3i{1, 1, 1} ? 5.0 : 0.1;
                                       });
  const SliceRanges ranges = buildRanges(source, 8);
  EXPECT_EQ(ranges.blocks, (std::vector<int64_t>{0}));
}

TEST(SliceRanges, backgroundThatNoVoxelHasIsNoPartOfTheRange) {
  FunctionSource source =
      sparseSource({15, 15, 15}, VoxelType::kF32, -1000, {{{0, 0, 0}, {15, 15, 15}}},
                   [](int64_t, Vec3i p) { return static_cast<double>(p.x); });
  EXPECT_EQ(buildRanges(source, 8).device_range, (ValueRange{0, 14}));
}

TEST(SliceRanges, volumeOfNothingIsBackground) {
  FunctionSource computed =
      sparseSource({500, 500, 500}, VoxelType::kU8, 3, {}, [](int64_t, Vec3i) { return 0.0; });
  CountingSource source(computed);
  const SliceRanges ranges = buildRanges(source, 32);
  EXPECT_TRUE(ranges.blocks.empty());
  EXPECT_EQ(source.counts().calls, 0);
  EXPECT_EQ(ranges.device_range, (ValueRange{3, 3}));
}

// Zeros, but for a few voxels: read at the speed of memory.
class MostlyZeros : public VolumeSource {
 public:
  MostlyZeros(Vec3i dims, std::map<std::array<int64_t, 3>, uint8_t> others)
      : others_(std::move(others)) {
    layout_.dims = dims;
  }
  const VolumeLayout& layout() const override { return layout_; }
  void readRegion(int64_t, const Box3& box, std::span<std::byte> out) override {
    std::memset(out.data(), 0, out.size());
    for (const auto& [at, value] : others_) {
      const Vec3i p{at[0], at[1], at[2]};
      if (!box.contains(p)) continue;
      const Vec3i local = p - box.lo, size = box.size();
      out[static_cast<size_t>((local.z * size.y + local.y) * size.x + local.x)] =
          static_cast<std::byte>(value);
    }
  }
  std::string identity() const override { return "mostly zeros"; }
  uint64_t storedBytesRead() const override { return 0; }

 private:
  VolumeLayout layout_;
  const std::map<std::array<int64_t, 3>, uint8_t> others_;
};

TEST(SliceRanges, moreThanTwoToThe31VoxelsAreReadAtBothEnds) {
#ifdef __SANITIZE_THREAD__
  GTEST_SKIP()
      << "takes minutes where every access is watched, and shows no race that others do not";
#endif
  const Vec3i dims{2048, 1024, 1026};
  ASSERT_GT(volume(dims), int64_t{1} << 31);
  MostlyZeros source(dims, {{{3, 4, 5}, 11}, {{2046, 1022, 1025}, 22}, {{0, 0, 1024}, 33}});
  const SliceRanges ranges = buildRanges(source, 256);
  const BlockLayout& layout = ranges.layout;
  EXPECT_EQ(ranges.blocks,
            (std::vector<int64_t>{0, layout.idOf({0, 0, 4}), layout.blockCount() - 1}));
  EXPECT_EQ(ranges.totalsAs<uint8_t>()[0].hi, 11);
  EXPECT_EQ(ranges.totalsAs<uint8_t>()[1].hi, 33);
  EXPECT_EQ(ranges.planesAs<uint8_t>(2, 0)[static_cast<size_t>(2046 % 255)].hi, 22);
  EXPECT_EQ(ranges.planesAs<uint8_t>(2, 2)[static_cast<size_t>(1025 % 255)].hi, 22);
}

// --- failures

TEST(SliceRanges, failureOfAReadReachesTheCaller) {
  const auto memory = makeWhiteNoise({40, 40, 40}, VoxelType::kU8, 3);
  for (const int threads : {1, 4})
    for (const int64_t read : {0, 3, 35}) {
      FailingSource source(*memory, FailingSource::Failure::kError, read);
      EXPECT_THROW(buildRanges(source, 8, 0, threads), Error) << "read " << read;
    }
  FailingSource source(*memory, FailingSource::Failure::kException, 2);
  EXPECT_THROW(buildRanges(source, 8), std::runtime_error);
}

TEST(SliceRanges, aStopEndsThePass) {
  const auto source = makeWhiteNoise({40, 40, 40}, VoxelType::kU8, 3);
  WorkerPool pool(1);
  ProgressMeter quiet;
  StopSource stop;
  stop.requestStop();
  EXPECT_THROW(buildSliceRanges(*source, 0, blockLayout(source->layout().dims, 8, 0),
                                {pool, quiet, kMostIndexingBytes, stop.token()}),
               Interrupted);
}

}  // namespace
}  // namespace sluice
