#include "src/cpu/kernels/color_ramp.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

namespace sluice {
namespace {

constexpr size_t kEntries = 16384;

// 0 up to entry `lo`, `most` from `hi` on, and linear in between.
double rampAt(size_t entry, double lo, double hi, double most) {
  return most * std::clamp((static_cast<double>(entry) - lo) / (hi - lo), 0.0, 1.0);
}

// Entries of a colour, times the opacity or not.
std::vector<float> entriesOf(const std::function<double(size_t entry)>& opacity,
                             bool is_premultiplied) {
  std::vector<float> rgba;
  for (size_t i = 0; i < kEntries; ++i) {
    const double a = opacity(i), factor = is_premultiplied ? a : 1;
    for (const double number : {0.2 * factor, 0.5 * factor, 0.0, a})
      rgba.push_back(static_cast<float>(number));
  }
  return rgba;
}

// Computes an entry as the kernels do.
void expectFollows(const ColorRamp& ramp, const std::vector<float>& rgba) {
  double most = 0;
  for (size_t i = 3; i < rgba.size(); i += 4) most = std::max<double>(most, std::abs(rgba[i]));
  ASSERT_GT(most, 0);
  for (size_t i = 0; i < rgba.size() / 4; ++i) {
    const float from_first = static_cast<float>(i) - ramp.first;
    const float t = std::clamp(from_first * ramp.scale + ramp.offset, 0.0F, 1.0F);
    const float a = t * (ramp.curve[0] + t * (ramp.curve[1] + t * ramp.curve[2]));
    const double exact = rgba[4 * i + 3];
    // Nothing stays nothing, and small opacities are as exact as great ones.
    ASSERT_NEAR(a, exact, std::min(3e-5 * most, 1.1e-3 * std::abs(exact))) << i;
    const float factor = ramp.is_premultiplied ? a : 1;
    for (size_t c = 0; c < 3; ++c)
      ASSERT_NEAR(factor * ramp.rgb[c], rgba[4 * i + c], 2.5e-3 * std::abs(factor)) << i;
  }
}

TEST(ColorRamp, followsLinearOpacities) {
  for (const auto& ends : {std::pair{100.3, 12000.6},
                           {200.0, 9000.0},
                           {-60.0, 16383.0},
                           {-9000.0, 20000.0},
                           {9001.99, 16000.2}})
    for (const double most : {0.002, 0.05, 0.9})
      for (const bool is_premultiplied : {false, true}) {
        const double lo = ends.first, hi = ends.second;
        const std::vector<float> rgba =
            entriesOf([&](size_t entry) { return rampAt(entry, lo, hi, most); }, is_premultiplied);
        const auto ramp = colorRamp(rgba);
        ASSERT_TRUE(ramp.has_value()) << lo << " " << most;
        EXPECT_EQ(ramp->is_premultiplied, is_premultiplied);
        expectFollows(*ramp, rgba);
      }
}

TEST(ColorRamp, followsOpacitiesOfOtherSteps) {
  const std::vector<float> rgba = entriesOf(
      [](size_t entry) { return 1 - std::pow(1 - rampAt(entry, 700.7, 9000, 0.08), 0.5); }, true);
  const auto ramp = colorRamp(rgba);
  ASSERT_TRUE(ramp.has_value());
  expectFollows(*ramp, rgba);
}

TEST(ColorRamp, followsLogarithmsOfPerspectiveViews) {
  const std::vector<float> rgba = entriesOf(
      [](size_t entry) { return std::log2(1 - rampAt(entry, 700.7, 9000, 0.08)); }, false);
  const auto ramp = colorRamp(rgba);
  ASSERT_TRUE(ramp.has_value());
  expectFollows(*ramp, rgba);
}

TEST(ColorRamp, isNoneForOtherCurves) {
  const auto ramp = [](const std::function<double(size_t entry)>& opacity) {
    return colorRamp(entriesOf(opacity, true));
  };
  EXPECT_FALSE(ramp([](size_t) { return 0.0; }));
  EXPECT_FALSE(ramp([](size_t) { return 0.1; })) << "no rise";
  EXPECT_FALSE(ramp([](size_t entry) { return entry < 500 ? 0.0 : 0.1; })) << "a step";
  EXPECT_FALSE(ramp([](size_t entry) { return rampAt(entry, 500, 504, 0.1); })) << "nearly one";
  EXPECT_FALSE(ramp([](size_t entry) { return entry < 800 ? 0.0 : rampAt(entry, 500, 9000, 0.1); }))
      << "a ramp with a threshold";
  EXPECT_FALSE(ramp([](size_t entry) {
    return rampAt(entry, 500, 4000, 0.1) - rampAt(entry, 4000, 9000, 0.05);
  })) << "falls again";
  EXPECT_FALSE(ramp([](size_t entry) {
    return rampAt(entry, 500, 4000, 0.1) + rampAt(entry, 4000, 9000, 0.7);
  })) << "bends";
  EXPECT_FALSE(ramp([](size_t entry) { return std::log2(1 - rampAt(entry, 0, 9000, 0.9)); }))
      << "too steep at its end";
}

TEST(ColorRamp, isNoneForSeveralColors) {
  std::vector<float> rgba =
      entriesOf([](size_t entry) { return rampAt(entry, 500, 9000, 0.1); }, false);
  // Entries that show nothing may have any colour.
  rgba[4 * 200] = 0.9F;
  EXPECT_TRUE(colorRamp(rgba).has_value());
  rgba[4 * 4000] = 0.9F;
  EXPECT_FALSE(colorRamp(rgba).has_value());
}

}  // namespace
}  // namespace sluice
