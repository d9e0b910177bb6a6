#include "src/volume/slice_ranges.h"

#include <gtest/gtest.h>

#include <cmath>
#include <csignal>
#include <cstring>
#include <limits>
#include <map>
#include <numeric>
#include <random>

#include "src/base/error.h"
#include "src/base/interrupt.h"
#include "tests/support/counting_source.h"
#include "tests/support/failing_source.h"
#include "tests/support/function_source.h"
#include "tests/support/random_volume.h"

namespace sluice {
namespace {

constexpr std::array kTypes = {VoxelType::kU8,  VoxelType::kI8,  VoxelType::kU16, VoxelType::kI16,
                               VoxelType::kU32, VoxelType::kI32, VoxelType::kF32, VoxelType::kF64};

SliceRanges build(VolumeSource& source, int64_t size, int ghost = 0, int threads = 2,
                  int64_t time = 0) {
  WorkerPool pool(threads);
  Progress quiet;
  return buildSliceRanges(source, time, blockLayout(source.layout().dims, size, ghost), pool,
                          quiet);
}

// A stored value as levels 2 to 4 hold it, written down from device_voxel.h.
double device(VoxelType type, double stored) {
  switch (type) {
    case VoxelType::kU8:
    case VoxelType::kU16:
      return stored;
    case VoxelType::kI8:
      return stored + 128;
    case VoxelType::kI16:
      return stored + 32768;
    default:
      return static_cast<double>(static_cast<float>(stored));
  }
}

// The device voxel of a volume in memory.
double voxelAt(const MemorySource& source, int64_t time, Vec3i p) {
  const VolumeLayout& layout = source.layout();
  return visitVoxelType(layout.type, [&](auto tag) {
    const int64_t at = ((time * layout.dims.z + p.z) * layout.dims.y + p.y) * layout.dims.x + p.x;
    std::memcpy(&tag, source.bytes().data() + at * static_cast<int64_t>(sizeof tag), sizeof tag);
    return device(layout.type, static_cast<double>(tag));
  });
}

struct Range {
  double lo = std::numeric_limits<double>::infinity(), hi = -lo;
  void take(double v) {
    lo = std::min(lo, v);
    hi = std::max(hi, v);
  }
  bool empty() const { return lo > hi; }
};

// The voxels of a box, one at a time.
template <class F>
Range rangeOf(const Box3& box, F&& voxel) {
  Range range;
  for (int64_t z = box.lo.z; z < box.hi.z; ++z)
    for (int64_t y = box.lo.y; y < box.hi.y; ++y)
      for (int64_t x = box.lo.x; x < box.hi.x; ++x) range.take(voxel(Vec3i{x, y, z}));
  return range;
}

// Every array of every block against a look at each voxel; blocks that are not held must be nothing
// but background.
template <class F>
void expectRangesOf(const SliceRanges& ranges, F&& voxel) {
  const BlockLayout& layout = ranges.layout;
  size_t held = 0;
  for (int64_t block = 0; block < layout.blockCount(); ++block) {
    const Box3 cells = layout.ownedCells(layout.indexOf(block));
    const Box3 own{cells.lo, cells.hi + Vec3i{1, 1, 1}};
    const Range all = rangeOf(own, voxel);
    if (held == ranges.blocks.size() || ranges.blocks[held] != block) {
      ASSERT_EQ(all.lo, ranges.background) << "block " << block;
      ASSERT_EQ(all.hi, ranges.background) << "block " << block;
      continue;
    }
    visitDeviceType(ranges.map.type, [&](auto tag) {
      using T = decltype(tag);
      const PlaneRange<T> total = ranges.totalsAs<T>()[held];
      ASSERT_EQ(static_cast<double>(total.lo), all.lo) << "block " << block;
      ASSERT_EQ(static_cast<double>(total.hi), all.hi) << "block " << block;
      for (int axis = 0; axis < 3; ++axis) {
        const auto planes = ranges.planesAs<T>(held, axis);
        ASSERT_EQ(static_cast<int64_t>(planes.size()), layout.planes());
        for (int64_t plane = 0; plane < layout.planes(); ++plane) {
          Box3 slice = own;
          slice.lo[axis] = own.lo[axis] + plane;
          slice.hi[axis] = slice.lo[axis] + 1;
          const PlaneRange<T> found = planes[static_cast<size_t>(plane)];
          if (slice.lo[axis] >= own.hi[axis]) {
            ASSERT_GT(found.lo, found.hi) << "padding";
            continue;
          }
          const Range expected = rangeOf(slice, voxel);
          ASSERT_EQ(static_cast<double>(found.lo), expected.lo)
              << "block " << block << " axis " << axis << " plane " << plane;
          ASSERT_EQ(static_cast<double>(found.hi), expected.hi)
              << "block " << block << " axis " << axis << " plane " << plane;
        }
      }
    });
    ++held;
  }
  EXPECT_EQ(held, ranges.blocks.size());
}

TEST(SliceRanges, agreeWithALookAtEachVoxel) {
  uint64_t seed = 1;
  for (const VoxelType type : kTypes)
    for (const int ghost : {0, 1})
      for (const Vec3i dims : {Vec3i{2, 2, 2}, Vec3i{8, 9, 10}, Vec3i{23, 15, 20}}) {
        const auto source = makeWhiteNoise(dims, type, seed++);
        const SliceRanges ranges = build(*source, 8, ghost);
        expectRangesOf(ranges, [&](Vec3i p) { return voxelAt(*source, 0, p); });
        if (HasFatalFailure()) FAIL() << name(type) << " ghost " << ghost;
        const Range all = rangeOf(boxOf(dims), [&](Vec3i p) { return voxelAt(*source, 0, p); });
        EXPECT_EQ(ranges.device_range, (ValueRange{all.lo, all.hi})) << name(type);
      }
}

TEST(SliceRanges, dropBlocksOfNothingButBackground) {
  for (const VoxelType type : kTypes) {
    BlobOptions options;
    options.type = type;
    options.blobs = 2;
    options.dims = {60, 50, 40};
    const auto source = makeSparseBlobs(options);
    const SliceRanges ranges = build(*source, 8);
    expectRangesOf(ranges, [&](Vec3i p) { return voxelAt(*source, 0, p); });
    if (HasFatalFailure()) FAIL() << name(type);
    EXPECT_EQ(ranges.background, device(type, 0));
    int64_t full = 0;  // by brute force
    for (int64_t block = 0; block < ranges.layout.blockCount(); ++block) {
      const Box3 cells = ranges.layout.ownedCells(ranges.layout.indexOf(block));
      const Range range = rangeOf({cells.lo, cells.hi + Vec3i{1, 1, 1}},
                                  [&](Vec3i p) { return voxelAt(*source, 0, p); });
      full += range.lo != ranges.background || range.hi != ranges.background ? 1 : 0;
    }
    EXPECT_EQ(static_cast<int64_t>(ranges.blocks.size()), full);
    EXPECT_LT(full, ranges.layout.blockCount() / 2);
  }
}

TEST(SliceRanges, doNotDependOnTheNumberOfThreads) {
  const auto source = makeWhiteNoise({40, 41, 42}, VoxelType::kU16, 5);
  const SliceRanges one = build(*source, 8, 0, 1), many = build(*source, 8, 0, 7);
  EXPECT_EQ(one.blocks, many.blocks);
  EXPECT_EQ(one.totals, many.totals);
  EXPECT_EQ(one.planes, many.planes);
  EXPECT_EQ(one.histogram.counts, many.histogram.counts);
  EXPECT_EQ(one.device_range, many.device_range);
}

TEST(SliceRanges, backgroundIsTheMostCommonUniformValue) {
  // Blocks of 7 cells along x; shared planes stay out of the blocks that change.
  const auto source = makeMemorySource<uint8_t>(Vec3i{7 * 6 + 1, 8, 8}, [](auto x, auto, auto) {
    return x <= 7 ? 9 : x <= 14 ? 5 : x <= 35 ? 5 : 9;
  });
  const SliceRanges ranges = build(*source, 8);
  EXPECT_EQ(ranges.background, 5);
  EXPECT_EQ(ranges.blocks, (std::vector<int64_t>{0, 1, 5}));
  EXPECT_EQ(ranges.device_range, (ValueRange{5, 9}));
}

TEST(SliceRanges, uniformVolumeHoldsNoBlock) {
  const auto source = makeMemorySource<int16_t>(Vec3i{20, 20, 20}, [](auto...) { return -1000; });
  const SliceRanges ranges = build(*source, 8);
  EXPECT_TRUE(ranges.blocks.empty());
  EXPECT_EQ(ranges.map.valueOf(ranges.background), -1000);
  EXPECT_EQ(ranges.device_range, (ValueRange{31768, 31768}));
}

TEST(SliceRanges, areThoseOfTheirTimeStep) {
  VolumeLayout layout;
  layout.dims = {12, 12, 12};
  layout.time_steps = 3;
  const auto source = makeMemorySource<uint8_t>(
      layout, [](auto x, auto y, auto z, auto t) { return (x + y + z) * (t + 1); });
  for (int64_t time = 0; time < 3; ++time)
    expectRangesOf(build(*source, 8, 0, 2, time),
                   [&](Vec3i p) { return voxelAt(*source, time, p); });
}

// --- NaN and infinities

TEST(SliceRanges, notANumberIsNoPartOfTheValueRange) {
  const auto nan = std::numeric_limits<double>::quiet_NaN();
  // No plane of any axis is free of NaN, so that no array shows the least number.
  const auto source = makeMemorySource<float>(Vec3i{16, 16, 16}, [&](auto x, auto y, auto z) {
    return (x + y + z) % 2 == 0 ? nan : static_cast<double>(x) - 3;
  });
  const SliceRanges ranges = build(*source, 8);
  EXPECT_EQ(ranges.device_range, (ValueRange{-3, 12}));
  EXPECT_EQ(ranges.totalsAs<float>()[0].lo, kNotANumber);
}

TEST(SliceRanges, infinitiesAreNoPartOfTheValueRange) {
  const double infinity = std::numeric_limits<double>::infinity();
  const auto source = makeMemorySource<double>(Vec3i{16, 16, 16}, [&](auto x, auto y, auto z) {
    return y == 3 ? infinity : z == 4 ? -infinity : static_cast<double>(x);
  });
  const SliceRanges ranges = build(*source, 8);
  EXPECT_EQ(ranges.device_range, (ValueRange{0, 15}));
  EXPECT_EQ(ranges.totalsAs<float>()[0].hi, kLargest);
  EXPECT_EQ(ranges.totalsAs<float>()[0].lo, -kLargest);
}

TEST(SliceRanges, volumeWithoutANumberHasTheRangeZero) {
  const auto source = makeMemorySource<float>(
      Vec3i{9, 9, 9}, [](auto...) { return std::numeric_limits<float>::quiet_NaN(); });
  const SliceRanges ranges = build(*source, 8);
  EXPECT_EQ(ranges.device_range, (ValueRange{0, 0}));
  EXPECT_EQ(total(ranges.histogram), 0U);
  EXPECT_EQ(ranges.background, kNotANumber);
}

TEST(SliceRanges, notANumberIsNotCountedBesideASingleValue) {
  const auto source = makeMemorySource<float>(Vec3i{8, 8, 8}, [](auto x, auto, auto) {
    return x < 4 ? 7.0F : std::numeric_limits<float>::quiet_NaN();
  });
  const SliceRanges ranges = build(*source, 8);
  EXPECT_EQ(ranges.device_range, (ValueRange{7, 7}));
  EXPECT_EQ(total(ranges.histogram), 4U * 4U * 4U);
}

// --- the histogram

TEST(SliceRanges, histogramCountsEveryOtherRowOfEveryOtherPlane) {
  const auto source = makeWhiteNoise({30, 23, 17}, VoxelType::kU8, 3);
  const SliceRanges ranges = build(*source, 8);
  std::vector<uint64_t> expected(256, 0);
  for (int64_t bz = 0; bz < ranges.layout.grid.z; ++bz)
    for (int64_t by = 0; by < ranges.layout.grid.y; ++by)
      for (int64_t z = bz * 7; z <= std::min<int64_t>(bz * 7 + 7, 16); z += 2)
        for (int64_t y = by * 7; y <= std::min<int64_t>(by * 7 + 7, 22); y += 2)
          for (int64_t x = 0; x < 30; ++x)
            ++expected[static_cast<size_t>(voxelAt(*source, 0, {x, y, z}))];
  ASSERT_EQ(ranges.histogram.range, (ValueRange{0, 255}));
  EXPECT_EQ(ranges.histogram.counts, expected);
}

TEST(SliceRanges, histogramHasABinForEachOfAFewIntegers) {
  const auto source = makeMemorySource<int16_t>(
      Vec3i{16, 16, 16}, [](auto x, auto y, auto) { return (x + y) % 2 == 0 ? -1000 : 3000; });
  const SliceRanges ranges = build(*source, 8);
  ASSERT_EQ(ranges.histogram.counts.size(), 4001U);
  EXPECT_EQ(ranges.histogram.range, (ValueRange{31768, 35768}));
  EXPECT_GT(ranges.histogram.counts.front(), 0U);
  EXPECT_GT(ranges.histogram.counts.back(), 0U);
  EXPECT_EQ(ranges.histogram.counts.front() + ranges.histogram.counts.back(),
            total(ranges.histogram));
}

TEST(SliceRanges, histogramOfFloatsIsRightWithinItsKeys) {
  const auto source = makeWhiteNoise({64, 64, 64}, VoxelType::kF32, 9);
  const SliceRanges ranges = build(*source, 32);
  ASSERT_EQ(ranges.histogram.counts.size(), 4096U);
  const uint64_t all = total(ranges.histogram);
  // Uniform noise: each quarter of the range holds about a quarter of the values.
  for (size_t quarter = 0; quarter < 4; ++quarter) {
    const auto first = ranges.histogram.counts.begin() + static_cast<ptrdiff_t>(quarter * 1024);
    const auto count = std::accumulate(first, first + 1024, uint64_t{0});
    EXPECT_NEAR(static_cast<double>(count) / static_cast<double>(all), 0.25, 0.01);
  }
}

// --- what is read

TEST(SliceRanges, eachRowOfBlocksIsReadOnce) {
  const auto memory = makeWhiteNoise({50, 40, 30}, VoxelType::kU8, 3);
  CountingSource source(*memory);
  const SliceRanges ranges = build(source, 8);
  // Neighbours share a plane: those of y and z are read by both rows.
  const Vec3i grid = ranges.layout.grid;
  EXPECT_EQ(source.counts().calls, grid.y * grid.z);
  EXPECT_EQ(source.counts().bytes, 50 * (40 + grid.y - 1) * (30 + grid.z - 1));
}

TEST(SliceRanges, blocksOf64ReadLittleMoreThanTheVolume) {
  const auto memory = makeMemorySource<uint8_t>(Vec3i{127, 127, 127}, [](auto...) { return 1; });
  CountingSource source(*memory);
  build(source, 64);
  EXPECT_LE(static_cast<double>(source.counts().bytes), 1.04 * 127 * 127 * 127);
}

TEST(SliceRanges, longRowsAreReadInPieces) {
  VolumeLayout layout;
  layout.dims = {63 * 100 + 1, 2, 2};
  FunctionSource computed(layout, [](int64_t, Vec3i p) { return p.x % 251; });
  // 64^3 blocks of a byte stored and a byte converted: 67 in 32 MiB, 16 in a sixteenth of 128 MiB.
  CountingSource source(computed);
  const SliceRanges two_threads = build(source, 64, 0, 2);
  EXPECT_EQ(source.counts().calls, 2);
  source.reset();
  const SliceRanges sixteen_threads = build(source, 64, 0, 16);
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
  const SliceRanges ranges = build(source, 512);
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
      const SliceRanges ranges = build(sparse, 8, ghost), all = build(dense, 8, ghost);
      EXPECT_EQ(ranges.histogram.range, all.histogram.range);
      EXPECT_EQ(ranges.histogram.counts, all.histogram.counts);
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
  const SliceRanges ranges = build(source, 64);
  EXPECT_EQ(ranges.blocks, (std::vector<int64_t>{0, ranges.layout.blockCount() - 1}));
  EXPECT_EQ(ranges.device_range, (ValueRange{0.25, 999}));
  EXPECT_EQ(ranges.totalsAs<float>()[0].hi, 8);
  EXPECT_EQ(ranges.totalsAs<float>()[1].hi, 999);
  EXPECT_LE(source.counts().voxels, 2 * 64 * 64 * 64);
  EXPECT_GT(ranges.histogram.counts.front(), 1'000'000'000'000U) << "background not read counts";
  EXPECT_LE(ranges.bytes(), 2U * (8 + 8 + 3 * 64 * 8));
}

TEST(SliceRanges, aVoxelOnASharedPlaneIsInBothBlocks) {
  FunctionSource source = sparseSource({30, 8, 8}, VoxelType::kU8, 0, {{{14, 0, 0}, {15, 1, 1}}},
                                       [](int64_t, Vec3i) { return 9.0; });
  EXPECT_EQ(build(source, 8).blocks, (std::vector<int64_t>{1, 2}));
}

TEST(SliceRanges, backgroundOfDoublesIsComparedAsItIsHeld) {
  // 0.1 is not a float: blocks of it are still background.
  FunctionSource source = sparseSource({60, 60, 60}, VoxelType::kF64, 0.1,
                                       {{{0, 0, 0}, {60, 60, 60}}}, [](int64_t, Vec3i p) {
                                         return p == Vec3i{1, 1, 1} ? 5.0 : 0.1;
                                       });
  const SliceRanges ranges = build(source, 8);
  EXPECT_EQ(ranges.blocks, (std::vector<int64_t>{0}));
}

TEST(SliceRanges, backgroundThatNoVoxelHasIsNoPartOfTheRange) {
  FunctionSource source =
      sparseSource({15, 15, 15}, VoxelType::kF32, -1000, {{{0, 0, 0}, {15, 15, 15}}},
                   [](int64_t, Vec3i p) { return static_cast<double>(p.x); });
  EXPECT_EQ(build(source, 8).device_range, (ValueRange{0, 14}));
}

TEST(SliceRanges, volumeOfNothingIsBackground) {
  FunctionSource computed =
      sparseSource({500, 500, 500}, VoxelType::kU8, 3, {}, [](int64_t, Vec3i) { return 0.0; });
  CountingSource source(computed);
  const SliceRanges ranges = build(source, 32);
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
  const SliceRanges ranges = build(source, 256);
  const BlockLayout& layout = ranges.layout;
  EXPECT_EQ(ranges.blocks,
            (std::vector<int64_t>{0, layout.idOf({0, 0, 4}), layout.blockCount() - 1}));
  EXPECT_EQ(ranges.totalsAs<uint8_t>()[0].hi, 11);
  EXPECT_EQ(ranges.totalsAs<uint8_t>()[1].hi, 33);
  EXPECT_EQ(ranges.planesAs<uint8_t>(2, 0)[static_cast<size_t>(2046 % 255)].hi, 22);
  EXPECT_EQ(ranges.planesAs<uint8_t>(2, 2)[static_cast<size_t>(1025 % 255)].hi, 22);
}

// --- what goes wrong

TEST(SliceRanges, failureOfAReadReachesTheCaller) {
  const auto memory = makeWhiteNoise({40, 40, 40}, VoxelType::kU8, 3);
  for (const int threads : {1, 4})
    for (const int64_t read : {0, 3, 35}) {
      FailingSource source(*memory, FailingSource::Failure::kError, read);
      EXPECT_THROW(build(source, 8, 0, threads), Error) << "read " << read;
    }
  FailingSource source(*memory, FailingSource::Failure::kException, 2);
  EXPECT_THROW(build(source, 8), std::runtime_error);
}

TEST(SliceRangesDeathTest, interruptionEndsThePass) {
  const auto source = makeWhiteNoise({40, 40, 40}, VoxelType::kU8, 3);
  EXPECT_EXIT(
      {
        watchForInterruption();
        std::raise(SIGINT);
        try {
          build(*source, 8, 0, 1);
        } catch (const Interrupted&) {
          std::_Exit(130);
        }
        std::_Exit(0);
      },
      testing::ExitedWithCode(130), "");
}

}  // namespace
}  // namespace sluice
