// The incremental slicer against the plain one, and both against geometry that is known.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "src/render/camera/index_space.h"
#include "src/slicing/incremental_slicer.h"
#include "src/slicing/plain_slicer.h"

namespace sluice {
namespace {

constexpr double kTolerance_vox = 1e-4;

Vec3d toVec(const std::array<float, 3>& v) {
  return {v[0], v[1], v[2]};
}

std::vector<SliceVertex> verticesOf(const SliceList& list, const SlicePolygon& polygon) {
  const auto first = list.vertices.begin() + polygon.first;
  return {first, first + polygon.count};
}

Vec3d areaVector(const std::vector<SliceVertex>& polygon) {
  Vec3d sum;
  const Vec3d origin = toVec(polygon.front().position);
  for (size_t i = 1; i + 1 < polygon.size(); ++i)
    sum = sum +
          cross(toVec(polygon[i].position) - origin, toVec(polygon[i + 1].position) - origin) * 0.5;
  return sum;
}

bool isNear(const SliceVertex& a, const SliceVertex& b, double texture_scale) {
  return length(toVec(a.position) - toVec(b.position)) < kTolerance_vox &&
         length(toVec(a.texture) - toVec(b.texture)) < kTolerance_vox * texture_scale;
}

// Each vertex of one has its own in the other; the order is right by area and convexity.
void expectSame(const SlicePlanes& planes, const SlicedBox& box) {
  SliceList plain, fast;
  slicePlainly(planes, {&box, 1}, plain);
  sliceIncrementally(planes, {&box, 1}, fast);
  ASSERT_EQ(fast.polygons.size(), plain.polygons.size());
  const double scale = std::max({box.texture_scale.x, box.texture_scale.y, box.texture_scale.z});
  const Vec3d normal = normalized(planes.normal);
  for (size_t i = 0; i < plain.polygons.size(); ++i) {
    ASSERT_EQ(fast.polygons[i].slice, plain.polygons[i].slice);
    ASSERT_EQ(fast.polygons[i].count, plain.polygons[i].count)
        << "slice " << plain.polygons[i].slice;
    const auto expected = verticesOf(plain, plain.polygons[i]);
    auto found = verticesOf(fast, fast.polygons[i]);
    const Vec3d area = areaVector(found), expected_area = areaVector(expected);
    ASSERT_NEAR(dot(area, normal), dot(expected_area, normal), 1e-3 * (1 + length(expected_area)));
    for (const SliceVertex& vertex : found)
      ASSERT_NEAR(dot(planes.normal, toVec(vertex.position)),
                  planes.depthOfSlice(fast.polygons[i].slice),
                  kTolerance_vox * length(planes.normal));
    for (size_t j = 0; j < found.size(); ++j) {
      const Vec3d a = toVec(found[j].position), b = toVec(found[(j + 1) % found.size()].position),
                  c = toVec(found[(j + 2) % found.size()].position);
      ASSERT_LE(dot(cross(b - a, c - b), normal), 1e-3) << "turns to the other side";
    }
    for (const SliceVertex& vertex : expected) {
      const auto match = std::find_if(found.begin(), found.end(), [&](const SliceVertex& other) {
        return isNear(vertex, other, scale);
      });
      ASSERT_NE(match, found.end()) << "slice " << plain.polygons[i].slice;
      found.erase(match);
    }
  }
}

class Random {
 public:
  double unit() { return unit_(engine_); }
  double between(double lo, double hi) { return lo + (hi - lo) * unit(); }
  bool oneIn(int n) { return engine_() % static_cast<uint64_t>(n) == 0; }
  Vec3d direction() {
    Vec3d d;
    while (length(d) < 0.01) d = {between(-1, 1), between(-1, 1), between(-1, 1)};
    return d;
  }

