#include "src/view/drawing/pace.h"

#include <gtest/gtest.h>

namespace sluice {
namespace {

constexpr double kPixels = 800 * 600;

// A machine that draws a pixel in `pixel_s` and needs `fixed_s` in addition.
Pace after(int frames, double pixel_s, double fixed_s) {
  Pace pace;
  for (int i = 0; i < frames; ++i)
    pace = learned(pace, {kPixels, 1, pixel_s * kPixels, 0, fixed_s});
  return pace;
}

TEST(Pace, drawsAllWhereThatIsQuickEnough) {
  EXPECT_TRUE(qualityWithin(after(3, 1e-8, 0.001), kPixels, 1, 0.02).isFull());
}

TEST(Pace, staysWithinTheBudgetOfAKnownMachine) {
  for (const double pixel_s : {2e-8, 1e-7, 4e-7, 1e-6}) {
    const Pace pace = after(3, pixel_s, 0.002);
    const Quality quality = qualityWithin(pace, kPixels, 1, 0.02);
    const double taken =
        0.002 + pixel_s * kPixels * quality.scale * quality.scale / quality.step_factor;
    EXPECT_LE(taken, 0.02) << pixel_s;
    EXPECT_NEAR(taken, expectedSeconds(pace, quality, kPixels, 1), 1e-9);
  }
}

TEST(Pace, givesTheLeastWhereNothingFits) {
  const Quality quality = qualityWithin(after(3, 1e-3, 1), kPixels, 1, 0.02);
  EXPECT_LT(quality.scale, 0.2);
}

TEST(Pace, beginsSmallWhereNothingIsKnown) {
  EXPECT_EQ(qualityWithin(Pace(), kPixels, 1, 0.02).scale, 0.25);
}

TEST(Pace, slowerFramesCountSooner) {
  const Pace pace = after(20, 1e-7, 0);
  const Pace slower = learned(pace, {kPixels, 1, 2e-7 * kPixels, 0, 0});
  const Pace faster = learned(pace, {kPixels, 1, 0.5e-7 * kPixels, 0, 0});
  EXPECT_GT(slower.pixel_s - pace.pixel_s, 2 * (pace.pixel_s - faster.pixel_s));
}

TEST(Pace, aLongerStepTakesLess) {
  const Pace pace = after(3, 1e-7, 0);
  EXPECT_NEAR(expectedSeconds(pace, {1, 2}, kPixels, 1),
              expectedSeconds(pace, {1, 1}, kPixels, 1) / 2, 1e-12);
}

TEST(Pace, bytesTakeTheSameTimeAtAnyStep) {
  Pace pace;
  pace = learned(pace, {.pixels = kPixels, .step_vox = 2, .draw_s = 0.001, .convert_s = 0.010});
  EXPECT_NEAR(expectedSeconds(pace, {1, 1}, kPixels, 2), 0.011, 1e-12);
  EXPECT_NEAR(expectedSeconds(pace, {1, 4}, kPixels, 2), 0.01025, 1e-12);
  EXPECT_NEAR(expectedSeconds(pace, {0.5, 1}, kPixels, 2), 0.00275, 1e-12);
}

TEST(Pace, aPictureThatIsDrawnAtOnceIsSmallerIfItsBytesTakeLong) {
  Pace pace;
  pace = learned(pace, {.pixels = kPixels, .draw_s = 0.004, .convert_s = 0.025});
  const Quality quality = qualityWithin(pace, kPixels, 1, 0.016);
  EXPECT_LT(quality.scale, 1);
  EXPECT_LE(expectedSeconds(pace, quality, kPixels, 1), 0.016);
}

TEST(Pace, withLevelsOfResolutionASmallerPictureHasLongerSteps) {
  for (const double pixel_s : {2e-8, 1e-7, 4e-7}) {
    const Pace pace = after(3, pixel_s, 0.002);
    const Quality fixed = qualityWithin(pace, kPixels, 1, 0.02);
    const Quality quality = qualityWithin(pace, kPixels, 1, 0.02, PreviewSteps::kFollowPixels);
    EXPECT_GE(quality.scale, fixed.scale);
    EXPECT_EQ(quality.step_factor, 1 / quality.scale);
    EXPECT_LE(expectedSeconds(pace, quality, kPixels, 1), 0.02);
  }
}

TEST(Pace, showingTakesItsPartOfTheBudget) {
  EXPECT_DOUBLE_EQ(drawingBudget(0.016, 0), 0.016);
  EXPECT_DOUBLE_EQ(drawingBudget(0.016, 0.006), 0.010);
  EXPECT_DOUBLE_EQ(drawingBudget(0.015, 0.2), 0.005) << "however slow the window is";
}

}  // namespace
}  // namespace sluice
