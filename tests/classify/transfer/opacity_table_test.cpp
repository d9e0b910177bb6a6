#include "src/classify/transfer/opacity_table.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

namespace sluice::opacity_table_test {
namespace {

const ValueMap kBytes{DeviceType::kU8, 1, 0};
const ValueMap kFloats{DeviceType::kF32, 1, 0};

TransferFunction coloredTransfer(std::vector<OpacityPoint> opacities) {
  TransferFunction transfer;
  transfer.colors = {{0, {0, 0.25, 1}}, {255, {1, 0.5, 0}}};
  transfer.opacities = std::move(opacities);
  return transfer;
}

double deviceOf(const OpacityTable& table, int entry) {
  const ValueRange range = table.deviceRange();
  return range.lo + (range.hi - range.lo) * entry / std::max(1, table.entries() - 1);
}

// A few bands with soft or hard sides, anywhere.
TransferFunction randomBands(std::mt19937_64& random, double lo, double hi) {
  const auto at = [&] { return lo + (hi - lo) * (static_cast<double>(random() >> 11) * 0x1p-53); };
  std::vector<double> values;
  for (int i = 0; i < 8; ++i) values.push_back(at());
  std::sort(values.begin(), values.end());
  std::vector<OpacityPoint> points;
  for (size_t band = 0; band < 2; ++band) {
    const double* v = values.data() + 4 * band;
    const bool hard = random() % 2 == 0;
    points.push_back({v[0], 0});
    points.push_back({hard ? v[0] : v[1], 0.5});
    points.push_back({hard ? v[3] : v[2], 0.25});
    points.push_back({v[3], 0});
  }
  return coloredTransfer(points);
}

TEST(OpacityTable, integersFallOnEntries) {
  const TransferFunction ramp = coloredTransfer({{0, 0}, {60000, 1}});
  for (const int64_t span : {1, 2, 7, 100, 255, 4095, 5000, 16383})
    for (const int64_t lo : {0, 17}) {
      const ValueMap map{span < 256 ? DeviceType::kU8 : DeviceType::kU16, 1, 0};
      const ValueRange range{static_cast<double>(lo), static_cast<double>(lo + span)};
      const OpacityTable table(ramp, map, range);
      const auto first = static_cast<int64_t>(table.deviceRange().lo);
      const auto covered = static_cast<int64_t>(table.deviceRange().hi) - first;
      ASSERT_EQ((table.entries() - 1) % covered, 0);
      for (int64_t v = lo; v <= lo + span; ++v) {
        const auto device = static_cast<double>(v);
        ASSERT_EQ(table.entryOf(device), (v - first) * ((table.entries() - 1) / covered));
        ASSERT_NEAR(deviceOf(table, table.entryOf(device)), device, 1e-9);
      }
    }
}

TEST(OpacityTable, bytesOfAStepHaveTheEntriesOfTheirColors) {
  TransferFunction step = coloredTransfer({{20, 0}, {20, 0.5}});
  step.colors = {{0, {0, 0, 0}}, {250, {1, 1, 1}}};
  const ValueMap bytes{DeviceType::kU8, 1, 0};
  const OpacityTable one(step, bytes, {0, 60}), all(step, bytes, {0, 250});
  ASSERT_EQ(one.entries(), all.entries());
  for (double v = 0; v < 250; v += 0.37) EXPECT_EQ(one.entryOf(v), all.entryOf(v)) << v;
  EXPECT_EQ(one.volumeRange().hi, 60);
}

TEST(OpacityTable, wideRangesGetAllEntries) {
  const TransferFunction ramp = coloredTransfer({{0, 0}, {60000, 1}});
  const ValueMap map{DeviceType::kU16, 1, 0};
  EXPECT_EQ(OpacityTable(ramp, map, {0, 65535}).entries(), 16384);
  EXPECT_EQ(OpacityTable(ramp, map, {0, 65535}, 1000).entries(), 1000);
  EXPECT_EQ(OpacityTable(ramp, kFloats, {0, 3}, 1000).entries(), 1000);
}

TEST(OpacityTable, entriesHoldTheTransferFunction) {
  const TransferFunction transfer = coloredTransfer({{10, 0}, {100, 0.5}, {200, 0.25}});
  const ValueMap map{DeviceType::kU8, 2, -20};  // value = 2 device - 20
  const OpacityTable table(transfer, map, {5, 120});
  for (int entry = 0; entry < table.entries(); ++entry) {
    const double value = 2 * deviceOf(table, entry) - 20;
    ASSERT_NEAR(table.opacity()[static_cast<size_t>(entry)], opacityAt(transfer, value), 1e-6);
    for (int c = 0; c < 3; ++c)
      ASSERT_NEAR(table.rgba()[static_cast<size_t>(4 * entry + c)], colorAt(transfer, value)[c],
                  1e-6);
  }
}

TEST(OpacityTable, aSampleTakesTheNearestEntry) {
  const OpacityTable table(coloredTransfer({{0, 0}, {1, 1}}), kFloats, {-3, 5}, 257);
  std::mt19937_64 random(1);
  for (int trial = 0; trial < 10000; ++trial) {
    const double device = -4 + 10 * (static_cast<double>(random() >> 11) * 0x1p-53);
    const int entry = table.entryOf(device);
    ASSERT_GE(entry, 0);
    ASSERT_LT(entry, 257);
    const double clamped = std::clamp(device, -3.0, 5.0);
    ASSERT_LE(std::abs(deviceOf(table, entry) - clamped), 8.0 / 256 / 2 + 1e-12) << device;
  }
  EXPECT_EQ(table.entryOf(std::numeric_limits<double>::quiet_NaN()), 0);
  EXPECT_EQ(table.entryOf(kNotANumber), 0);
  EXPECT_EQ(table.entryOf(kLargest), 256);
}

TEST(OpacityTable, aRangeOfOneValueIsOneAnswer) {
  const TransferFunction step = coloredTransfer({{7, 0}, {7, 0.5}});
  for (const ValueMap& map : {kBytes, kFloats}) {
    EXPECT_TRUE(OpacityTable(step, map, {7, 7}).shown().anyIn(7, 7));
    EXPECT_FALSE(OpacityTable(step, map, {6, 6}).shown().anyIn(6, 6));
    EXPECT_FALSE(OpacityTable(step, map, {6, 6}).shown().anyIn(0, 255));
  }
}

TEST(OpacityTable, prefixSumsAnswerAsALoopDoes) {
  std::mt19937_64 random(2);
  for (int trial = 0; trial < 40; ++trial) {
    const OpacityTable table(randomBands(random, 0, 255), kBytes, {0, 255}, 300);
    for (int lo = 0; lo < table.entries(); lo += 3)
      for (int hi = lo; hi < table.entries(); hi += 5) {
        bool any = false;  // a neighbour on each side included, for rounding
        for (int e = std::max(0, lo - 1); e <= std::min(table.entries() - 1, hi + 1); ++e)
          any = any || table.opacity()[static_cast<size_t>(e)] > 0;
        ASSERT_EQ(table.shown().anyEntryIn(lo, hi), any) << lo << " to " << hi;
      }
  }
}

TEST(OpacityTable, aVisibleValueIsNeverCalledInvisible) {
  // Against the transfer function itself, between the entries too.
  std::mt19937_64 random(3);
  const auto unit = [&] { return static_cast<double>(random() >> 11) * 0x1p-53; };
  for (int trial = 0; trial < 50; ++trial) {
    const TransferFunction transfer = randomBands(random, -100, 100);
    const OpacityTable table(transfer, kFloats, {-100, 100});
    for (int sample = 0; sample < 2000; ++sample) {
      const double value = -100 + 200 * unit();
      // The table has nothing that falls between two entries: a band must be wider than that.
      const double width = 200.0 / table.entries();
      const bool visible = opacityAt(transfer, value - width) > 0 &&
                           opacityAt(transfer, value) > 0 && opacityAt(transfer, value + width) > 0;
      if (visible) {
        ASSERT_TRUE(table.shown().anyIn(value, value)) << value;
        ASSERT_TRUE(table.shown().anyIn(value - unit(), value + unit())) << value;
      }
    }
  }
}

TEST(OpacityTable, anIntervalOfZerosIsInvisible) {
  const OpacityTable table(coloredTransfer({{99, 0}, {100, 0.5}, {101, 0}}), kBytes, {0, 255});
  EXPECT_FALSE(table.shown().anyIn(0, 98.9));
  EXPECT_FALSE(table.shown().anyIn(101.1, 255));
  EXPECT_TRUE(table.shown().anyIn(100, 100));
  EXPECT_TRUE(table.shown().anyIn(0, 255));
}

TEST(OpacityTable, singlePrecisionMayMoveAValueToTheNextEntry) {
  const OpacityTable table(coloredTransfer({{39.5, 0}, {39.5, 0.5}}), kFloats, {0, 255});
  const double width = 255.0 / (table.entries() - 1);
  // Values next to the first visible entry on the invisible side.
  int first = 0;
  while (!(table.opacity()[static_cast<size_t>(first)] > 0)) ++first;
  EXPECT_TRUE(table.shown().anyIn(deviceOf(table, first - 1), deviceOf(table, first - 1)));
  EXPECT_FALSE(
      table.shown().anyIn(deviceOf(table, first - 1) - width, deviceOf(table, first - 1) - width));
}

TEST(OpacityTable, aStepIsARampOverAFewEntriesBelowIt) {
  const OpacityTable table(coloredTransfer({{40, 0}, {40, 0.6}}), kBytes, {0, 255});
  const double entries_per_value = (table.entries() - 1) / 255.0;
  const auto opacity = [&](double value) {
    return table.opacity()[static_cast<size_t>(std::lround(value * entries_per_value))];
  };
  EXPECT_EQ(opacity(39.9), 0);
  // Integers at the step, labels say, are wholly above it.
  EXPECT_FLOAT_EQ(opacity(40), 0.6F);
  // The way up has no step down, and no jump of more than a few parts of the step.
  for (int e = 1; e < table.entries(); ++e) {
    const float rise =
        table.opacity()[static_cast<size_t>(e)] - table.opacity()[static_cast<size_t>(e) - 1];
    ASSERT_GE(rise, 0);
    ASSERT_LE(rise, 0.13F);
  }
}

TEST(OpacityTable, aSmallStepIsSpreadUntilNoSampleNeedsToInterpolate) {
  // The step of `--threshold`: a fifth of the opacity at the top.
  const OpacityTable table(coloredTransfer({{40, 0}, {40, 0.01}, {255, 0.05}}), kBytes, {0, 255});
  EXPECT_FALSE(table.mustInterpolate());
  EXPECT_LE(table.stepEntries(), 8);
  EXPECT_EQ(table.opacity()[static_cast<size_t>(table.entryOf(39.8))], 0);
  EXPECT_FLOAT_EQ(table.opacity()[static_cast<size_t>(table.entryOf(40))], 0.01F);
}

TEST(OpacityTable, aStepDownIsARampOverAFewEntriesBelowItToo) {
  const OpacityTable table(coloredTransfer({{40, 0.6}, {40, 0}}), kBytes, {0, 255});
  EXPECT_FLOAT_EQ(table.opacity()[static_cast<size_t>(table.entryOf(39.9))], 0.6F);
  EXPECT_EQ(table.opacity()[static_cast<size_t>(table.entryOf(40))], 0);
}

TEST(OpacityTable, whatIsVisibleStaysSoWhereStepsAreSpread) {
  // A band of one entry: two steps, closer together than they are spread.
  const OpacityTable table(coloredTransfer({{50, 0}, {50, 0.5}, {51, 0.5}, {51, 0}}), kFloats,
                           {0, 16383});
  ASSERT_EQ(table.entries(), 16384);
  EXPECT_GT(table.opacity()[50], 0);
  EXPECT_TRUE(table.shown().anyIn(50, 50));
  EXPECT_FALSE(table.shown().anyIn(0, 50 - table.stepEntries() - 2));
  EXPECT_FALSE(table.shown().anyIn(53, 16383));
}

TEST(OpacityTable, floatsThatHoldIntegersFallOnEntriesToo) {
  const OpacityTable table(coloredTransfer({{40, 0}, {40, 0.6}}), kFloats, {0, 255});
  EXPECT_EQ((table.entries() - 1) % 255, 0);
  EXPECT_FLOAT_EQ(table.opacity()[static_cast<size_t>(table.entryOf(40))], 0.6F);
}

// Simulations write a value far off the data where they know nothing.
TEST(OpacityTable, aValueFarOffLeavesTheEntriesToWhereTheTransferFunctionChanges) {
  TransferFunction transfer = coloredTransfer({{0.2, 0}, {0.8, 0.5}});
  transfer.colors = {{0, {0, 0, 1}}, {1, {1, 0, 0}}};
  for (const ValueRange range : {ValueRange{0, 1e20}, {-9999, 1}, {-1e20, 1e25}}) {
    const OpacityTable table(transfer, kFloats, range);
    EXPECT_EQ(table.volumeRange(), range);
    for (const double value : {0.0, 0.1, 0.3, 0.55, 0.9, 1.0}) {
      const auto entry = static_cast<size_t>(table.entryOf(value));
      EXPECT_NEAR(table.opacity()[entry], opacityAt(transfer, value), 1e-4);
      EXPECT_NEAR(table.rgba()[4 * entry], colorAt(transfer, value).x, 1e-4);
    }
    EXPECT_FLOAT_EQ(table.opacity()[static_cast<size_t>(table.entryOf(range.hi))],
                    static_cast<float>(opacityAt(transfer, range.hi)));
    EXPECT_EQ(table.shown().anyIn(range.lo, range.lo), false);
  }
  // Integers still fall on entries.
  const ValueMap words{DeviceType::kU16, 1, 0};
  transfer.opacities = {{1000.5, 0}, {1100.25, 0.5}};
  transfer.colors = {{1000.5, {1, 1, 1}}};
  const OpacityTable table(transfer, words, {0, 65535});
  const ValueRange part = table.deviceRange();
  EXPECT_EQ(part.lo, std::floor(part.lo));
  EXPECT_LT(part.lo, 1000);
  EXPECT_GT(part.hi, 1101);
  EXPECT_LT(part.hi - part.lo, 1000);
  EXPECT_EQ((table.entries() - 1) % static_cast<int>(part.hi - part.lo), 0);
  // A lone step far off zero.
  transfer.opacities = {{2000, 0}, {2000, 0.5}};
  transfer.colors = {{2000, {1, 1, 1}}};
  const OpacityTable step(transfer, words, {0, 65535});
  EXPECT_FALSE(step.shown().anyIn(0, 1999));
  EXPECT_TRUE(step.shown().anyIn(2000, 2000));
}

TEST(OpacityTable, aSampleInterpolatesWhereNeighborsDifferVisibly) {
  EXPECT_TRUE(
      OpacityTable(coloredTransfer({{40, 0}, {40, 0.6}}), kBytes, {0, 255}).mustInterpolate());
  TransferFunction gentle = coloredTransfer({{0, 0}, {255, 0.05}});
  EXPECT_FALSE(OpacityTable(gentle, kBytes, {0, 255}).mustInterpolate());
  // A step of the color shows only where it is opaque.
  gentle.colors = {{100, {0, 0, 0}}, {100, {1, 1, 1}}};
  EXPECT_TRUE(OpacityTable(gentle, kBytes, {0, 255}).mustInterpolate());
  gentle.opacities = {{120, 0}, {255, 0.05}};
  EXPECT_FALSE(OpacityTable(gentle, kBytes, {0, 255}).mustInterpolate());
}

}  // namespace
}  // namespace sluice::opacity_table_test
