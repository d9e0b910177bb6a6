#include "src/classify/transfer/transfer_makers.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>

#include "src/base/error.h"
#include "src/base/values/histogram.h"
#include "tests/support/gradient_factor.h"

namespace sluice::transfer_makers_test {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

TEST(ThresholdTransfer, isTheRampOfTheInterface) {
  const auto transfer = thresholdTransfer(40, {0, 240}, 0.05);
  EXPECT_EQ(opacityAt(transfer, 0), 0);
  EXPECT_EQ(opacityAt(transfer, 39.999), 0);
  EXPECT_DOUBLE_EQ(opacityAt(transfer, 40), 0.01);
  EXPECT_DOUBLE_EQ(opacityAt(transfer, 140), 0.03);
  EXPECT_DOUBLE_EQ(opacityAt(transfer, 240), 0.05);
  EXPECT_EQ(transfer.name, "threshold 40");
}

TEST(ThresholdTransfer, stretchesTheMapFromTheThresholdToTheTop) {
  const auto transfer = thresholdTransfer(40, {0, 240}, 0.05, "grey");
  EXPECT_EQ(colorAt(transfer, 40), (Vec3d{0, 0, 0}));
  EXPECT_EQ(colorAt(transfer, 140), (Vec3d{0.5, 0.5, 0.5}));
  EXPECT_EQ(colorAt(transfer, 240), (Vec3d{1, 1, 1}));
}

TEST(ThresholdTransfer, aboveTheRangeShowsNothing) {
  const auto transfer = thresholdTransfer(256, {0, 255});
  for (int value = 0; value <= 255; ++value) EXPECT_EQ(opacityAt(transfer, value), 0);
}

TEST(ThresholdTransfer, belowTheRangeShowsEverything) {
  const auto transfer = thresholdTransfer(-10, {0, 90}, 0.5);
  EXPECT_NEAR(opacityAt(transfer, 0), 0.1 + 0.4 * 0.1, 1e-15);
  EXPECT_EQ(opacityAt(transfer, 90), 0.5);
}

TEST(ThresholdTransfer, atTheTopShowsTheTopAlone) {
  const auto transfer = thresholdTransfer(255, {0, 255}, 0.5);
  EXPECT_EQ(opacityAt(transfer, 254), 0);
  EXPECT_EQ(opacityAt(transfer, 255), 0.5);
}

TEST(ThresholdTransfer, ofAConstantVolumeIsValid) {
  EXPECT_EQ(opacityAt(thresholdTransfer(3, {3, 3}, 0.5), 3), 0.5);
  EXPECT_EQ(opacityAt(thresholdTransfer(4, {3, 3}, 0.5), 3), 0);
}

TEST(ThresholdTransfer, rejectsWhatIsNoThresholdOpacityOrMap) {
  EXPECT_THROW(thresholdTransfer(kNan, {0, 1}), Error);
  EXPECT_THROW(thresholdTransfer(std::numeric_limits<double>::infinity(), {0, 1}), Error);
  EXPECT_THROW(thresholdTransfer(0.5, {0, 1}, 1.5), Error);
  EXPECT_THROW(thresholdTransfer(0.5, {0, 1}, -0.5), Error);
  EXPECT_THROW(thresholdTransfer(0.5, {0, 1}, kNan), Error);
  EXPECT_THROW(thresholdTransfer(0.5, {0, 1}, 0.5, "jet"), Error);
}

TEST(ScaleOpacity, multipliesAndStopsAtOne) {
  const auto transfer = scaleOpacity(thresholdTransfer(40, {0, 240}, 0.5), 4);
  EXPECT_DOUBLE_EQ(opacityAt(transfer, 40), 0.4);
  EXPECT_EQ(opacityAt(transfer, 240), 1);
  EXPECT_EQ(opacityAt(transfer, 39), 0);
  EXPECT_EQ(opacityAt(scaleOpacity(transfer, 0), 240), 0);
}

TEST(Histogram, putsIntegersInBinsOfTheirOwn) {
  for (const int top : {1, 2, 100, 255, 4095}) {
    for (int value = 0; value <= top; ++value) {
      const auto bins = static_cast<size_t>(top) + 1;
      EXPECT_EQ(binOf({0, static_cast<double>(top)}, bins, value), static_cast<size_t>(value));
    }
  }
}

TEST(Histogram, clampsWhatLiesOutside) {
  EXPECT_EQ(binOf({-1, 1}, 10, -5), 0U);
  EXPECT_EQ(binOf({-1, 1}, 10, 5), 9U);
  EXPECT_EQ(binOf({-1, 1}, 10, 0), 5U);
  EXPECT_EQ(binOf({3, 3}, 10, 3), 0U);
  const double most = std::numeric_limits<double>::max();
  EXPECT_EQ(binOf({-most, most}, 10, 0), 5U);
}

TEST(Histogram, percentilesSpreadCountsInsideTheirBin) {
  const Histogram histogram{{0, 4}, {0, 10, 0, 30}};
  EXPECT_EQ(total(histogram), 40U);
  EXPECT_DOUBLE_EQ(percentile(histogram, 0), 1);
  EXPECT_DOUBLE_EQ(percentile(histogram, 0.125), 1.5);
  EXPECT_DOUBLE_EQ(percentile(histogram, 0.25), 2);
  EXPECT_DOUBLE_EQ(percentile(histogram, 0.625), 3.5);
  EXPECT_DOUBLE_EQ(percentile(histogram, 1), 4);
  EXPECT_DOUBLE_EQ(shareAbove(histogram, 3.5), 0.375);
  EXPECT_DOUBLE_EQ(shareAbove(histogram, 2.5), 0.75);
  EXPECT_DOUBLE_EQ(shareAbove(histogram, 0), 1);
  EXPECT_DOUBLE_EQ(shareAbove(histogram, 4), 0);
}

TEST(Histogram, ofNothingHasPercentilesAllTheSame) {
  EXPECT_EQ(percentile({{2, 5}, {}}, 0.5), 2);
  EXPECT_EQ(percentile({{2, 5}, {0, 0}}, 1), 2);
  EXPECT_EQ(shareAbove({{2, 5}, {0, 0}}, 1), 0);
}

TEST(Histogram, mirrorsAndFolds) {
  const Histogram histogram{{-2, 4}, {1, 2, 3, 4, 5, 6}};
  const Histogram mirror = mirrored(histogram);
  EXPECT_EQ(mirror.range, (ValueRange{-4, 2}));
  EXPECT_THAT(mirror.counts, testing::ElementsAre(6, 5, 4, 3, 2, 1));
  const Histogram fold = folded(histogram);
  EXPECT_EQ(fold.range, (ValueRange{0, 4}));
  EXPECT_EQ(total(fold), total(histogram));
  EXPECT_NEAR(shareAbove(fold, 2), 11.0 / 21, 0.05);
}

TEST(ModulateByGradient, isARampOfTheMagnitudeWhateverTheValue) {
  const auto transfer = modulateByGradient(thresholdTransfer(40, {0, 240}, 0.05), 20);
  for (const double value : {-5.0, 40.0, 100.0, 1000.0}) {
    EXPECT_EQ(gradientFactorAt(transfer, value, 0), 0);
    EXPECT_DOUBLE_EQ(gradientFactorAt(transfer, value, 5), 0.25);
    EXPECT_EQ(gradientFactorAt(transfer, value, 20), 1);
    EXPECT_EQ(gradientFactorAt(transfer, value, 1e300), 1);
  }
  EXPECT_DOUBLE_EQ(opacityAt(transfer, 240), 0.05) << "the most that any gradient shows";
  EXPECT_EQ(transfer.name, "threshold 40, modulated");
}

TEST(ModulateByGradient, rejectsWhatIsNoMagnitudeAndASecondTime) {
  const auto transfer = thresholdTransfer(40, {0, 240}, 0.05);
  for (const double magnitude : {0.0, -1.0, kNan, std::numeric_limits<double>::infinity()})
    EXPECT_THROW(modulateByGradient(transfer, magnitude), Error) << magnitude;
  EXPECT_THROW(modulateByGradient(modulateByGradient(transfer, 3), 3), Error);
}

}  // namespace
}  // namespace sluice::transfer_makers_test
