// Framing: the visible part fills the picture, and keeps its place and scale across frames.
#include "src/render/camera/camera_framing.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "src/base/error.h"
#include "src/render/camera/index_space.h"
#include "tests/render/render_scene.h"

namespace sluice::camera_framing_test {
namespace {

constexpr PictureSize kWide{160, 90}, kHigh{60, 130}, kSquare{100, 100};

VolumeLayout layoutOf(Vec3i dims) {
  VolumeLayout layout;
  layout.dims = dims;
  return layout;
}

std::vector<Vec3d> pointsOf(const VolumeLayout& layout, std::initializer_list<Box3> boxes) {
  VisibleHull hull(layout);
  hull.add(std::vector<Box3>(boxes));
  return hull.points();
}

// How far the points reach in the picture, of half of it: 1 touches the edge.
struct Reach {
  double left = 0, right = 0, down = 0, up = 0;
  double most() const { return std::max({left, right, down, up}); }
};
Reach reachOf(std::span<const Vec3d> points, const Camera& camera, const VolumeLayout& layout,
              PictureSize size) {
  const View view = resolve(camera, layout, size, 1);
  const double aspect = static_cast<double>(size.width) / size.height;
  Reach reach{-9, -9, -9, -9};
  for (const Vec3d& point : points) {
    const Vec3d p = point - view.eye;
    const double scale =
        view.half_height * (view.projection == Projection::kPerspective ? dot(p, view.forward) : 1);
    const double u = dot(p, view.right) / (scale * aspect), v = dot(p, view.up) / scale;
    reach.left = std::max(reach.left, -u);
    reach.right = std::max(reach.right, u);
    reach.down = std::max(reach.down, -v);
    reach.up = std::max(reach.up, v);
  }
  return reach;
}

TEST(Framing, nothingVisibleHasNone) {
  const VolumeLayout layout = layoutOf({50, 50, 50});
  const std::vector<Camera> cameras(1);
  EXPECT_TRUE(pointsOf(layout, {}).empty());
  EXPECT_FALSE(framingOf({}, cameras, WorldFrame::kNone, kSquare).has_value());
}

TEST(Framing, theHullOfABoxIsItsEightCorners) {
  VolumeLayout layout = layoutOf({50, 50, 50});
  layout.axes[0] = {-1, 0, 0};
  layout.origin = {100, 0, 0};
  layout.spacing = {2, 1, 1};
  const std::vector<Vec3d> points = pointsOf(layout, {{{3, 4, 5}, {10, 20, 30}}});
  ASSERT_EQ(points.size(), 8U);
  for (const double x : {94.0, 80.0})
    for (const double y : {4.0, 20.0})
      for (const double z : {5.0, 30.0})
        EXPECT_NE(std::find(points.begin(), points.end(), Vec3d{x, y, z}), points.end());
}

TEST(Framing, theHullReachesAsFarAsTheBoxesDo) {
  const VolumeLayout layout = layoutOf({200, 200, 200});
  // A ball of blocks.
  VisibleHull hull(layout);
  std::vector<Vec3d> corners;
  for (int64_t z = 0; z < 200; z += 10)
    for (int64_t y = 0; y < 200; y += 10)
      for (int64_t x = 0; x < 200; x += 10) {
        if (length(toDouble({x, y, z}) - Vec3d{95, 95, 95}) > 90) continue;
        hull.add(std::vector<Box3>{{{x, y, z}, {x + 10, y + 10, z + 10}}});
        for (const int64_t dx : {0, 10})
          for (const int64_t dy : {0, 10})
            for (const int64_t dz : {0, 10}) corners.push_back(toDouble({x + dx, y + dy, z + dz}));
      }
  const std::vector<Vec3d> points = hull.points();
  EXPECT_LE(points.size(), 256U);
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  for (int i = 0; i < 500; ++i) {
    const Vec3d along = normalized({normal(random), normal(random), normal(random)});
    const auto farthest = [&](const std::vector<Vec3d>& of) {
      double far = -1e9;
      for (const Vec3d& p : of) far = std::max(far, dot(p - Vec3d{100, 100, 100}, along));
      return far;
    };
    EXPECT_LE(farthest(points), farthest(corners) + 1e-9);
    EXPECT_GT(farthest(points), 0.97 * farthest(corners));
  }
}

TEST(Framing, onePictureIsFilledAndCentred) {
  VolumeLayout layout = layoutOf({300, 200, 100});
  layout.frame = WorldFrame::kRas;
  layout.spacing = {1, 0.5, 2};
  layout.origin = {7, 8, 9};
  const std::vector<Vec3d> points =
      pointsOf(layout, {{{200, 10, 5}, {260, 60, 25}}, {{220, 60, 30}, {230, 90, 60}}});
  for (const Projection projection : kProjections)
    for (const ViewName view : {ViewName::kFront, ViewName::kTop, ViewName::kThreeQuarter})
      for (const PictureSize size : {kWide, kHigh, kSquare}) {
        Camera camera;
        camera.projection = projection;
        camera.view = view;
        camera.field_of_view_deg = 50;
        camera.framing = framingOf(points, std::span(&camera, 1), layout.frame, size);
        ASSERT_TRUE(camera.framing.has_value());
        const Reach reach = reachOf(points, camera, layout, size);
        EXPECT_LE(reach.most(), 0.96);
        EXPECT_GT(reach.most(), 0.85);
        EXPECT_NEAR(reach.left, reach.right, 0.03);
        EXPECT_NEAR(reach.up, reach.down, 0.03);
        const double filled = reach.most();
        camera.zoom = 2;
        EXPECT_NEAR(reachOf(points, camera, layout, size).most(), 2 * filled, 1e-6);
      }
}

TEST(Framing, aTurnKeepsOneScaleAndShowsAllInEachFrame) {
  const VolumeLayout layout = layoutOf({120, 60, 30});
  const std::vector<Vec3d> points = pointsOf(layout, {{{10, 10, 5}, {110, 40, 20}}});
  for (const Projection projection : kProjections) {
    std::vector<Camera> cameras(24);
    for (size_t i = 0; i < cameras.size(); ++i) {
      cameras[i].projection = projection;
      cameras[i].view = ViewName::kThreeQuarter;
      cameras[i].azimuth_deg = 15.0 * static_cast<double>(i);
    }
    const auto framing = framingOf(points, cameras, layout.frame, kWide);
    ASSERT_TRUE(framing.has_value());
    EXPECT_LT(length(framing->target - Vec3d{60, 25, 12.5}), 1e-9);
    double most = 0;
    for (Camera& camera : cameras) {
      camera.framing = framing;
      most = std::max(most, reachOf(points, camera, layout, kWide).most());
    }
    EXPECT_LE(most, 0.96);
    EXPECT_GT(most, 0.9);
  }
}

TEST(Framing, roomAtTheSidesStaysFree) {
  const VolumeLayout layout = layoutOf({50, 50, 50});
  const std::vector<Vec3d> points = pointsOf(layout, {{{10, 20, 5}, {40, 40, 20}}});
  for (const Projection projection : kProjections)
    for (const PictureSize size : {kWide, kHigh, kSquare}) {
      Camera camera;
      camera.projection = projection;
      camera.view = ViewName::kThreeQuarter;
      camera.framing = framingOf(points, std::span(&camera, 1), layout.frame, size, {0.2, 0.1});
      const Reach reach = reachOf(points, camera, layout, size);
      EXPECT_LT(reach.right, 0.6) << "a fifth of the width is two fifths of its half";
      EXPECT_LT(reach.down, 0.8);
      EXPECT_NEAR(reach.left - reach.right, 0.4, 0.04);
      EXPECT_NEAR(reach.up - reach.down, 0.2, 0.04);
      EXPECT_LT(std::max(reach.left, reach.up), 0.97);
    }
}

TEST(Framing, camerasThatSayWhereTheyStandAreLeftAlone) {
  const VolumeLayout layout = layoutOf({50, 50, 50});
  const std::vector<Vec3d> points = pointsOf(layout, {{{0, 0, 0}, {9, 9, 9}}});
  Camera camera;
  camera.look_at = Camera::LookAt{{0, 0, 90}, {0, 0, 0}};
  EXPECT_FALSE(framingOf(points, std::span(&camera, 1), layout.frame, kSquare).has_value());
}

TEST(Framing, refusesWhatAViewRefuses) {
  const VolumeLayout layout = layoutOf({50, 50, 50});
  const std::vector<Vec3d> points = pointsOf(layout, {{{0, 0, 0}, {9, 9, 9}}});
  Camera camera;
  camera.field_of_view_deg = 200;
  EXPECT_THROW(framingOf(points, std::span(&camera, 1), layout.frame, kSquare), Error);
  EXPECT_THROW(framingOf(points, std::span(&camera, 1), layout.frame, {0, 5}), Error);
}

class FramingPictureTest : public RenderTest {};

// A small cube in a corner of a large volume fills the picture, and its middle is in the middle.
TEST_F(FramingPictureTest, whatIsVisibleFillsThePictureOfTheRenderer) {
  VolumeLayout layout;
  layout.dims = {60, 60, 60};
  const auto source = makeMemorySource<uint8_t>(layout, [](int64_t x, int64_t y, int64_t z) {
    return x >= 40 && x < 50 && y >= 8 && y < 18 && z >= 20 && z < 30 ? 200.0 : 0.0;
  });
  const TransferFunction transfer{{{0, {1, 1, 1}}}, {{100, 0}, {100, 0.9}}, "cube"};
  RenderScene scene(device(), *source, transfer);
  VisibleHull hull(layout);
  hull.add(std::vector<Box3>{{{39, 7, 19}, {50, 18, 30}}});  // the cells around the cube
  FrameOptions options;
  options.size = {80, 80};
  for (const Projection projection : kProjections) {
    options.camera = {};
    options.camera.projection = projection;
    const std::vector<Vec3d> points = hull.points();
    options.camera.framing =
        framingOf(points, std::span(&options.camera, 1), layout.frame, options.size);
    const FloatPicture picture = scene.draw(options);
    int left = 80, right = -1, top = 80, bottom = -1;
    for (int j = 0; j < 80; ++j)
      for (int i = 0; i < 80; ++i) {
        if (picture.at(i, j)[3] < 0.5F) continue;
        left = std::min(left, i), right = std::max(right, i);
        top = std::min(top, j), bottom = std::max(bottom, j);
      }
    // The cube's cells reach up to a voxel beyond it.
    EXPECT_GT(right - left, 58);
    EXPECT_LT(right - left, 78);
    EXPECT_NEAR(left, 79 - right, 1);
    EXPECT_NEAR(top, 79 - bottom, 1);
  }
}

}  // namespace
}  // namespace sluice::camera_framing_test