 private:
  std::mt19937_64 engine_{11};
  std::uniform_real_distribution<double> unit_{0, 1};
};

TEST(Slicer, incrementalEqualsPlainOnRandomBoxesAndViews) {
  Random random;
  for (int round = 0; round < 4000; ++round) {
    SCOPED_TRACE(round);
    SlicePlanes planes;
    planes.normal = random.direction();
    planes.step = random.between(0.05, 3) * length(planes.normal);
    planes.first = random.between(-60, 10) * length(planes.normal);
    planes.first_slice = random.oneIn(3) ? static_cast<int64_t>(random.between(0, 80)) : 0;
    SlicedBox box;
    box.lo = {random.between(-9, 9), random.between(-9, 9), random.between(-9, 9)};
    box.hi =
        box.lo + Vec3d{random.between(0.5, 30), random.between(0.5, 30), random.between(0.5, 30)};
    box.texture_scale = {random.between(0.001, 2), random.between(0.001, 2),
                         random.between(0.001, 2)};
    box.texture_offset = random.direction();
    expectSame(planes, box);
    if (HasFatalFailure()) return;
  }
}

// Slices on faces, edges and corners: whole boxes, whole steps, views of small whole numbers.
TEST(Slicer, incrementalEqualsPlainOnDegenerateViews) {
  Random random;
  int slices_on_corners = 0;
  for (int x = -2; x <= 2; ++x)
    for (int y = -2; y <= 2; ++y)
      for (int z = -2; z <= 2; ++z) {
        if (x == 0 && y == 0 && z == 0) continue;
        for (const double step : {0.5, 1.0, 2.0}) {
          SCOPED_TRACE(fmt::format("view {} {} {} step {}", x, y, z, step));
          SlicePlanes planes;
          planes.normal = {static_cast<double>(x), static_cast<double>(y), static_cast<double>(z)};
          planes.step = step;
          planes.first = -100 - step / 2;  // slices at whole multiples of the step
          SlicedBox box;
          for (int a = 0; a < 3; ++a) {
            box.lo[a] = std::floor(random.between(-5, 5));
            box.hi[a] = box.lo[a] + std::ceil(random.between(0.1, 8));
          }
          const double depth = planes.depthOf(box.lo);
          slices_on_corners += std::fmod(depth, step) == 0 ? 1 : 0;
          expectSame(planes, box);
          if (HasFatalFailure()) return;
        }
      }
  EXPECT_GT(slices_on_corners, 100);
}

TEST(Slicer, almostStraightViewsAreEqualToo) {
  Random random;
  for (int round = 0; round < 2000; ++round) {
    SCOPED_TRACE(round);
    SlicePlanes planes;
    for (int a = 0; a < 3; ++a)
      planes.normal[a] = std::pow(10.0, random.between(-9, 0)) * (random.oneIn(2) ? 1 : -1);
    planes.step = length(planes.normal) * (random.oneIn(2) ? 1 : 0.37);
    planes.first = -20.5 * length(planes.normal);
    SlicedBox box{{0, 0, 0}, {7, 5, 9}, {1, 1, 1}, {0, 0, 0}};
    expectSame(planes, box);
    if (HasFatalFailure()) return;
  }
}

SlicePlanes through(Vec3d normal, double first, double step) {
  SlicePlanes planes;
  planes.normal = normal;
  planes.first = first;
  planes.step = step;
  return planes;
}

TEST(Slicer, theMiddleOfACubeIsARegularHexagon) {
  const SlicedBox box{{0, 0, 0}, {2, 2, 2}, {1, 1, 1}, {0, 0, 0}};
  const SlicePlanes planes = through({1, 1, 1}, 0, 6);  // slice 0 at x + y + z = 3
  for (const auto slice : {sliceIncrementally, slicePlainly}) {
    SliceList list;
    slice(planes, {&box, 1}, list);
    ASSERT_EQ(list.polygons.size(), 1U);
    EXPECT_EQ(list.polygons[0].count, 6U);
    EXPECT_NEAR(length(areaVector(list.vertices)), 3 * std::sqrt(3.0), 1e-5);
    for (const SliceVertex& vertex : list.vertices)
      EXPECT_NEAR(length(toVec(vertex.position) - Vec3d{1, 1, 1}), std::sqrt(2.0), 1e-6);
  }
}

// Slices times their distance fill the box.
TEST(Slicer, areasAddUpToTheVolume) {
  Random random;
  for (int round = 0; round < 50; ++round) {
    const Vec3d normal = normalized(random.direction());
    const SlicePlanes planes = through(normal, -50 + random.unit(), 0.02);
    const SlicedBox box{{1, 2, 3}, {6, 5, 10}, {1, 1, 1}, {0, 0, 0}};
    SliceList list;
    sliceIncrementally(planes, {&box, 1}, list);
    double filled = 0;
    for (const SlicePolygon& polygon : list.polygons) {
      const double area = -dot(areaVector(verticesOf(list, polygon)), normal);
      EXPECT_GE(area, -1e-4) << "counter-clockwise seen from the eye";
      filled += area * planes.step;
    }
    EXPECT_NEAR(filled, 105, 0.01 * 105);
  }
}

// Two halves and the whole: each slice has the same area, even if it lies in the face between.
TEST(Slicer, boxesThatShareAFaceShareEachSliceWithoutRest) {
  Random random;
  for (int round = 0; round < 500; ++round) {
    Vec3d normal = normalized(random.direction());
    if (round % 5 == 0) normal = {0, 0, round % 2 == 0 ? 1.0 : -1.0};
    const SlicePlanes planes = through(normal, -30.5, round % 2 == 0 ? 1 : random.between(0.1, 1));
    const SlicedBox whole{{0, 0, 0}, {8, 6, 9}, {1, 1, 1}, {0, 0, 0}};
    std::array<SlicedBox, 2> halves = {whole, whole};
    halves[0].hi.z = halves[1].lo.z = 4;
    const auto areas = [&](std::span<const SlicedBox> boxes) {
      SliceList list;
      sliceIncrementally(planes, boxes, list);
      std::vector<double> sums(600, 0);
      for (const SlicePolygon& polygon : list.polygons)
        sums.at(static_cast<size_t>(polygon.slice)) +=
            length(areaVector(verticesOf(list, polygon)));
      return sums;
    };
    const auto one = areas({&whole, 1}), two = areas(halves);
    for (size_t k = 0; k < one.size(); ++k)
      ASSERT_NEAR(one[k], two[k], 1e-3) << round << ", slice " << k;
  }
}

// Slice k lies (k + 1/2) steps from the eye-side corner of the volume, whatever the box.
TEST(Slicer, planesAreThoseOfTheView) {
  VolumeLayout layout;
  layout.dims = {31, 29, 23};
  layout.spacing = {1, 1.5, 0.75};
  layout.origin = {-3, 10, 5};
  for (const Projection projection : {Projection::kOrtho, Projection::kPerspective})
    for (const double azimuth : {0.0, 90.0, 33.0}) {
      Camera camera;
      camera.projection = projection;
      camera.azimuth_deg = azimuth;
      camera.elevation_deg = azimuth == 33 ? 20 : 0;
      const View view = resolve(camera, layout, {64, 64}, 0.5);
      const Vec3d origin{7, 3, 11};
      const SlicePlanes planes = slicePlanes(view, layout, origin);
      const SlicedBox box{{1, 2, 3}, {9, 8, 10}, {1, 1, 1}, {0, 0, 0}};
      SliceList list;
      sliceIncrementally(planes, {&box, 1}, list);
      ASSERT_GT(list.polygons.size(), 5U);
      for (const SlicePolygon& polygon : list.polygons)
        for (const SliceVertex& vertex : verticesOf(list, polygon)) {
          const Vec3d world = worldFromIndex(layout, toVec(vertex.position) + origin);
          const double depth = dot(world - view.eye, view.forward);
          EXPECT_NEAR((depth - view.first_depth) / view.step,
                      static_cast<double>(polygon.slice) + 0.5, 1e-4);
        }
    }
}

TEST(Slicer, nothingBehindThePerspectiveEye) {
  VolumeLayout layout;
  layout.dims = {32, 32, 32};
  Camera camera;
  camera.projection = Projection::kPerspective;
  camera.look_at = Camera::LookAt{{15, 15, 15}, {15, 15, 0}};
  const View view = resolve(camera, layout, {64, 64}, 1);
  const SlicedBox box{{0, 0, 0}, {31, 31, 31}, {1, 1, 1}, {0, 0, 0}};
  SliceList list;
  sliceIncrementally(slicePlanes(view, layout), {&box, 1}, list);
  ASSERT_FALSE(list.vertices.empty());
  for (const SliceVertex& vertex : list.vertices) EXPECT_LT(vertex.position[2], 15);
}

}  // namespace
}  // namespace sluice
