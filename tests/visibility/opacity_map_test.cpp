// Questions to the map against plain loops over its pixels.
#include "src/visibility/occlusion/opacity_map.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

namespace sluice {
namespace {

constexpr float kThreshold = 0.95F;

// Bounds of all unit squares that are visible, cut to the rectangle. Beyond the map everything is.
MapRect plainVisiblePart(const OpacityMap& map, const MapRect& rect, float threshold) {
  MapRect visible;
  for (int y = static_cast<int>(std::floor(rect.y0)); y < rect.y1; ++y)
    for (int x = static_cast<int>(std::floor(rect.x0)); x < rect.x1; ++x) {
      const bool inside = x >= 0 && y >= 0 && x < map.side() && y < map.side();
      if (inside && map.at(x, y) >= threshold) continue;
      const auto left = static_cast<double>(x), below = static_cast<double>(y);
      visible = unite(visible, intersect(rect, {left, below, left + 1, below + 1}));
    }
  return visible;
}

// Opaque but for a few blots.
std::vector<float> blotted(int side, int blots, std::mt19937& random) {
  std::vector<float> opacity(static_cast<size_t>(side) * static_cast<size_t>(side), 1.F);
  const auto below = [&](int count) {
    return static_cast<int>(random() % static_cast<unsigned>(count));
  };
  for (int i = 0; i < blots; ++i) {
    const int size = 1 + below(4), x0 = below(side), y0 = below(side);
    for (int y = y0; y < std::min(side, y0 + size); ++y)
      for (int x = x0; x < std::min(side, x0 + size); ++x)
        opacity[static_cast<size_t>(y * side + x)] = 0.94F;
  }
  return opacity;
}

TEST(OpacityMap, visiblePartIsThatOfAPlainLoop) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> place(-6, 70), length(0.01, 30);
  int culled = 0, clipped = 0;
  for (const int side : {1, 2, 7, 33, 64})
    for (int round = 0; round < 60; ++round) {
      OpacityMap map(side);
      map.update(blotted(side, round % 6, random));
      for (int i = 0; i < 60; ++i) {
        MapRect rect{place(random) * side / 64, place(random) * side / 64, 0, 0};
        if (i % 4 == 0) rect = {std::floor(rect.x0), std::floor(rect.y0), 0, 0};
        rect.x1 = rect.x0 + (i % 4 == 1 ? std::ceil(length(random)) : length(random));
        rect.y1 = rect.y0 + length(random);
        const MapRect expected = plainVisiblePart(map, rect, kThreshold);
        const MapRect found = map.visiblePart(rect, kThreshold);
        ASSERT_EQ(found.empty(), expected.empty());
        ASSERT_EQ(map.isOpaque(rect, kThreshold), expected.empty());
        culled += expected.empty() ? 1 : 0;
        if (expected.empty()) continue;
        ASSERT_EQ(found, expected);
        clipped += found == rect ? 0 : 1;
      }
    }
  EXPECT_GT(culled, 1000);
  EXPECT_GT(clipped, 1000);
}

TEST(OpacityMap, theThresholdItselfIsOpaque) {
  OpacityMap map(4);
  map.update(std::vector<float>(16, kThreshold));
  EXPECT_TRUE(map.isOpaque({0, 0, 4, 4}, kThreshold));
  EXPECT_FALSE(map.isOpaque({0, 0, 4, 4}, std::nextafter(kThreshold, 1.F)));
}

TEST(OpacityMap, beforeTheFirstUpdateEverythingIsVisible) {
  OpacityMap map(8);
  const MapRect rect{1, 2, 3.5, 4};
  EXPECT_FALSE(map.valid());
  EXPECT_EQ(map.visiblePart(rect, 0), rect);
  map.update(std::vector<float>(64, 1));
  EXPECT_TRUE(map.isOpaque(rect, kThreshold));
}

TEST(OpacityMap, whatLiesOutsideIsVisible) {
  OpacityMap map(8);
  map.update(std::vector<float>(64, 1));
  constexpr double kEndless = std::numeric_limits<double>::infinity();
  const MapRect endless{-kEndless, -kEndless, kEndless, kEndless};
  EXPECT_EQ(map.visiblePart(endless, kThreshold), endless);
  EXPECT_EQ(map.visiblePart({-2, 1, 5, 3}, kThreshold), (MapRect{-2, 1, 0, 3}));
  EXPECT_EQ(map.visiblePart({6, 1, 9.5, 3}, kThreshold), (MapRect{8, 1, 9.5, 3}));
  EXPECT_EQ(map.visiblePart({20, 20, 30, 30}, kThreshold), (MapRect{20, 20, 30, 30}));
  EXPECT_TRUE(map.isOpaque({0, 0, 8, 8}, kThreshold)) << "the border itself is inside";
}

TEST(OpacityMap, notANumberHidesNothing) {
  OpacityMap map(4);
  std::vector<float> opacity(16, 1);
  opacity[5] = std::numeric_limits<float>::quiet_NaN();
  map.update(opacity);
  EXPECT_EQ(map.visiblePart({0, 0, 4, 4}, kThreshold), (MapRect{1, 1, 2, 2}));
  EXPECT_FALSE(map.isOpaque({1, 1, 2, 2}, kThreshold));
}

}  // namespace
}  // namespace sluice
