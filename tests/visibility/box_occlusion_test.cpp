// Projection and clipping of boxes against single points and their rays.
#include "src/visibility/occlusion/box_occlusion.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace sluice {
namespace {

class Random {
 public:
  double between(double lo, double hi) {
    return lo + (hi - lo) * std::uniform_real_distribution<double>(0, 1)(engine_);
  }
  Vec3d in(const RealBox& box) {
    return {between(box.lo.x, box.hi.x), between(box.lo.y, box.hi.y), between(box.lo.z, box.hi.z)};
  }
  RealBox boxIn(const RealBox& box) {
    const Vec3d a = in(box), b = in(box);
    return {min(a, b), max(a, b)};
  }
  Vec3d direction() {
    Vec3d d;
    while (length(d) < 0.1) d = {between(-1, 1), between(-1, 1), between(-1, 1)};
    return d;
  }

 private:
  std::mt19937 engine_{9};
};

struct MapPoint {
  double x, y;
};
// The point at which the ray through p meets the map.
MapPoint pointOn(const MapProjection& map, Vec3d p) {
  const Vec3d along = map.parallel ? map.eye : p - map.eye;
  const Vec3d hit = p + along * ((map.plane - p[map.axis]) / along[map.axis]);
  return {(hit[map.u] - map.u0) * map.u_scale, (hit[map.v] - map.v0) * map.v_scale};
}

bool contains(const MapRect& rect, MapPoint p, double margin) {
  return p.x >= rect.x0 - margin && p.x <= rect.x1 + margin && p.y >= rect.y0 - margin &&
         p.y <= rect.y1 + margin;
}
bool contains(const RealBox& box, Vec3d p, double margin) {
  for (int a = 0; a < 3; ++a)
    if (p[a] < box.lo[a] - margin || p[a] > box.hi[a] + margin) return false;
  return true;
}
bool isWhole(const std::optional<RealBox>& rest, const RealBox& box) {
  return rest && rest->lo == box.lo && rest->hi == box.hi;
}

const RealBox kVolume{{-5, 2, 0}, {40, 33, 25}};

// Parallel, and eyes inside and outside, in front, near and far.
MapProjection someMap(Random& random, int round) {
  const Vec3d direction = random.direction();
  if (round % 2 == 0) return parallelMap(kVolume, direction, 64);
  const Vec3d middle = (kVolume.lo + kVolume.hi) / 2;
  const Vec3d eye = middle - direction * (random.between(5, 200) / length(direction));
  return perspectiveMap(kVolume, eye, direction, 64);
}

TEST(BoxOcclusion, aBoxCoversTheBoundsOfItsPoints) {
  Random random;
  int endless = 0, tight = 0;
  for (int round = 0; round < 400; ++round) {
    const MapProjection map = someMap(random, round);
    for (int i = 0; i < 10; ++i) {
      const RealBox box = random.boxIn(kVolume);
      const MapRect rect = project(map, box);
      if (std::isinf(rect.x0)) {
        ++endless;
        continue;
      }
      MapRect seen;
      for (int k = 0; k < 60; ++k) {
        Vec3d p = random.in(box);
        if (k < 8)  // the corners, at which the bounds are taken
          p = {(k & 1) != 0 ? box.hi.x : box.lo.x, (k & 2) != 0 ? box.hi.y : box.lo.y,
               (k & 4) != 0 ? box.hi.z : box.lo.z};
        const MapPoint at = pointOn(map, p);
        const double near = 1e-9 * (1 + std::abs(at.x) + std::abs(at.y));
        ASSERT_TRUE(contains(rect, at, near));
        seen = unite(seen, {at.x, at.y, at.x + near, at.y + near});
      }
      const double near = 1e-6 * (1 + rect.x1 - rect.x0 + rect.y1 - rect.y0);
      ASSERT_NEAR(seen.x0, rect.x0, near);
      ASSERT_NEAR(seen.y0, rect.y0, near);
      ASSERT_NEAR(seen.x1, rect.x1, near);
      ASSERT_NEAR(seen.y1, rect.y1, near);
      ++tight;
    }
  }
  EXPECT_GT(tight, 2000);
  EXPECT_GT(endless, 10) << "eyes inside the volume are meant to occur";
}

TEST(BoxOcclusion, aVolumeInFrontFillsTheMap) {
  Random random;
  for (int round = 0; round < 50; ++round) {
    const Vec3d direction = random.direction();
    const Vec3d middle = (kVolume.lo + kVolume.hi) / 2;
    const Vec3d eye = middle - direction * (150 / length(direction));
    for (const MapProjection& map :
         {parallelMap(kVolume, direction, 64), perspectiveMap(kVolume, eye, direction, 64)}) {
      const MapRect rect = project(map, kVolume);
      EXPECT_NEAR(rect.x0, 0, 1e-9);
      EXPECT_NEAR(rect.y0, 0, 1e-9);
      EXPECT_NEAR(rect.x1, 64, 1e-9);
      EXPECT_NEAR(rect.y1, 64, 1e-9);
    }
  }
}

TEST(BoxOcclusion, clippingLosesNothingVisible) {
  Random random;
  int culled = 0, clipped = 0, points = 0;
  for (int round = 0; round < 3000; ++round) {
    const MapProjection map = someMap(random, round);
    const RealBox box = random.boxIn(kVolume);
    MapRect visible{random.between(-5, 60), random.between(-5, 60), 0, 0};
    visible.x1 = visible.x0 + random.between(0.1, 20);
    visible.y1 = visible.y0 + random.between(0.1, 20);
    const std::optional<RealBox> rest = clip(map, box, visible);
    if (std::isinf(project(map, box).x0)) {
      ASSERT_TRUE(isWhole(rest, box)) << "nothing is known to hide it";
      continue;
    }
    culled += rest ? 0 : 1;
    clipped += rest && !isWhole(rest, box) ? 1 : 0;
    ASSERT_TRUE(!rest || (contains(box, rest->lo, 0) && contains(box, rest->hi, 0)));
    for (int k = 0; k < 200; ++k) {
      const Vec3d p = random.in(box);
      if (!contains(visible, pointOn(map, p), -1e-9)) continue;
      ASSERT_TRUE(rest) << "culled with a visible point";
      ASSERT_TRUE(contains(*rest, p, 1e-9));
      ++points;
    }
  }
  EXPECT_GT(culled, 300);
  EXPECT_GT(clipped, 300);
  EXPECT_GT(points, 10000);
}

TEST(BoxOcclusion, anEmptyRectangleCulls) {
  EXPECT_FALSE(clip(parallelMap(kVolume, {0, 0, 1}, 64), kVolume, {}));
}

// A parallel view straight along an axis: positions are map coordinates, scaled.
TEST(BoxOcclusion, aStraightViewOnlyScales) {
  const RealBox volume{{0, 0, 0}, {64, 32, 10}};
  const MapProjection map = parallelMap(volume, {0, 0, -2}, 64);
  EXPECT_EQ(map.axis, 2);
  EXPECT_EQ(map.plane, 0);
  EXPECT_EQ(project(map, {{8, 4, 1}, {16, 8, 9}}), (MapRect{8, 8, 16, 16}));
  const auto rest = clip(map, {{8, 4, 1}, {16, 8, 9}}, {12, 0, 64, 10});
  ASSERT_TRUE(rest);
  EXPECT_EQ(rest->lo, (Vec3d{12, 4, 1}));
  EXPECT_EQ(rest->hi, (Vec3d{16, 5, 9}));
}

}  // namespace
}  // namespace sluice
