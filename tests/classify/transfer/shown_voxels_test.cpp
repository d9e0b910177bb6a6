#include "src/base/values/shown_values.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>

#include "src/classify/transfer/opacity_table.h"

namespace sluice {
namespace {

// `bands` opaque pieces between lo and hi, down to single points.
OpacityTable randomTable(std::mt19937_64& random, int bands, DeviceType type, ValueRange range) {
  std::vector<double> ends;
  for (int i = 0; i < 2 * bands; ++i)
    ends.push_back(std::lerp(range.lo, range.hi, static_cast<double>(random() >> 11) * 0x1p-53));
  std::sort(ends.begin(), ends.end());
  TransferFunction transfer;
  transfer.colors = {{0, {1, 1, 1}}};
  transfer.opacities = {{range.lo, random() % 4 == 0 ? 0.5 : 0.0}};
  for (size_t i = 0; i < ends.size(); i += 2)
    transfer.opacities.insert(transfer.opacities.end(),
                              {{ends[i], 0}, {ends[i], 0.3}, {ends[i + 1], 0.3}, {ends[i + 1], 0}});
  return {transfer, {type, 1, 0}, range};
}

// The windows of microscopes and the ramps over all values begin at the background, often 0.
TEST(ShownValues, aRampFromZeroLeavesZeroOut) {
  TransferFunction ramp;
  ramp.colors = {{0, {1, 1, 1}}};
  ramp.opacities = {{0, 0}, {250, 0.5}};
  for (const ValueRange range : {ValueRange{0, 255}, {0, 60000}}) {
    const auto type = range.hi > 255 ? DeviceType::kU16 : DeviceType::kU8;
    const OpacityTable table(ramp, {type, 1, 0}, range);
    EXPECT_FALSE(table.shown().anyIn(0, 0));
    EXPECT_TRUE(table.shown().anyIn(0, 1));
    EXPECT_TRUE(table.shown().anyIn(1, 1));
    const ShownVoxels<uint16_t> voxels(table.shown());
    EXPECT_FALSE(voxels.any(0, 0));
    EXPECT_TRUE(voxels.any(0, 1));
  }
  const OpacityTable floats(ramp, {DeviceType::kF32, 1, 0}, {0, 1});
  const ShownVoxels<float> voxels(floats.shown());
  EXPECT_FALSE(floats.shown().anyIn(0, 0));
  EXPECT_FALSE(voxels.any(0, 0));
  EXPECT_FALSE(voxels.any(-1, 0));
  EXPECT_TRUE(voxels.any(0, 1e-6F));
}

// Other numbers are not exact: a sample between two equal ones may be a little off, and reach the
// entry beside theirs.
TEST(ShownValues, aValueBesideOneThatShowsMayShow) {
  TransferFunction ramp;
  ramp.colors = {{0, {1, 1, 1}}};
  ramp.opacities = {{100, 0}, {250, 0.5}};
  const OpacityTable table(ramp, {DeviceType::kU8, 1, 0}, {100, 255});
  EXPECT_TRUE(table.shown().anyIn(100, 100));
  ramp.opacities = {{0, 0.5}, {250, 0}};
  EXPECT_TRUE(OpacityTable(ramp, {DeviceType::kU8, 1, 0}, {0, 255}).shown().anyIn(0, 0));
}

TEST(ShownValues, theLabelZeroShowsIfItHasAnOpacity) {
  for (const double opacity : {0.0, 0.5}) {
    TransferFunction labels;
    labels.labels = true;
    labels.colors = {{0, {1, 1, 1}}, {1, {1, 1, 1}}, {2, {1, 1, 1}}};
    labels.opacities = {{0, opacity}, {1, 0.5}, {2, 0.5}};
    const OpacityTable table(labels, {DeviceType::kU8, 1, 0}, {0, 2});
    EXPECT_EQ(table.shown().anyIn(0, 0), opacity > 0);
    EXPECT_EQ(ShownVoxels<uint8_t>(table.shown()).any(0, 0), opacity > 0);
    EXPECT_TRUE(table.shown().anyIn(1, 1));
  }
}

TEST(ShownVoxels, agreeWithTheTableOnEveryPairOfBytes) {
  std::mt19937_64 random(1);
  for (const int bands : {0, 1, 2, 5, 40})
    for (const ValueRange range : {ValueRange{0, 255}, {17, 201}, {90, 90}}) {
      const OpacityTable table = randomTable(random, bands, DeviceType::kU8, range);
      const ShownVoxels<uint8_t> shown(table.shown());
      for (int lo = 0; lo < 256; ++lo)
        for (int hi = lo; hi < 256; ++hi)
          ASSERT_EQ(shown.any(static_cast<uint8_t>(lo), static_cast<uint8_t>(hi)),
                    table.shown().anyIn(lo, hi))
              << lo << " to " << hi << ", " << bands << " bands";
    }
}

TEST(ShownVoxels, allPartsShowOnlyIfEachValueDoes) {
  std::mt19937_64 random(4);
  int64_t found = 0, showing = 0;
  for (const int bands : {0, 1, 2, 5, 40}) {
    const OpacityTable table = randomTable(random, bands, DeviceType::kU8, {17, 201});
    const ShownVoxels<uint8_t> shown(table.shown());
    for (int lo = 0; lo < 256; ++lo) {
      bool each_shows = true;
      for (int hi = lo; hi < 256; ++hi) {
        each_shows = each_shows && table.shown().anyIn(hi, hi);
        const bool all = shown.allPartsOf(static_cast<uint8_t>(lo), static_cast<uint8_t>(hi));
        if (all) {
          ASSERT_TRUE(each_shows) << lo << " to " << hi << ", " << bands << " bands";
        }
        found += all ? 1 : 0;
        showing += each_shows ? 1 : 0;
      }
    }
  }
  // Neighbouring intervals that do not meet are told apart.
  EXPECT_GT(found, showing * 9 / 10);
  EXPECT_GT(showing, 1000);
}

TEST(ShownVoxels, agreeWithTheTableOnSixteenBits) {
  std::mt19937_64 random(2);
  for (const int bands : {1, 3, 300})
    for (const ValueRange range : {ValueRange{0, 65535}, {31768, 35768}}) {
      const OpacityTable table = randomTable(random, bands, DeviceType::kU16, range);
      const ShownVoxels<uint16_t> shown(table.shown());
      for (uint32_t v = 0; v < 65536; ++v)
        ASSERT_EQ(shown.any(static_cast<uint16_t>(v), static_cast<uint16_t>(v)),
                  table.shown().anyIn(v, v))
            << v;
      for (int pair = 0; pair < 20000; ++pair) {
        const auto lo = static_cast<uint16_t>(random());
        const auto hi = static_cast<uint16_t>(std::min<uint64_t>(65535, lo + random() % 3000));
        ASSERT_EQ(shown.any(lo, hi), table.shown().anyIn(lo, hi)) << lo << " to " << hi;
      }
    }
}

TEST(ShownVoxels, agreeWithTheTableOnNeighboringFloats) {
  std::mt19937_64 random(3);
  for (const int bands : {1, 2, 50})
    for (const ValueRange range : {ValueRange{-3, 5}, {1e-8, 2e-8}, {-1e20, 1e25}, {0, 0}}) {
      const OpacityTable table = randomTable(random, bands, DeviceType::kF32, range);
      const ShownVoxels<float> shown(table.shown());
      const auto expectSame = [&](float v) {
        ASSERT_EQ(shown.any(v, v), table.shown().anyIn(v, v)) << v;
      };
      for (const float v : {kNotANumber, kLargest, 0.0F, -0.0F}) expectSame(v);
      for (int i = 0; i < 20000 && !HasFatalFailure(); ++i)
        expectSame(static_cast<float>(std::lerp(
            range.lo, range.hi, 1.2 * static_cast<double>(random() >> 11) * 0x1p-53 - 0.1)));
      // The two floats between which the answer changes.
      auto last = static_cast<float>(range.lo);
      for (int step = 1; step <= 2000 && !HasFatalFailure(); ++step) {
        const auto next = static_cast<float>(std::lerp(range.lo, range.hi, step / 2000.0));
        if (table.shown().anyIn(last, last) != table.shown().anyIn(next, next)) {
          float lo = last, hi = next;
          for (float middle = std::midpoint(lo, hi); lo < middle && middle < hi;
               middle = std::midpoint(lo, hi))
            (table.shown().anyIn(middle, middle) == table.shown().anyIn(lo, lo) ? lo : hi) = middle;
          expectSame(lo);
          expectSame(hi);
        }
        last = next;
      }
    }
}

}  // namespace
}  // namespace sluice
