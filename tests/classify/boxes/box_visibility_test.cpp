// Whether a box shows anything: never false if a sample of the plane of values and magnitudes that
// the box may hold is opaque; false if a transfer function plainly shows nothing.
#include "src/classify/boxes/box_visibility.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "src/classify/transfer/transfer_makers.h"
#include "tests/support/gradient_factor.h"

namespace sluice {
namespace {

constexpr ValueRange kRange{0, 255};

VolumeLayout layoutOf() {
  VolumeLayout layout;
  layout.dims = {10, 10, 10};
  return layout;
}

TransferFunction someTransfer(std::vector<GradientRow> rows) {
  TransferFunction transfer = thresholdTransfer(40, kRange, 0.2);
  transfer.gradients = std::move(rows);
  return transfer;
}

CellRange cells(double lo, double hi, double gradient_lo, double gradient_hi) {
  return {static_cast<float>(lo), static_cast<float>(hi), static_cast<float>(gradient_lo),
          static_cast<float>(gradient_hi)};
}

TransferFunction randomTransfer(std::mt19937_64& random) {
  std::uniform_real_distribution<double> unit(0, 1);
  std::vector<GradientRow> rows;
  double magnitude = unit(random) < 0.5 ? 0 : 20 * unit(random);
  for (size_t row = 0; row < 1 + random() % 5; ++row) {
    std::vector<double> values(4);
    for (double& value : values) value = 255 * unit(random);
    std::sort(values.begin(), values.end());
    const double a = unit(random) < 0.5 ? 0 : unit(random);
    rows.push_back({magnitude, {{values[0], 0}, {values[1], a}, {values[2], a}, {values[3], 0}}});
    if (unit(random) < 0.3) rows.back().factors = {{0, a}};
    magnitude += 1 + 40 * unit(random);
  }
  return someTransfer(rows);
}

TEST(BoxVisibility, isNeverFalseWhereASampleIsOpaque) {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> unit(0, 1);
  int hidden = 0, shown = 0;
  for (int i = 0; i < 300; ++i) {
    const TransferFunction transfer = randomTransfer(random);
    for (const double scale : {1.0, -0.25}) {
      const ValueMap map{DeviceType::kF32, scale, scale < 0 ? 255 * 0.25 : 0};
      const OpacityTable table(transfer, map, kRange);
      const BoxVisibility visibility(table, layoutOf());
      for (int box = 0; box < 20; ++box) {
        const double lo = 255 * unit(random), hi = lo + (255 - lo) * unit(random) * 0.3;
        const double g_lo = 100 * unit(random), g_hi = g_lo + 20 * unit(random);
        bool opaque = false;
        for (int sample = 0; sample < 60 && !opaque; ++sample) {
          const double value = map.valueOf(lo + (hi - lo) * unit(random));
          const double magnitude = (g_lo + (g_hi - g_lo) * unit(random)) * std::abs(scale);
          opaque = opacityAt(transfer, value) * gradientFactorAt(transfer, value, magnitude) > 0;
        }
        const bool shows = visibility.shows(cells(lo, hi, g_lo, g_hi));
        EXPECT_TRUE(shows || !opaque) << "transfer " << i << ", box " << box;
        (shows ? shown : hidden) += 1;
      }
    }
  }
  EXPECT_GT(hidden, 1000);
  EXPECT_GT(shown, 1000);
}

TEST(BoxVisibility, flatBoxesAreHiddenByModulation) {
  const OpacityTable table(modulateByGradient(thresholdTransfer(40, kRange), 25),
                           {DeviceType::kU8, 1, 0}, kRange);
  const BoxVisibility visibility(table, layoutOf());
  EXPECT_FALSE(visibility.shows(cells(200, 200, 0, 0)));
  EXPECT_TRUE(visibility.shows(cells(200, 201, 0, 0.5)));
  EXPECT_FALSE(visibility.shows(cells(0, 30, 3, 20))) << "by its values";
}

TEST(BoxVisibility, aBandOfMagnitudesHidesWhatIsBesideIt) {
  const OpacityTable table(
      someTransfer({{10, {{0, 0}}}, {20, {{0, 1}}}, {30, {{0, 1}}}, {40, {{0, 0}}}}),
      {DeviceType::kU8, 1, 0}, kRange);
  const BoxVisibility visibility(table, layoutOf());
  EXPECT_FALSE(visibility.shows(cells(50, 250, 0, 9.9)));
  EXPECT_FALSE(visibility.shows(cells(50, 250, 40.1, 90)));
  EXPECT_TRUE(visibility.shows(cells(50, 250, 0, 10.1)));
  EXPECT_TRUE(visibility.shows(cells(50, 250, 22, 23)));
  EXPECT_TRUE(visibility.shows(cells(50, 250, 39.9, 90)));
  EXPECT_TRUE(visibility.shows(cells(50, 250, 39.9, kLargest)));
  EXPECT_TRUE(visibility.shows(cells(50, 250, 90, kLargest))) << "beside no number: may be flat";
}

TEST(BoxVisibility, axesThatAreNoRightAnglesWidenTheInterval) {
  VolumeLayout oblique = layoutOf();
  oblique.axes[1] = normalized(Vec3d{1, 1, 0});
  const OpacityTable table(someTransfer({{12, {{0, 0}}}, {20, {{0, 1}}}}), {DeviceType::kU8, 1, 0},
                           kRange);
  // (7, 7, 0): 9.9 long at right angles, 12.9 here.
  const CellRange range = cells(50, 250, 9.9, 9.9);
  EXPECT_FALSE(BoxVisibility(table, layoutOf()).shows(range));
  EXPECT_GT(length(oblique.axes[0] * 7 + oblique.axes[1] * 7), 12);
  EXPECT_TRUE(BoxVisibility(table, oblique).shows(range));
}

TEST(BoxVisibility, withoutRowsGradientsMakeNoDifference) {
  const OpacityTable table(thresholdTransfer(40, kRange), {DeviceType::kU8, 1, 0}, kRange);
  const BoxVisibility visibility(table, layoutOf());
  EXPECT_TRUE(visibility.shows(cells(200, 200, 0, 0)));
  EXPECT_FALSE(visibility.shows(cells(0, 39, 0, 100)));
}

}  // namespace
}  // namespace sluice
