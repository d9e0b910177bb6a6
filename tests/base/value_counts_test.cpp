#include "src/base/values/value_counts.h"

#include <gtest/gtest.h>

#include <limits>

namespace sluice {
namespace {

using Entries = std::vector<ValueCount>;

TEST(ValueCounts, binsHoldEveryVoxelOnce) {
  const ValueCounts counts{{{0, 0, 7}, {1, 4, 9}, {4, 4, 1}, {6, 8, 1001}}};
  for (const size_t bins : {1, 2, 3, 7, 8, 100, 4096}) {
    const Histogram histogram = histogramOf(counts, bins);
    EXPECT_EQ(histogram.range, (ValueRange{0, 8}));
    EXPECT_EQ(total(histogram), total(counts)) << bins;
  }
  EXPECT_EQ(histogramOf(counts, 8).counts, (std::vector<uint64_t>{7, 3, 3, 3, 1, 0, 500, 501}));
}

TEST(ValueCounts, integersHaveABinEach) {
  ValueCounts counts;
  for (int value = 0; value < 256; ++value)
    counts.entries.push_back({double(value), double(value), static_cast<uint64_t>(value) + 1});
  const Histogram histogram = histogramOf(counts, 256);
  for (size_t value = 0; value < 256; ++value) EXPECT_EQ(histogram.counts[value], value + 1);
}

TEST(ValueCounts, ofTwoStepsAddUp) {
  const ValueCounts a{{{0, 0, 5}, {2, 3, 7}}, 4, 40}, b{{{0, 0, 1}, {2, 2, 2}}, 1, 9};
  const ValueCounts both = merged(a, b);
  EXPECT_EQ(both.entries, (Entries{{0, 0, 6}, {2, 2, 2}, {2, 3, 7}}));
  EXPECT_EQ(both.changes, 5U);
  EXPECT_EQ(both.jumps, 49U);
  EXPECT_EQ(both, merged(b, a));
}

TEST(ValueCounts, ofALongSeriesStayFew) {
  ValueCounts all;
  for (int step = 0; step < 20; ++step) {
    ValueCounts counts;
    for (int i = 0; i < 2000; ++i) {
      const double value = i + step / 20.0;
      counts.entries.push_back({value, value, 1});
    }
    all = merged(all, counts);
  }
  EXPECT_LE(all.entries.size(), 4 * kMostValueCounts);
  EXPECT_EQ(total(all), 40000U);
  EXPECT_EQ(rangeOf(all), (ValueRange{0, 1999.95}));
}

TEST(ValueCounts, insideCutsIntervals) {
  const ValueCounts counts{{{0, 0, 5}, {2, 6, 100}, {9, 9, 3}}};
  EXPECT_EQ(inside(counts, {1, 5}).entries, (Entries{{2, 5, 75}}));
  EXPECT_EQ(inside(counts, {0, 9}), counts);
  EXPECT_TRUE(inside(counts, {7, 8}).entries.empty());
}

TEST(ValueCounts, scaleAndOffsetMayTurnThemRound) {
  const ValueCounts counts{{{0, 1, 5}, {4, 4, 2}}, 3, 10};
  const ValueCounts turned = scaled(counts, -2, 10);
  EXPECT_EQ(turned.entries, (Entries{{2, 2, 2}, {8, 10, 5}}));
  EXPECT_EQ(turned.jumps, 20U);
}

TEST(ValueCounts, extremesDoNotOverflow) {
  const double most = std::numeric_limits<double>::max();
  const ValueCounts counts{{{-most, -most, 2}, {-most, most, 100}, {most, most, 3}}};
  EXPECT_EQ(total(histogramOf(counts, 64)), 105U);
  EXPECT_EQ(total(inside(counts, {0, most})), 53U);
}

}  // namespace
}  // namespace sluice
