// Surfaces at values: pictures against the reference, alone and with opacities, for any blocks; a
// sphere's radius and normals; no ray slips through between two blocks.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "src/render/session/planner.h"
#include "tests/render/blob_scene.h"
#include "tests/render/one_light.h"
#include "tests/render/right_picture.h"

namespace sluice {
namespace {

constexpr double kSurfaceTolerance = 2;

// Opacity 0 everywhere: surfaces alone show.
TransferFunction surfacesAlone(ValueRange range, std::vector<IsoSurface> surfaces) {
  TransferFunction transfer = pointsTransfer("viridis", range, {{range.lo, 0}});
  transfer.surfaces = std::move(surfaces);
  return transfer;
}

// A translucent surface around an almost opaque and an opaque one, not in order.
std::vector<IsoSurface> threeSurfaces(ValueRange range) {
  const auto at = [&](double share) { return range.lo + share * (range.hi - range.lo); };
  return {{at(0.63), 0.8, {1, 0.3, 0.1}}, {at(0.31), 0.35, {0.2, 0.9, 0.4}}, {at(0.84), 1}};
}

class SurfacesTest : public RightPictureTest {
 protected:
  void expectRightPicture(VolumeSource& source, const TransferFunction& transfer,
                          const FrameOptions& options, bool lit) {
    // The lengths between samples that a frame with surfaces has.
    FrameOptions of_reference = options;
    of_reference.step_vox = Planner::stepForSurfaces(resolve(options, source.layout()),
                                                     source.layout(), options.step_vox);
    RightPictureTest::expectRightPicture(source, transfer, options, of_reference, lit);
  }
};

TEST_F(SurfacesTest, giveTheReferencePictureAlone) {
  drawBlobsOfAllKinds([&](MemorySource& source, const FrameOptions& options, bool lit) {
    const ValueRange range = valueRangeOf(source);
    expectRightPicture(source, surfacesAlone(range, threeSurfaces(range)), options, lit);
  });
}

TEST_F(SurfacesTest, lieAtTheirPlaceWithinWhatOpacitiesShow) {
  for (const VoxelType type : {VoxelType::kU8, VoxelType::kF32}) {
    const auto source = spacedBlobs(type);
    const ValueRange range = valueRangeOf(*source);
    TransferFunction transfer = surfacesAlone(range, threeSurfaces(range));
    const auto at = [&](double share) { return range.lo + share * (range.hi - range.lo); };
    transfer.opacities = {{at(0.1), 0}, {at(0.3), 0.06}, {at(0.9), 0.5}};
    for (const bool lit : {false, true})
      for (const Projection projection : kProjections) {
        SCOPED_TRACE(fmt::format("{}, lit {}, projection {}", name(type), lit,
                                 static_cast<int>(projection)));
        expectRightPicture(*source, transfer, obliqueView(projection, {64, 60}), lit);
      }
    transfer.gradients = {{0.01 * range.hi, {{range.lo, 0.2}, {range.hi, 1}}},
                          {0.1 * range.hi, {{range.lo, 1}, {range.hi, 0.5}}}};
    expectRightPicture(*source, transfer, obliqueView(Projection::kOrtho, {64, 60}), true);
  }
}

// Slices are never farther apart than voxels: what a ray enters and leaves between two of them is
// missed, so that the background shows in spots along the rims of bodies.
TEST_F(SurfacesTest, aCoarseStepMissesNoMoreThanOneOfAVoxel) {
  const auto source = spacedBlobs(VoxelType::kU8);
  const ValueRange range = valueRangeOf(*source);
  for (const Projection projection : kProjections) {
    RenderScene scene(device(), *source, surfacesAlone(range, threeSurfaces(range)),
                      {.block_vox = 16, .lit = true});
    FrameOptions options = obliqueView(projection, {64, 60});
    options.step_vox = 1;
    const FloatPicture fine = scene.draw(options);
    options.step_vox = 3;
    EXPECT_EQ(scene.draw(options).rgba, fine.rgba);
  }
}

TEST_F(SurfacesTest, depthIsWhereTheRayMeetsThem) {
  const auto source = spacedBlobs(VoxelType::kU8);
  const ValueRange range = valueRangeOf(*source);
  FrameOptions options = obliqueView(Projection::kPerspective, {64, 60});
  options.with_depth = true;
  options.step_vox = 0.8;
  RenderScene scene(device(), *source, surfacesAlone(range, {{range.hi / 2, 1}}),
                    {.block_vox = 8, .lit = true});
  EXPECT_TRUE(depthsWithin(0.02, scene.draw(options), scene.reference(options)));
}

TEST_F(SurfacesTest, cropsAndClipPlanesCutThem) {
  const auto source = spacedBlobs(VoxelType::kU8);
  const ValueRange range = valueRangeOf(*source);
  FrameOptions options = obliqueView(Projection::kOrtho, {64, 60});
  options.crop = Box3{{12, 9, 8}, {52, 45, 48}};
  options.clip_planes = {{{0.3, -1, 0.2}, -2}};
  expectRightPicture(*source, surfacesAlone(range, threeSurfaces(range)), options, true);
}

TEST_F(SurfacesTest, noneIsNextToWhatIsNoNumber) {
  const float kNan = std::numeric_limits<float>::quiet_NaN();
  VolumeLayout layout;
  layout.dims = {26, 24, 22};
  const auto source = makeMemorySource<float>(layout, [&](int64_t x, int64_t y, int64_t z) {
    if (x > 17 && y > 12) return kNan;
    return static_cast<float>(0.5 + 0.4 * std::sin(static_cast<double>(x + 2 * y + z) / 6));
  });
  RenderScene scene(device(), *source, surfacesAlone({0.1, 0.9}, {{0.5, 1}}),
                    {.block_vox = 8, .ghost = true});
  const FrameOptions options = obliqueView(Projection::kOrtho, {64, 60});
  const FloatPicture drawn = scene.draw(options);
  EXPECT_TRUE(within(kSurfaceTolerance, drawn, scene.reference(options)));
  EXPECT_GE(shownShare(drawn), 0.2);
}

// Distances from a place off the middle, so that the surface of a radius is a sphere. Between
// voxels the interpolated distance is up to 1 / (4 * radius) too great, so a smaller sphere would
// be off by more than a hundredth of a voxel itself.
constexpr Vec3d kMiddle{39.4, 40.7, 38.1};
constexpr double kRadius = 33.3;
std::unique_ptr<MemorySource> distances() {
  VolumeLayout layout;
  layout.dims = {80, 80, 80};
  return makeMemorySource<float>(layout, [](int64_t x, int64_t y, int64_t z) {
    return static_cast<float>(length(
        Vec3d{static_cast<double>(x), static_cast<double>(y), static_cast<double>(z)} - kMiddle));
  });
}

TEST_F(SurfacesTest, aSphereHasItsRadiusAndItsNormalsFromAllSides) {
  const auto source = distances();
  RenderScene scene(device(), *source, surfacesAlone({0, 70}, {{kRadius, 1}}),
                    {.block_vox = 8, .lit = true});
  // The views are along an axis, from all eight octants, and from almost above and below.
  for (const auto& [azimuth, elevation] : {std::pair(0.0, 0.0),
                                           {37.0, 55.0},
                                           {120.0, 30.0},
                                           {205.0, 55.0},
                                           {290.0, 30.0},
                                           {37.0, -30.0},
                                           {120.0, -80.0},
                                           {205.0, -30.0},
                                           {290.0, -55.0},
                                           {0.0, 80.0}}) {
    FrameOptions options = obliqueView(Projection::kOrtho, {80, 80});
    options.camera.azimuth_deg = azimuth;
    options.camera.elevation_deg = elevation;
    options.with_depth = true;
    const View view = resolve(options.camera, source->layout(), options.size, 1);
    options.lighting = oneLight({1, 0, 0});
    const FloatPicture x = scene.draw(options);
    options.lighting = oneLight({0, 1, 0});
    const FloatPicture y = scene.draw(options);
    options.lighting = oneLight({0, 0, 1});
    const FloatPicture z = scene.draw(options);
    double worst_radius = 0, worst_angle = 0;
    int seen = 0;
    for (int j = 0; j < 80; ++j)
      for (int i = 0; i < 80; ++i) {
        if (!(x.at(i, j)[3] > 0.5F)) continue;
        const double u = 2 * (i + 0.5) / 80 - 1, v = 1 - 2 * (j + 0.5) / 80;
        const auto depth =
            static_cast<double>(x.depth[static_cast<size_t>(j) * 80 + static_cast<size_t>(i)]);
        const Vec3d at = view.eye + view.right * (u * view.half_height) +
                         view.up * (v * view.half_height) + view.forward * depth - kMiddle;
        worst_radius = std::max(worst_radius, std::abs(length(at) - kRadius));
        const auto across = [](double d) { return std::abs(d); };
        const Vec3d expected{across(dot(at, view.right)), across(dot(at, view.up)),
                             across(dot(at, view.forward))};
        const Vec3d found{static_cast<double>(x.at(i, j)[0]), static_cast<double>(y.at(i, j)[0]),
                          static_cast<double>(z.at(i, j)[0])};
        const double cosine = dot(normalized(expected), normalized(found));
        worst_angle = std::max(worst_angle, std::acos(std::min(cosine, 1.0)));
        ++seen;
      }
    EXPECT_GT(seen, 800);
    EXPECT_LT(worst_radius, 0.01) << azimuth << ", " << elevation;
    EXPECT_LT(worst_angle * 180 / std::numbers::pi, 1) << azimuth << ", " << elevation;
  }
}

// Pixels well inside an outline of opaque pixels that are not opaque.
int64_t holesIn(const FloatPicture& picture, const FloatPicture& whole) {
  int64_t holes = 0;
  for (size_t i = 3; i < picture.rgba.size(); i += 4)
    holes += whole.rgba[i] > 0.99F && picture.rgba[i] < 0.99F ? 1 : 0;
  return holes;
}

FrameOptions manyRays(double azimuth_deg) {
  FrameOptions options = obliqueView(Projection::kOrtho, {1024, 1024});
  options.camera.azimuth_deg = azimuth_deg;
  options.camera.zoom = 1.7;
  return options;
}

TEST_F(SurfacesTest, noRayOfAMillionSlipsThroughBetweenTwoBlocks) {
  const auto source = distances();
  const TransferFunction transfer = surfacesAlone({0, 70}, {{kRadius, 1}});
  RenderScene small(device(), *source, transfer, {.block_vox = 8, .ghost = true});
  RenderScene large(device(), *source, transfer, {.block_vox = 64, .ghost = true});
  const FrameOptions options = manyRays(33);
  EXPECT_EQ(holesIn(small.draw(options), large.draw(options)), 0);
}

// The surface lies on a plane of voxels, which is the face between blocks.
TEST_F(SurfacesTest, noRaySlipsThroughWhereTheSurfaceIsTheFaceOfBlocks) {
  const auto source =
      makeMemorySource<uint8_t>(Vec3i{33, 33, 33}, [](int64_t x, int64_t y, int64_t z) {
        return x < 10 || y < 10 || z < 10 ? 0.0 : 100.0 + (x == 20 ? 40.0 : 0.0);
      });
  // The slopes end at planes 10, the faces of blocks, with a plateau of exactly the surface's
  // value.
  const TransferFunction transfer = surfacesAlone({0, 255}, {{100, 1}});
  RenderScene small(device(), *source, transfer, {.block_vox = 8, .ghost = true});
  RenderScene large(device(), *source, transfer, {.block_vox = 64, .ghost = true});
  for (const double azimuth : {0.0, 33.0, 200.0}) {
    FrameOptions options = manyRays(azimuth);
    options.size = {512, 512};
    const FloatPicture whole = large.draw(options);
    EXPECT_GE(shownShare(whole), 0.2);
    EXPECT_EQ(holesIn(small.draw(options), whole), 0) << azimuth;
  }
}

TEST_F(SurfacesTest, aTranslucentSurfaceIsMetOnceAtAFace) {
  const auto source = distances();
  for (const double haze : {0.0, 0.02}) {
    TransferFunction transfer = surfacesAlone({0, 70}, {{kRadius, 0.4}});
    transfer.opacities = {{0, haze}, {70, haze}};
    RenderScene small(device(), *source, transfer, {.block_vox = 8, .ghost = true});
    RenderScene large(device(), *source, transfer, {.block_vox = 64, .ghost = true});
    const FrameOptions options = manyRays(33);
    const FloatPicture a = small.draw(options), b = large.draw(options);
    int64_t differ = 0;
    for (size_t pixel = 0; pixel < a.rgba.size() / 4; ++pixel)
      differ += difference255(a.rgba, b.rgba, pixel) > 1 ? 1 : 0;
    EXPECT_EQ(differ, 0) << "of a million; haze " << haze;
  }
}

TEST_F(SurfacesTest, blocksThatNoneCrossesAreNotDrawn) {
  const auto source = makeMemorySource<uint8_t>(
      Vec3i{57, 17, 17}, [](int64_t x, int64_t, int64_t) { return static_cast<double>(4 * x); });
  RenderScene scene(device(), *source, surfacesAlone({0, 255}, {{82, 1}}),
                    {.block_vox = 8, .ghost = true});
  const Frame frame = scene.frame(obliqueView(Projection::kOrtho, {64, 60}));
  // Value 82 lies between planes 20 and 21, in the fifth block along x; the fourth is next to it.
  ASSERT_FALSE(frame.blocks->blocks.empty());
  for (const ObjectBlock& block : frame.blocks->blocks) {
    EXPECT_GE(block.cells.hi.x, 20);
    EXPECT_LE(block.cells.lo.x, 22);
  }
  EXPECT_LT(static_cast<int64_t>(frame.blocks->blocks.size()),
            scene.ranges().layout.blockCount() / 5);
}

}  // namespace
}  // namespace sluice
