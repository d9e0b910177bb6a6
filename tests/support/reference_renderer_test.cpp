// The reference renderer against answers that can be worked out on paper.
#include "tests/support/reference_renderer.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "tests/support/memory_source.h"
#include "tests/support/random_volume.h"

namespace sluice {
namespace {

constexpr double kTight = 1e-6;  // pictures are floats

// White of one opacity at every value.
TransferFunction constantOpacity(double opacity) {
  return {{{0, {1, 1, 1}}}, {{0, opacity}}, "constant"};
}

// A colour that tells the value: red rises from 0 at lo to 1 at hi; opaque from `threshold` on.
TransferFunction redRamp(double lo, double hi, double threshold) {
  return {{{lo, {0, 0, 0}}, {hi, {1, 0, 0}}}, {{threshold, 0}, {threshold, 1}}, "red"};
}

// Looks along -z from z = `eye_z`, +y up; orthographic, the picture spanning 2 * half_height.
View alongMinusZ(Vec3d center, double front_z, double half_height, PictureSize size) {
  View view;
  view.size = size;
  view.eye = {center.x, center.y, front_z + 10};
  view.right = {1, 0, 0};
  view.up = {0, 1, 0};
  view.forward = {0, 0, -1};
  view.half_height = half_height;
  view.first_depth = 10;
  return view;
}

ReferenceScene sceneOf(TransferFunction transfer, ReferenceMode mode = ReferenceMode::kComposite) {
  ReferenceScene scene;
  scene.transfer = std::move(transfer);
  scene.mode = mode;
  return scene;
}

auto uniformCube(int64_t n) {
  return makeMemorySource<uint8_t>({n, n, n}, [](auto...) { return 100; });
}

TEST(ReferenceRenderer, uniformCubeHasTheAnalyticOpacity) {
  const auto cube = uniformCube(17);
  View view = alongMinusZ({8, 8, 8}, 16, 12, {9, 9});
  for (const double step : {0.25, 0.5, 1.0, 2.0}) {
    view.step = step;
    const auto picture = renderReference(*cube, view, sceneOf(constantOpacity(0.1)));
    const double expected = 1 - std::pow(0.9, 16);  // 16 voxel lengths, whatever the step
    EXPECT_NEAR(picture.at(4, 4)[3], expected, kTight) << step;
    EXPECT_NEAR(picture.at(4, 4)[0], expected, kTight) << "premultiplied white";
    EXPECT_EQ(picture.at(0, 0)[3], 0) << "beside the cube";
  }
}

TEST(ReferenceRenderer, opacityUnitIsTheFinestSpacing) {
  VolumeLayout layout;
  layout.dims = {5, 5, 9};
  layout.spacing = {0.5, 1, 2};
  const auto source = makeMemorySource<float>(layout, [](auto...) { return 1; });
  const View view = alongMinusZ({1, 2, 8}, 16, 2.5, {5, 5});
  const auto picture = renderReference(*source, view, sceneOf(constantOpacity(0.02)));
  EXPECT_NEAR(picture.at(2, 2)[3], 1 - std::pow(0.98, 16 / 0.5), kTight);
}

TEST(ReferenceRenderer, perspectiveRaysAreLongerAwayFromTheCentre) {
  const auto cube = uniformCube(33);
  View view = alongMinusZ({16, 16, 16}, 32, std::tan(0.2), {21, 21});
  view.projection = Projection::kPerspective;
  view.eye = {16, 16, 32 + 40};
  view.first_depth = 40;
  const auto picture = renderReference(*cube, view, sceneOf(constantOpacity(0.05)));
  for (const int i : {10, 12, 14}) {
    const double u = (2 * (i + 0.5) / 21 - 1) * std::tan(0.2);
    const double way = 32 * std::sqrt(1 + u * u);  // enters in front, leaves at the back
    EXPECT_NEAR(picture.at(i, 10)[3], 1 - std::pow(0.95, way), kTight) << i;
  }
}

TEST(ReferenceRenderer, perspectiveTakesNothingBehindTheEye) {
  const auto cube = uniformCube(33);
  View view = alongMinusZ({16, 16, 16}, 32, std::tan(0.2), {3, 3});
  view.projection = Projection::kPerspective;
  view.eye = {16, 16, 12};
  view.first_depth = -20;
  const auto picture = renderReference(*cube, view, sceneOf(constantOpacity(0.05)));
  EXPECT_NEAR(picture.at(1, 1)[3], 1 - std::pow(0.95, 12), kTight);
}

TEST(ReferenceRenderer, compositesALinearRampSampleBySample) {
  const auto ramp =
      makeMemorySource<uint16_t>({4, 4, 11}, [](auto, auto, auto z) { return 10 * z; });
  const View view = alongMinusZ({1.5, 1.5, 0}, 10, 1, {1, 1});
  const TransferFunction transfer = {{{0, {0, 0, 1}}, {100, {1, 0, 0}}}, {{0, 0}, {100, 0.5}}, ""};
  double opacity = 0, red = 0, depth = 0;
  for (int k = 0; k < 10; ++k) {
    const double value = 100 - 10 * (k + 0.5);
    const double weight = (1 - opacity) * value / 200;
    red += weight * value / 100;
    depth += weight * (10 + k + 0.5);
    opacity += weight;
  }
  const auto picture = renderReference(*ramp, view, sceneOf(transfer));
  EXPECT_NEAR(picture.at(0, 0)[0], red, kTight);
  EXPECT_NEAR(picture.at(0, 0)[1], 0, kTight);
  EXPECT_NEAR(picture.at(0, 0)[2], opacity - red, kTight);
  EXPECT_NEAR(picture.at(0, 0)[3], opacity, kTight);
  EXPECT_NEAR(picture.depth[0], depth / opacity, 1e-5);
}

// This ramp is greatest where rays leave through a side face, between voxel planes.
TEST(ReferenceRenderer, extremesAreTakenWhereRaysPassSideFaces) {
  const auto ramp =
      makeMemorySource<float>(Vec3i{9, 9, 21}, [](auto x, auto, auto) { return 10 * x; });
  View view = alongMinusZ({4, 4, 10}, 20, 0.05, {3, 3});
  view.forward = normalized(Vec3d{0.3, 0, -1});
  view.right = normalized(Vec3d{1, 0, 0.3});
  view.eye = Vec3d{4.2, 4, 15.1} - view.forward * 30;
  view.first_depth = 20;
  for (const auto& [mode, expected] :
       {std::pair{ReferenceMode::kMaximum, 80.0}, {ReferenceMode::kMinimum, 42 - 4.9 * 3.0}}) {
    const auto picture = renderReference(*ramp, view, sceneOf(redRamp(0, 100, -1), mode));
    EXPECT_NEAR(picture.at(1, 1)[0], expected / 100, 1e-4);
  }
}

TEST(ReferenceRenderer, modesShowTheExtremesAndTheMeanOfARamp) {
  VolumeLayout layout;
  layout.dims = {3, 3, 11};
  layout.value_scale = 0.5;
  layout.value_offset = -20;
  // Values -20 + 5 z: planes at z = 10 ... 0 have 30 ... -20, samples at 9.5 ... 0.5 27.5 ...
  // -17.5.
  const auto ramp = makeMemorySource<int16_t>(layout, [](auto, auto, auto z) { return 10 * z; });
  const View view = alongMinusZ({1, 1, 0}, 10, 0.5, {1, 1});
  const auto red = [&](ReferenceMode mode, double threshold) {
    return renderReference(*ramp, view, sceneOf(redRamp(-100, 100, threshold), mode)).at(0, 0)[0];
  };
  EXPECT_NEAR(red(ReferenceMode::kMaximum, -50), (30.0 + 100) / 200, kTight);
  EXPECT_NEAR(red(ReferenceMode::kMinimum, -50), (-20.0 + 100) / 200, kTight);
  EXPECT_NEAR(red(ReferenceMode::kAverage, -50), (5.0 + 100) / 200, kTight);
  // Only planes of 5 ... 30, samples of 7.5 ... 27.5 are visible.
  EXPECT_NEAR(red(ReferenceMode::kMinimum, 5), (5.0 + 100) / 200, kTight);
  EXPECT_NEAR(red(ReferenceMode::kAverage, 5), (17.5 + 100) / 200, kTight);
}

TEST(ReferenceRenderer, modesAreTransparentWhereNothingIsVisible) {
  const auto cube = uniformCube(5);
  const View view = alongMinusZ({2, 2, 2}, 4, 1, {1, 1});
  for (const auto mode :
       {ReferenceMode::kMaximum, ReferenceMode::kMinimum, ReferenceMode::kAverage}) {
    const auto picture = renderReference(*cube, view, sceneOf(redRamp(0, 255, 101), mode));
    EXPECT_EQ(picture.at(0, 0)[3], 0);
    EXPECT_EQ(renderReference(*cube, view, sceneOf(redRamp(0, 255, 100), mode)).at(0, 0)[3], 1);
  }
}

TEST(ReferenceRenderer, interpolatesALinearFieldExactly) {
  const auto field = [](double x, double y, double z) { return 1 + 2 * x + 3 * y + 5 * z; };
  const auto source = makeMemorySource<float>({9, 9, 9}, field);
  View view = alongMinusZ({4, 4, 4}, 8, 3, {16, 16});
  view.step = 0.37;
  const auto picture =
      renderReference(*source, view, sceneOf(redRamp(0, 100, -1), ReferenceMode::kMaximum));
  for (const int i : {0, 5, 15}) {
    const double x = 4 + (2 * (i + 0.5) / 16 - 1) * 3, y = 4 + (1 - 2 * (3 + 0.5) / 16) * 3;
    EXPECT_NEAR(picture.at(i, 3)[0], field(x, y, 8) / 100, kTight);
  }
}

// A turn of the view about a volume is the same as a turn of the volume the other way.
TEST(ReferenceRenderer, turnedVolumeInATurnedViewGivesTheSamePicture) {
  BlobOptions options;
  options.dims = {20, 16, 12};
  options.spacing = {1, 1.5, 0.75};
  const auto blobs = makeSparseBlobs(options);
  View view = alongMinusZ({9, 11, 4}, 12, 12, {40, 30});
  view.step = 0.5;
  ReferenceScene scene = sceneOf({{{0, {0, 0, 1}}, {255, {1, 1, 0}}}, {{20, 0}, {255, 0.4}}, ""});
  scene.lighting = Lighting{};
  scene.value_range = {0, 200};
  const auto straight = renderReference(*blobs, view, scene);

  const double c = std::cos(0.7), s = std::sin(0.7);
  const auto turn = [&](Vec3d p) {
    const Vec3d q = {c * p.x + s * p.z, p.y, c * p.z - s * p.x};
    return Vec3d{q.x, c * q.y - s * q.z, s * q.y + c * q.z};
  };
  const Vec3d shift = {3, -4, 5};
  VolumeLayout layout = blobs->layout();
  for (Vec3d& axis : layout.axes) axis = turn(axis);
  layout.origin = turn(layout.origin) + shift;
  MemorySource turned(layout, {blobs->bytes().begin(), blobs->bytes().end()});
  view.eye = turn(view.eye) + shift;
  view.right = turn(view.right);
  view.up = turn(view.up);
  view.forward = turn(view.forward);
  const auto difference = compare(straight, renderReference(turned, view, scene));
  EXPECT_LT(difference.max_255, 0.01);
  EXPECT_GT(straight.at(20, 15)[3] + straight.at(10, 15)[3] + straight.at(28, 10)[3], 0.1f)
      << "there is something to see";
}

TEST(ReferenceRenderer, viewFromBehindMirrorsAMaximum) {
  BlobOptions options;
  options.dims = {21, 17, 13};
  const auto blobs = makeSparseBlobs(options);
  const auto scene = sceneOf(redRamp(0, 255, 1), ReferenceMode::kMaximum);
  View view = alongMinusZ({10, 8, 6}, 12, 9, {32, 32});
  const auto front = renderReference(*blobs, view, scene);
  view.eye = {10, 8, -10};
  view.right = {-1, 0, 0};
  view.forward = {0, 0, 1};
  const auto back = renderReference(*blobs, view, scene);
  double sum = 0;
  for (int j = 0; j < 32; ++j)
    for (int i = 0; i < 32; ++i) {
      EXPECT_NEAR(front.at(i, j)[0], back.at(31 - i, j)[0], 1e-5) << i << ' ' << j;
      sum += front.at(i, j)[0];
    }
  EXPECT_GT(sum, 10);
}

TEST(ReferenceRenderer, cropTakesTheCellsBetweenItsPlanes) {
  const auto cube = uniformCube(17);
  View view = alongMinusZ({8, 8, 8}, 16, 8, {16, 16});
  ReferenceScene scene = sceneOf(constantOpacity(0.1));
  scene.crop = Box3{{4, 0, 3}, {9, 17, 8}};  // x in [4, 8), z in [3, 7)
  const auto picture = renderReference(*cube, view, scene);
  // Pixel i looks at x = i + 1/2.
  for (int i = 0; i < 16; ++i)
    EXPECT_NEAR(picture.at(i, 8)[3], i >= 4 && i < 8 ? 1 - std::pow(0.9, 4) : 0, kTight) << i;
}

TEST(ReferenceRenderer, clipPlaneKeepsItsInside) {
  const auto cube = uniformCube(17);
  const View view = alongMinusZ({8, 8, 8}, 16, 8, {16, 16});
  ReferenceScene scene = sceneOf(constantOpacity(0.1));
  scene.clip_planes = {{{0, 0, 1}, 10}, {{-1, 0, 0}, -6}};  // z <= 10 and x >= 6
  const auto picture = renderReference(*cube, view, scene);
  for (int i = 0; i < 16; ++i)
    EXPECT_NEAR(picture.at(i, 8)[3], i >= 6 ? 1 - std::pow(0.9, 10) : 0, kTight) << i;
}

TEST(ReferenceRenderer, stopsAtTheOpacityThreshold) {
  const auto cube = uniformCube(17);
  const View view = alongMinusZ({8, 8, 8}, 16, 1, {1, 1});
  ReferenceScene scene = sceneOf(constantOpacity(0.1));
  scene.opacity_threshold = 0.5;  // 1 - 0.9^7 is the first to reach it
  EXPECT_NEAR(renderReference(*cube, view, scene).at(0, 0)[3], 1 - std::pow(0.9, 7), kTight);
}

// The gradient of a ramp is known everywhere; across the view, and with one light along an axis,
// each term of lighting.h can be written down.
TEST(ReferenceRenderer, lightsARampAsTheFormulaSays) {
  VolumeLayout layout;
  layout.dims = {9, 9, 2};
  layout.spacing = {2, 1, 1};
  const auto ramp = makeMemorySource<float>(layout, [](auto x, auto, auto) { return 6 * x; });
  View view = alongMinusZ({8, 4, 0.5}, 1, 1, {1, 1});
  ReferenceScene scene = sceneOf({{{0, {0.5, 0.25, 0}}}, {{0, 1}}, ""});
  Lighting lighting;
  lighting.shininess = 2;
  lighting.lights = {{{{0.6, 0, 0.8}, 0.9}, {{0, 1, 0}, 0.5}}};
  lighting.flat_share = 0.1;
  scene.lighting = lighting;
  scene.value_range = {0, 40};
  // Gradient (3, 0, 0): 6 a voxel, 2 wide. flat = 0.1 * 40 / 1.
  const double w = 9.0 / (9 + 16);
  const double cosine_h = 0.6 / std::sqrt(0.36 + 1.8 * 1.8);  // l + viewer = (0.6, 0, 1.8)
  const double shine = 0.2 * 0.9 * cosine_h * cosine_h;
  const double factor = 0.3 + 0.65 * 0.9 * 0.6;
  const auto pixel = renderReference(*ramp, view, scene).at(0, 0);
  EXPECT_NEAR(pixel[0], 0.5 * (1 - w) + w * (0.5 * factor + shine), kTight);
  EXPECT_NEAR(pixel[1], 0.25 * (1 - w) + w * (0.25 * factor + shine), kTight);
  EXPECT_NEAR(pixel[2], w * shine, kTight);
  EXPECT_NEAR(pixel[3], 1, kTight);
}

TEST(ReferenceRenderer, flatRegionsKeepTheirColourWhenLit) {
  const auto cube = uniformCube(9);
  const View view = alongMinusZ({4, 4, 4}, 8, 2, {2, 2});
  ReferenceScene scene = sceneOf(constantOpacity(0.3));
  scene.value_range = {0, 255};
  const auto plain = renderReference(*cube, view, scene);
  scene.lighting = Lighting{};
  EXPECT_EQ(compare(plain, renderReference(*cube, view, scene)).max_255, 0);
}

TEST(ReferenceRenderer, volumeOfOnePlaneHasNoCells) {
  const auto plane = makeMemorySource<uint8_t>({8, 8, 1}, [](auto...) { return 255; });
  const View view = alongMinusZ({4, 4, 0}, 0, 2, {2, 2});
  EXPECT_EQ(renderReference(*plane, view, sceneOf(constantOpacity(1))).at(1, 1)[3], 0);
}

TEST(ReferenceRenderer, infinityIsAFarValueAndNotANumberShowsNothing) {
  const float infinity = std::numeric_limits<float>::infinity();
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const View view = alongMinusZ({4, 4, 4}, 8, 0.1, {1, 1});  // a single ray through voxel (4, 4)
  const auto opacityOf = [&](float middle) {
    const auto source = makeMemorySource<float>({9, 9, 9}, [&](auto x, auto y, auto z) {
      return x == 4 && y == 4 && z == 4 ? middle : 0.5F;
    });
    ReferenceScene scene = sceneOf({{{0, {1, 1, 1}}}, {{0, 0.1}, {0.5, 0.1}, {1, 0.3}}, "three"});
    return renderReference(*source, view, scene).at(0, 0)[3];
  };
  // Eight samples half way between planes, two of which lie next to the voxel.
  EXPECT_NEAR(opacityOf(0.5F), 1 - std::pow(0.9, 8), kTight);
  EXPECT_NEAR(opacityOf(infinity), 1 - std::pow(0.9, 6) * std::pow(0.7, 2), kTight);
  EXPECT_NEAR(opacityOf(-infinity), 1 - std::pow(0.9, 8), kTight);
  EXPECT_NEAR(opacityOf(nan), 1 - std::pow(0.9, 6), kTight);
}

TEST(ReferenceRenderer, doubtIsWhatRoundingAtAStepOrAFaceMayChange) {
  const auto cube = uniformCube(9);
  const View view = alongMinusZ({4, 4, 4}, 8, 0.1, {1, 1});
  // All eight samples lie a quarter of a value below a step of 0.2.
  ReferenceScene scene = sceneOf({{{0, {1, 1, 1}}}, {{100.25, 0}, {100.25, 0.2}}, "step"});
  const auto doubt = [&] { return renderReference(*cube, view, scene).doubt[0]; };
  EXPECT_EQ(doubt(), 0) << "none, unless it is asked for";
  scene.rounding.step_value = 0.2;
  EXPECT_EQ(doubt(), 0) << "too far off";
  scene.rounding.step_value = 0.3;
  EXPECT_NEAR(doubt(), 8 * 0.2, kTight);
  scene.transfer.opacities = {{90, 0}, {100.25, 0.2}};
  EXPECT_EQ(doubt(), 0) << "a ramp is no step";

  // The nearest and the farthest sample lie half a voxel inside the faces.
  scene.transfer = constantOpacity(0.1);
  scene.rounding = {.face_vox = 0.4};
  EXPECT_EQ(doubt(), 0);
  scene.rounding.face_vox = 0.6;
  EXPECT_NEAR(doubt(), 0.1 + std::pow(0.9, 7) * 0.1 + std::pow(0.9, 8) * 0.1, kTight);

  // Modes: whether samples at an end of the visible values take part.
  for (const ReferenceMode mode :
       {ReferenceMode::kMaximum, ReferenceMode::kMinimum, ReferenceMode::kAverage}) {
    scene = sceneOf({{{0, {1, 1, 1}}}, {{100.25, 0}, {100.25, 0.2}}, "step"}, mode);
    EXPECT_EQ(doubt(), 0);
    scene.rounding.end_value = 0.2;
    EXPECT_EQ(doubt(), 0);
    scene.rounding.end_value = 0.3;
    EXPECT_EQ(doubt(), 1);
  }
}

}  // namespace
}  // namespace sluice
