#include "src/view/state/editing/transfer_edit.h"

#include <gtest/gtest.h>

namespace sluice {
namespace {

constexpr std::array<double, 2> kRange{0, 100};

TEST(TransferEdit, aThresholdTakesThePlaceOfOtherOpacities) {
  LookOptions look;
  look.opacities = {{1, 0}, {2, 1}};
  look.map = "viridis";
  look.range = kRange;
  look = withThreshold(look, 40);
  EXPECT_EQ(look.threshold, 40);
  EXPECT_TRUE(look.opacities.empty());
  EXPECT_EQ(look.map, "viridis");
  EXPECT_FALSE(look.range) << "it was that of the points";
}

TEST(TransferEdit, aThresholdKeepsTheWindowOfARamp) {
  LookOptions look;
  look.threshold = 10;
  look.range = std::array{20.0, 30.0};
  EXPECT_EQ(withThreshold(look, 25).range, (std::array{20.0, 30.0}));
}

TEST(TransferEdit, theWindowOfARampBeginsAtItsThreshold) {
  LookOptions look;
  EXPECT_EQ(colorsOf(look, kRange), kRange);
  look = withThreshold(look, 40);
  EXPECT_EQ(colorsOf(look, kRange), (std::array{40.0, 100.0}));
  EXPECT_EQ(colorsOf(withThreshold(look, 100), kRange), kRange);
  look.range = std::array{90.0, 10.0};
  EXPECT_EQ(colorsOf(look, kRange), (std::array{90.0, 10.0}));
}

TEST(TransferEdit, aLookBecomesPointsThatSayTheSame) {
  LookOptions look;
  look.threshold = 40;
  ShownLook shown;
  shown.opacities = {{40, 0}, {40, 0.01}, {100, 0.05}};
  shown.options = "--threshold 40 --opacity 0.05 --map ct-bone --shade";
  const LookOptions points = byPoints(look, shown, kRange);
  EXPECT_FALSE(points.threshold);
  ASSERT_EQ(points.opacities.size(), 3U);
  EXPECT_EQ(points.opacities[2].opacity, 0.05);
  EXPECT_EQ(points.map, "ct-bone");
  EXPECT_EQ(points.range, (std::array{40.0, 100.0}));  // colours of a ramp begin at its threshold
  EXPECT_EQ(byPoints(points, {}, {0, 1}), points);
  shown.options += " --range 90,10";
  EXPECT_EQ(byPoints(look, shown, kRange).range, (std::array{90.0, 10.0}));
}

TEST(TransferEdit, pointsOverAFileKeepItsColours) {
  LookOptions look;
  look.transfer_file = "my colours.json";
  look.full_gradient = 0.2;
  ShownLook shown;
  shown.opacities = {{0, 0}, {100, 0.05}};
  shown.options = "--transfer 'my colours.json' --no-shade";
  const LookOptions points = byPoints(look, shown, kRange);
  EXPECT_EQ(points.transfer_file, look.transfer_file);
  EXPECT_EQ(points.opacities.size(), 2U);
  EXPECT_EQ(points.map, "");
  EXPECT_FALSE(points.range);
  EXPECT_EQ(points.full_gradient, look.full_gradient);
}

TEST(TransferEdit, pointsAreAddedInOrderMovedBetweenNeighboursAndRemoved) {
  OpacityPoints points{{0, 0}, {100, 0.1}};
  EXPECT_EQ(addPoint(points, 50, 0.2), 1U);
  movePoint(points, 1, 170, 2);
  EXPECT_EQ(points[1], (LookOptions::Opacity{100, 1}));
  movePoint(points, 1, -20, -1);
  EXPECT_EQ(points[1], (LookOptions::Opacity{0, 0}));
  EXPECT_TRUE(removePoint(points, 1));
  EXPECT_FALSE(removePoint(points, 0)) << "two points make a look";
  EXPECT_EQ(points.size(), 2U);
}

TEST(TransferEdit, findsTheNearestPointWithinReach) {
  const OpacityPoints points{{10, 0.008}, {50, 0.125}};  // heights 0.2 and 0.5
  EXPECT_EQ(pointAt(points, kRange, 0.51, 0.49, 0.03, 0.05), 1U);
  EXPECT_EQ(pointAt(points, kRange, 0.11, 0.21, 0.03, 0.05), 0U);
  EXPECT_FALSE(pointAt(points, kRange, 0.3, 0.3, 0.03, 0.05));
}

TEST(TransferEdit, heightsAndOpacitiesAreInverse) {
  for (const double opacity : {0.0, 0.001, 0.05, 0.5, 1.0})
    EXPECT_NEAR(opacityAtHeight(heightOf(opacity)), opacity, 1e-12);
}

TEST(TransferEdit, windowAndLevelMoveApart) {
  const auto wider = windowDragged({40, 60}, 0.1, 0, kRange);
  EXPECT_NEAR(wider[0], 35, 1e-9);
  EXPECT_NEAR(wider[1], 65, 1e-9);
  const auto higher = windowDragged({40, 60}, 0, 0.1, kRange);
  EXPECT_NEAR(higher[0], 50, 1e-9);
  EXPECT_NEAR(higher[1], 70, 1e-9);
  const auto least = windowDragged({40, 60}, -1, 0, kRange);
  EXPECT_LT(least[0], least[1]);
  const auto turned = windowDragged({60, 40}, 0.1, 0, kRange);
  EXPECT_NEAR(turned[0], 65, 1e-9);
}

TEST(TransferEdit, findsWordsInAText) {
  EXPECT_EQ(wordAfter("--map ct-bone --range 1,2", "--map"), "ct-bone");
  EXPECT_EQ(wordAfter("--map ct-bone --range 1,2", "--range"), "1,2");
  EXPECT_EQ(wordAfter("--map 'Cool to Warm' --shade", "--map"), "Cool to Warm");
  EXPECT_EQ(wordAfter("--shade", "--map"), "");
  EXPECT_EQ(wordAfter("--shade", "--shade"), "");
}

}  // namespace
}  // namespace sluice
