#include "src/base/values/vec.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <set>
#include <tuple>

namespace sluice {
namespace {

// Small boxes around the origin, empty ones among them.
Box3 randomBox(std::mt19937& random) {
  std::uniform_int_distribution<int64_t> at(-3, 4);
  return {{at(random), at(random), at(random)}, {at(random), at(random), at(random)}};
}

using Points = std::set<std::tuple<int64_t, int64_t, int64_t>>;

// A box by the definition lo <= p < hi, one element after the other.
Points pointsOf(const Box3& box) {
  Points points;
  for (int64_t z = -5; z < 6; ++z)
    for (int64_t y = -5; y < 6; ++y)
      for (int64_t x = -5; x < 6; ++x)
        if (x >= box.lo.x && x < box.hi.x && y >= box.lo.y && y < box.hi.y && z >= box.lo.z &&
            z < box.hi.z)
          points.emplace(x, y, z);
  return points;
}

TEST(Vec3, componentsGoByNameAndByAxis) {
  Vec3i v{1, 2, 3};
  EXPECT_EQ(v[0], v.x);
  EXPECT_EQ(v[1], v.y);
  EXPECT_EQ(v[2], v.z);
  v[1] = 20;
  EXPECT_EQ(v, (Vec3i{1, 20, 3}));
}

TEST(Vec3, arithmeticIsComponentByComponent) {
  const Vec3i a{7, -8, 9}, b{2, 3, -4};
  EXPECT_EQ(a + b, (Vec3i{9, -5, 5}));
  EXPECT_EQ(a - b, (Vec3i{5, -11, 13}));
  EXPECT_EQ(-a, (Vec3i{-7, 8, -9}));
  EXPECT_EQ(a * b, (Vec3i{14, -24, -36}));
  EXPECT_EQ(a / b, (Vec3i{3, -2, -2}));
  EXPECT_EQ(a * 2, (Vec3i{14, -16, 18}));
  EXPECT_EQ(int64_t{2} * a, a * 2);
  EXPECT_EQ(a / 2, (Vec3i{3, -4, 4}));
  EXPECT_EQ(min(a, b), (Vec3i{2, -8, -4}));
  EXPECT_EQ(max(a, b), (Vec3i{7, 3, 9}));
}

TEST(Vec3, volumeGoesBeyond32Bits) {
  EXPECT_EQ(volume(Vec3i{100000, 200000, 300000}), 6000000000000000);
}

TEST(Vec3, crossIsOrthogonalAndRightHanded) {
  EXPECT_EQ(cross({1, 0, 0}, {0, 1, 0}), (Vec3d{0, 0, 1}));
  const Vec3d a{1, 2, 3}, b{-4, 5, 0.5}, c = cross(a, b);
  EXPECT_EQ(dot(a, c), 0);
  EXPECT_EQ(dot(b, c), 0);
  EXPECT_DOUBLE_EQ(length(c) * length(c), dot(a, a) * dot(b, b) - dot(a, b) * dot(a, b));
}

TEST(Vec3, normalizedHasLengthOne) {
  EXPECT_EQ(normalized({0, -2, 0}), (Vec3d{0, -1, 0}));
  EXPECT_DOUBLE_EQ(length(normalized({3, 4, 12})), 1);
}

TEST(Vec3, ceilDivRoundsUp) {
  EXPECT_EQ(ceilDiv(0, 7), 0);
  EXPECT_EQ(ceilDiv(1, 7), 1);
  EXPECT_EQ(ceilDiv(7, 7), 1);
  EXPECT_EQ(ceilDiv(8, 7), 2);
}

TEST(Box3, countAndContainsFollowTheHalfOpenDefinition) {
  std::mt19937 random(1);
  for (int trial = 0; trial < 200; ++trial) {
    const Box3 box = randomBox(random);
    const Points points = pointsOf(box);
    EXPECT_EQ(box.count(), static_cast<int64_t>(points.size()));
    EXPECT_EQ(box.empty(), points.empty());
    for (int64_t x = -5; x < 6; ++x)
      EXPECT_EQ(box.contains(Vec3i{x, 1, -1}), points.contains({x, 1, -1}));
  }
}

TEST(Box3, intersectionHoldsWhatBothHold) {
  std::mt19937 random(2);
  for (int trial = 0; trial < 200; ++trial) {
    const Box3 a = randomBox(random), b = randomBox(random);
    const Points in_a = pointsOf(a), in_b = pointsOf(b);
    Points both;
    for (const auto& p : in_a)
      if (in_b.contains(p)) both.insert(p);
    EXPECT_EQ(pointsOf(intersect(a, b)), both);
  }
}

TEST(Box3, unionIsTheSmallestBoxOfBoth) {
  std::mt19937 random(3);
  for (int trial = 0; trial < 200; ++trial) {
    const Box3 a = randomBox(random), b = randomBox(random), both = unite(a, b);
    EXPECT_TRUE(both.contains(a));
    EXPECT_TRUE(both.contains(b));
    if (a.empty() && b.empty()) {
      EXPECT_TRUE(both.empty());
    }
    if (both.empty()) continue;
    // Without any of its six faces it would miss something.
    for (int axis = 0; axis < 3; ++axis) {
      Box3 lower = both, upper = both;
      ++lower.lo[axis];
      --upper.hi[axis];
      EXPECT_FALSE(lower.contains(a) && lower.contains(b));
      EXPECT_FALSE(upper.contains(a) && upper.contains(b));
    }
  }
}

TEST(Box3, containsBoxesElementByElement) {
  std::mt19937 random(4);
  for (int trial = 0; trial < 500; ++trial) {
    const Box3 a = randomBox(random), b = randomBox(random);
    const Points in_a = pointsOf(a), in_b = pointsOf(b);
    const bool all =
        std::all_of(in_b.begin(), in_b.end(), [&](const auto& p) { return in_a.contains(p); });
    EXPECT_EQ(a.contains(b), all);
  }
}

TEST(Box3, translateKeepsTheSize) {
  const Box3 box{{1, 2, 3}, {4, 6, 8}};
  EXPECT_EQ(translate(box, {10, -10, 0}), (Box3{{11, -8, 3}, {14, -4, 8}}));
  EXPECT_EQ(translate(box, {10, -10, 0}).size(), box.size());
}

}  // namespace
}  // namespace sluice
