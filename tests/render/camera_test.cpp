// The camera's conventions, checked with numbers worked out by hand, and its errors.
#include "src/render/camera/camera.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "src/base/error.h"
#include "src/render/camera/camera_matrices.h"

namespace sluice::camera_test {
namespace {

using testing::HasSubstr;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr PictureSize kSquare{100, 100};

// Outer voxel centres from (0, 0, 0) to (2, 4, 4): the sphere around them has radius 3.
VolumeLayout box244() {
  VolumeLayout layout;
  layout.dims = {3, 5, 5};
  return layout;
}

View viewOf(const Camera& camera) {
  return resolve(camera, box244(), kSquare, 1);
}

void expectNear(Vec3d found, Vec3d expected, const char* what) {
  for (int a = 0; a < 3; ++a) EXPECT_NEAR(found[a], expected[a], 1e-12) << what << ", axis " << a;
}

std::string errorOf(const Camera& camera, PictureSize size = kSquare, double step_vox = 1) {
  try {
    resolve(camera, box244(), size, step_vox);
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

TEST(Camera, azimuthZeroLooksAlongMinusZWithYUp) {
  const View view = viewOf({});
  expectNear(view.forward, {0, 0, -1}, "forward");
  expectNear(view.up, {0, 1, 0}, "up");
  expectNear(view.right, {1, 0, 0}, "right");
  EXPECT_NEAR(view.eye.x, 1, 1e-12);
  EXPECT_NEAR(view.eye.y, 2, 1e-12);
  EXPECT_GT(view.eye.z, 4);
}

// The camera goes round +y by the right hand: at 90 degrees it stands on +x.
TEST(Camera, azimuthTurnsTheCameraAboutY) {
  Camera camera;
  camera.azimuth_deg = 90;
  View view = viewOf(camera);
  expectNear(view.forward, {-1, 0, 0}, "forward");
  expectNear(view.right, {0, 0, -1}, "right");
  camera.azimuth_deg = 180;
  view = viewOf(camera);
  expectNear(view.forward, {0, 0, 1}, "forward");
  expectNear(view.right, {-1, 0, 0}, "right");
  expectNear(view.up, {0, 1, 0}, "up");
}

TEST(Camera, elevationLiftsTheCamera) {
  Camera camera;
  camera.elevation_deg = 30;
  const View tilted = viewOf(camera);
  expectNear(tilted.forward, {0, -0.5, -std::sqrt(0.75)}, "forward");
  EXPECT_GT(tilted.eye.y, 4) << "above the volume";
  camera.elevation_deg = 90;
  const View above = viewOf(camera);
  expectNear(above.forward, {0, -1, 0}, "forward");
  expectNear(above.up, {0, 0, -1}, "up continues the way that it turned");
  expectNear(above.right, {1, 0, 0}, "right");
  camera.elevation_deg = -90;
  expectNear(viewOf(camera).up, {0, 0, 1}, "up");
}

TEST(Camera, zoomOneFitsTheSphereAroundTheOuterVoxelCentres) {
  Camera camera;
  EXPECT_NEAR(viewOf(camera).half_height, 3, 1e-12);
  camera.zoom = 2;
  EXPECT_NEAR(viewOf(camera).half_height, 1.5, 1e-12);
  // Wider than high: the height must fit. Higher than wide: the width.
  camera.zoom = 1;
  EXPECT_NEAR(resolve(camera, box244(), {200, 100}, 1).half_height, 3, 1e-12);
  EXPECT_NEAR(resolve(camera, box244(), {100, 200}, 1).half_height, 6, 1e-12);
}

TEST(Camera, perspectiveSphereTouchesThePictureSEdge) {
  Camera camera;
  camera.projection = Projection::kPerspective;
  camera.field_of_view_deg = 60;
  const View view = viewOf(camera);
  EXPECT_NEAR(view.half_height, std::tan(M_PI / 6), 1e-12);
  // The picture's upper edge plane passes through the eye and touches the sphere.
  const double distance = length(view.eye - Vec3d{1, 2, 2});
  EXPECT_NEAR(distance * std::sin(M_PI / 6), 3, 1e-12);
}

TEST(Camera, slicesStartAtTheNearestCorner) {
  Camera camera;
  camera.azimuth_deg = 90;
  const View view = resolve(camera, box244(), kSquare, 0.5);
  EXPECT_NEAR(view.first_depth, view.eye.x - 2, 1e-12) << "the face x = 2 is nearest";
  EXPECT_EQ(view.step, 0.5);
}

TEST(Camera, stepIsInUnitsOfTheFinestSpacing) {
  VolumeLayout layout = box244();
  layout.spacing = {3, 0.5, 2};
  EXPECT_NEAR(resolve({}, layout, kSquare, 2).step, 1, 1e-12);
}

TEST(Camera, slicesThatASpacingMakesAreTheSpacingSFault) {
  VolumeLayout layout = box244();
  layout.spacing.z = 1e10;
  const auto message = [&](double step_vox) -> std::string {
    try {
      resolve({}, layout, kSquare, step_vox);
    } catch (const Error& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_THAT(message(1), HasSubstr("its spacing of 1 x 1 x 1e+10 makes "));
  EXPECT_THAT(message(1), HasSubstr("correct it with --spacing, or give --step "));
  layout.spacing = {1, 1, 1};
  EXPECT_THAT(message(1e-8), HasSubstr(": --step 1e-08: "));
}

TEST(Camera, orientedGridIsFittedInWorldSpace) {
  VolumeLayout layout = box244();
  layout.spacing = {2, 1, 1};
  layout.origin = {10, 20, 30};
  layout.axes = {{{0, 0, 1}, {1, 0, 0}, {0, 1, 0}}};
  // Corners from (10, 20, 30) to (14, 24, 34): radius of a cube of 4.
  const View view = resolve({}, layout, kSquare, 1);
  EXPECT_NEAR(view.half_height, std::sqrt(12.0), 1e-12);
  EXPECT_NEAR(view.eye.x, 12, 1e-12);
  EXPECT_NEAR(view.eye.y, 22, 1e-12);
  EXPECT_NEAR(view.first_depth, view.eye.z - 34, 1e-12);
}

TEST(Camera, lookAtReplacesTheOrbit) {
  Camera camera;
  camera.projection = Projection::kPerspective;
  camera.azimuth_deg = 77;
  camera.look_at = Camera::LookAt{{5, 2, 2}, {1, 2, 2}};
  camera.up = Vec3d{0, 0, 3};
  const View view = viewOf(camera);
  expectNear(view.eye, {5, 2, 2}, "eye");
  expectNear(view.forward, {-1, 0, 0}, "forward");
  expectNear(view.up, {0, 0, 1}, "up");
  expectNear(view.right, {0, 1, 0}, "right");
  EXPECT_NEAR(view.first_depth, 3, 1e-12);
}

TEST(Camera, eyeInsideTheVolumeHasTheFirstSliceBehindIt) {
  Camera camera;
  camera.projection = Projection::kPerspective;
  camera.look_at = Camera::LookAt{{1, 2, 2}, {1, 2, 0}};
  EXPECT_NEAR(viewOf(camera).first_depth, -2, 1e-12);
}

std::array<double, 4> times(Vec3d p, const Matrix4& m) {
  std::array<double, 4> result{};
  for (size_t c = 0; c < 4; ++c)
    result[c] = p.x * m[c] + p.y * m[4 + c] + p.z * m[8 + c] + m[12 + c];
  return result;
}

// Against the rays that View promises, at all depths.
TEST(Camera, matricesTakeAPixelSRayToThePixel) {
  for (const Projection projection : {Projection::kOrtho, Projection::kPerspective}) {
    Camera camera;
    camera.projection = projection;
    camera.azimuth_deg = 33;
    camera.elevation_deg = -12;
    camera.zoom = 1.7;
    const View view = resolve(camera, box244(), {64, 48}, 0.5);
    for (const double depth : {view.first_depth, view.first_depth + 2.5})
      for (const auto& [i, j] : {std::pair{0, 0}, {63, 0}, {10, 40}, {63, 47}}) {
        const double u = 2 * (i + 0.5) / 64 - 1, v = 1 - 2 * (j + 0.5) / 48, a = 64.0 / 48;
        const Vec3d side =
            view.right * (u * a * view.half_height) + view.up * (v * view.half_height);
        const Vec3d p = projection == Projection::kOrtho ? view.eye + side + view.forward * depth
                                                         : view.eye + (view.forward + side) * depth;
        const auto ndc = times(p, ndcFromWorld(view));
        EXPECT_NEAR(ndc[0] / ndc[3], (i + 0.5) / 64, 1e-5);
        EXPECT_NEAR(ndc[1] / ndc[3], (j + 0.5) / 48, 1e-5);
        const auto seen = times(p, cameraFromWorld(view));
        EXPECT_NEAR(seen[2], depth, 1e-5);
        EXPECT_NEAR(seen[3], 1, 1e-12);
        EXPECT_NEAR(seen[0], dot(p - view.eye, view.right), 1e-5);
        EXPECT_NEAR(seen[1], dot(p - view.eye, view.up), 1e-5);
      }
  }
}

TEST(Camera, degenerateCamerasAreRefusedInOneLine) {
  EXPECT_THAT(errorOf({}, {0, 10}), HasSubstr("0 x 10"));
  EXPECT_THAT(errorOf({}, {10, -1}), HasSubstr("10 x -1"));
  for (const double bad : {0.0, -1.0, kNan, kInfinity}) {
    EXPECT_THAT(errorOf({}, kSquare, bad), HasSubstr("step")) << bad;
    Camera camera;
    camera.zoom = bad;
    EXPECT_THAT(errorOf(camera), HasSubstr("zoom")) << bad;
  }
  for (const double bad : {0.0, -30.0, 180.0, 400.0, kNan, kInfinity}) {
    Camera camera;
    camera.field_of_view_deg = bad;
    EXPECT_THAT(errorOf(camera), HasSubstr("field of view")) << bad;
  }
  Camera camera;
  camera.look_at = Camera::LookAt{{1, 1, 1}, {1, 1, 1}};
  EXPECT_THAT(errorOf(camera), HasSubstr("eye lies on its target"));
  camera.look_at = Camera::LookAt{{1, 1, 1}, {1, 5, 1}};
  EXPECT_THAT(errorOf(camera), HasSubstr("up direction"));
  camera.up = Vec3d{0, 0, 0};
  EXPECT_THAT(errorOf(camera), HasSubstr("up direction"));
  EXPECT_EQ(errorOf({}), "");
}

TEST(Camera, numbersThatAreNotFiniteAreNamed) {
  for (const double bad : {kNan, kInfinity, -kInfinity}) {
    Camera camera;
    camera.azimuth_deg = bad;
    EXPECT_THAT(errorOf(camera), HasSubstr("azimuth"));
    camera = {};
    camera.elevation_deg = bad;
    EXPECT_THAT(errorOf(camera), HasSubstr("elevation"));
    camera = {};
    camera.look_at = Camera::LookAt{{1, bad, 1}, {1, 5, 1}};
    EXPECT_THAT(errorOf(camera), HasSubstr("eye"));
    camera.look_at = Camera::LookAt{{1, 1, 1}, {1, 5, bad}};
    EXPECT_THAT(errorOf(camera), HasSubstr("target"));
    camera.look_at = Camera::LookAt{{1, 1, 1}, {1, 5, 1}};
    camera.up = Vec3d{bad, 0, 1};
    EXPECT_THAT(errorOf(camera), HasSubstr("up"));
  }
}

}  // namespace
}  // namespace sluice::camera_test
