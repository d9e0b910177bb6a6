// The contents of slice ranges: the ranges of planes and blocks, the background, and the histogram.
#include "src/volume/ranges/slice_ranges.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>

#include "tests/support/random_volume.h"
#include "tests/volume/slice_ranges_check.h"

namespace sluice {
namespace {

constexpr std::array kTypes = {VoxelType::kU8,  VoxelType::kI8,  VoxelType::kU16, VoxelType::kI16,
                               VoxelType::kU32, VoxelType::kI32, VoxelType::kF32, VoxelType::kF64};

TEST(SliceRanges, agreeWithALookAtEachVoxel) {
  uint64_t seed = 1;
  for (const VoxelType type : kTypes)
    for (const int ghost : {0, 1})
      for (const Vec3i dims : {Vec3i{2, 2, 2}, Vec3i{8, 9, 10}, Vec3i{23, 15, 20}}) {
        const auto source = makeWhiteNoise(dims, type, seed++);
        const SliceRanges ranges = buildRanges(*source, 8, ghost);
        expectRangesOf(ranges, [&](Vec3i p) { return voxelAt(*source, 0, p); });
        if (HasFatalFailure()) FAIL() << name(type) << " ghost " << ghost;
        const VoxelRange all =
            rangeOf(boxOf(dims), [&](Vec3i p) { return voxelAt(*source, 0, p); });
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
    const SliceRanges ranges = buildRanges(*source, 8);
    expectRangesOf(ranges, [&](Vec3i p) { return voxelAt(*source, 0, p); });
    if (HasFatalFailure()) FAIL() << name(type);
    EXPECT_EQ(ranges.background, deviceValue(type, 0));
    int64_t full = 0;  // by brute force
    for (int64_t block = 0; block < ranges.layout.blockCount(); ++block) {
      const Box3 cells = ranges.layout.ownedCells(ranges.layout.indexOf(block));
      const VoxelRange range = rangeOf({cells.lo, cells.hi + Vec3i{1, 1, 1}},
                                       [&](Vec3i p) { return voxelAt(*source, 0, p); });
      full += range.lo != ranges.background || range.hi != ranges.background ? 1 : 0;
    }
    EXPECT_EQ(static_cast<int64_t>(ranges.blocks.size()), full);
    EXPECT_LT(full, ranges.layout.blockCount() / 2);
  }
}

TEST(SliceRanges, doNotDependOnTheNumberOfThreads) {
  const auto source = makeWhiteNoise({40, 41, 42}, VoxelType::kU16, 5);
  const SliceRanges one = buildRanges(*source, 8, 0, 1), many = buildRanges(*source, 8, 0, 7);
  EXPECT_EQ(one.blocks, many.blocks);
  EXPECT_EQ(one.totals, many.totals);
  EXPECT_EQ(one.planes, many.planes);
  EXPECT_EQ(one.counts, many.counts);
  EXPECT_EQ(one.device_range, many.device_range);
}

TEST(SliceRanges, backgroundIsTheMostCommonUniformValue) {
  // Blocks of 7 cells along x; shared planes stay out of the blocks that change.
  const auto source = makeMemorySource<uint8_t>(Vec3i{7 * 6 + 1, 8, 8}, [](auto x, auto, auto) {
    return x <= 7 ? 9 : x <= 14 ? 5 : x <= 35 ? 5 : 9;
  });
  const SliceRanges ranges = buildRanges(*source, 8);
  EXPECT_EQ(ranges.background, 5);
  EXPECT_EQ(ranges.blocks, (std::vector<int64_t>{0, 1, 5}));
  EXPECT_EQ(ranges.device_range, (ValueRange{5, 9}));
}

TEST(SliceRanges, uniformVolumeHoldsNoBlock) {
  const auto source = makeMemorySource<int16_t>(Vec3i{20, 20, 20}, [](auto...) { return -1000; });
  const SliceRanges ranges = buildRanges(*source, 8);
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
    expectRangesOf(buildRanges(*source, 8, 0, 2, time),
                   [&](Vec3i p) { return voxelAt(*source, time, p); });
}

// --- NaN and infinities

TEST(SliceRanges, notANumberIsNoPartOfTheValueRange) {
  const auto nan = std::numeric_limits<double>::quiet_NaN();
  // No plane of any axis is free of NaN, so that no array shows the least number.
  const auto source = makeMemorySource<float>(Vec3i{16, 16, 16}, [&](auto x, auto y, auto z) {
    return (x + y + z) % 2 == 0 ? nan : static_cast<double>(x) - 3;
  });
  const SliceRanges ranges = buildRanges(*source, 8);
  EXPECT_EQ(ranges.device_range, (ValueRange{-3, 12}));
  EXPECT_EQ(ranges.totalsAs<float>()[0].lo, kNotANumber);
}

TEST(SliceRanges, infinitiesAreNoPartOfTheValueRange) {
  const double infinity = std::numeric_limits<double>::infinity();
  const auto source = makeMemorySource<double>(Vec3i{16, 16, 16}, [&](auto x, auto y, auto z) {
    return y == 3 ? infinity : z == 4 ? -infinity : static_cast<double>(x);
  });
  const SliceRanges ranges = buildRanges(*source, 8);
  EXPECT_EQ(ranges.device_range, (ValueRange{0, 15}));
  EXPECT_EQ(ranges.totalsAs<float>()[0].hi, kLargest);
  EXPECT_EQ(ranges.totalsAs<float>()[0].lo, -kLargest);
}

TEST(SliceRanges, finiteValuesBeyondTheLargestHaveARangeOfTheirOwn) {
  const double infinity = std::numeric_limits<double>::infinity();
  const auto nan = std::numeric_limits<double>::quiet_NaN();
  const auto source = makeMemorySource<double>(Vec3i{16, 16, 16}, [&](auto x, auto y, auto z) {
    if (x == 2 && y == 3) return z == 4 ? -1e38 : z == 5 ? 3e200 : infinity;
    return x == 9 ? nan : static_cast<double>(x);
  });
  const SliceRanges ranges = buildRanges(*source, 8);
  EXPECT_EQ(ranges.device_range, (ValueRange{0, 15}));
  EXPECT_EQ(ranges.far_range, (ValueRange{-1e38, 3e200}));
  const auto near = makeMemorySource<float>(Vec3i{16, 16, 16}, [&](auto x, auto, auto) {
    return x == 4 ? infinity : x == 5 ? nan : 1e29;
  });
  EXPECT_GT(buildRanges(*near, 8).far_range.lo, buildRanges(*near, 8).far_range.hi);
}

TEST(SliceRanges, volumeWithoutANumberHasTheRangeZero) {
  const auto source = makeMemorySource<float>(
      Vec3i{9, 9, 9}, [](auto...) { return std::numeric_limits<float>::quiet_NaN(); });
  const SliceRanges ranges = buildRanges(*source, 8);
  EXPECT_EQ(ranges.device_range, (ValueRange{0, 0}));
  EXPECT_EQ(total(ranges.counts), 0U);
  EXPECT_EQ(ranges.background, kNotANumber);
}

TEST(SliceRanges, notANumberIsNotCountedBesideASingleValue) {
  const auto source = makeMemorySource<float>(Vec3i{8, 8, 8}, [](auto x, auto, auto) {
    return x < 4 ? 7.0F : std::numeric_limits<float>::quiet_NaN();
  });
  const SliceRanges ranges = buildRanges(*source, 8);
  EXPECT_EQ(ranges.device_range, (ValueRange{7, 7}));
  EXPECT_EQ(total(ranges.counts), 4U * 8U * 8U);
}

// --- how often each value occurs

// Every voxel of `source` at step 0, one at a time, as entries of single values.
ValueCounts countedOneByOne(const MemorySource& source) {
  std::map<double, uint64_t> counts;
  ValueCounts result;
  const Vec3i dims = source.layout().dims;
  for (int64_t z = 0; z < dims.z; ++z)
    for (int64_t y = 0; y < dims.y; ++y)
      for (int64_t x = 0; x < dims.x; ++x) {
        const double value = voxelAt(source, 0, {x, y, z});
        ++counts[value];
        if (x == 0) continue;
        const double jump = std::abs(value - voxelAt(source, 0, {x - 1, y, z}));
        result.changes += jump > 0 ? 1 : 0;
        result.jumps += static_cast<uint64_t>(jump);
      }
  for (const auto& [value, count] : counts) result.entries.push_back({value, value, count});
  return result;
}

TEST(SliceRanges, countEachVoxelOnceWhateverTheBlocks) {
  const auto noise = makeWhiteNoise({30, 23, 17}, VoxelType::kU8, 3);
  const auto few = makeMemorySource<int16_t>(Vec3i{19, 26, 18}, [](auto x, auto y, auto z) {
    return (x / 3 + y + z / 2) % 7 * 500 - 900;
  });
  for (const MemorySource* source : {noise.get(), few.get()}) {
    const ValueCounts expected = countedOneByOne(*source);
    for (const int64_t size : {4, 8, 16, 64})
      for (const int ghost : {0, 1}) {
        if (size - 1 - 2 * ghost < 1) continue;
        MemorySource copy(source->layout(), {source->bytes().begin(), source->bytes().end()});
        const ValueCounts counts = buildRanges(copy, size, ghost).counts;
        EXPECT_EQ(total(counts), static_cast<uint64_t>(volume(source->layout().dims)));
        EXPECT_EQ(counts, expected) << size << " ghost " << ghost;
      }
  }
}

TEST(SliceRanges, countManyIntegersInFewEntries) {
  const auto source = makeWhiteNoise({40, 40, 40}, VoxelType::kU16, 3);
  const ValueCounts counts = buildRanges(*source, 16).counts;
  EXPECT_LE(counts.entries.size(), kMostValueCounts);
  EXPECT_GT(counts.entries.size(), kMostValueCounts / 4);
  EXPECT_EQ(total(counts), 40U * 40U * 40U);
  for (size_t i = 1; i < counts.entries.size(); ++i)
    ASSERT_GT(counts.entries[i].lo, counts.entries[i - 1].hi);
}

TEST(SliceRanges, countFloatsWithinTheirKeys) {
  const auto source = makeWhiteNoise({64, 64, 64}, VoxelType::kF32, 9);
  const Histogram histogram = histogramOf(buildRanges(*source, 32).counts, 4096);
  const uint64_t all = total(histogram);
  EXPECT_EQ(all, 64U * 64U * 64U);
  // Uniform noise: each quarter of the range holds about a quarter of the values.
  for (size_t quarter = 0; quarter < 4; ++quarter) {
    const auto first = histogram.counts.begin() + static_cast<ptrdiff_t>(quarter * 1024);
    const auto count = std::accumulate(first, first + 1024, uint64_t{0});
    EXPECT_NEAR(static_cast<double>(count) / static_cast<double>(all), 0.25, 0.01);
  }
}

TEST(SliceRanges, fewFloatsAreTheValuesThemselves) {
  const auto source = makeMemorySource<float>(Vec3i{20, 20, 20}, [](auto x, auto y, auto) {
    return x < 5 ? -9999.25F : y < 10 ? 0.0F : 1000003.0F;
  });
  const ValueCounts counts = buildRanges(*source, 8).counts;
  EXPECT_EQ(counts.entries,
            (std::vector<ValueCount>{
                {-9999.25, -9999.25, 2000}, {0, 0, 3000}, {1000003, 1000003, 3000}}));
}

}  // namespace
}  // namespace sluice
