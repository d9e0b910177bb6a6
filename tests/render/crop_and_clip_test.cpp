// Crop boxes and clip planes against the reference and the plain picture.
#include <gtest/gtest.h>

#include "src/classify/transfer/transfer_makers.h"
#include "src/render/camera/index_space.h"
#include "tests/render/render_scene.h"
#include "tests/support/random_volume.h"

namespace sluice {
namespace {

constexpr double kOfReference = 2, kOfPlain = 1;

// Dense, so that every part that is cut off is missed.
std::unique_ptr<MemorySource> dense(const VolumeLayout& layout) {
  return makeMemorySource<uint8_t>(layout, [](int64_t x, int64_t y, int64_t z) {
    return 60 + 3 * x + 2 * y + z + ((x ^ y ^ z) & 8);
  });
}

class CropAndClipTest : public RenderTest {
 protected:
  CropAndClipTest() {
    layout_.dims = {34, 30, 26};
    layout_.spacing = {1, 1.25, 0.8};
    layout_.axes = {{{0.36, 0.48, -0.8}, {-0.8, 0.6, 0}, {0.48, 0.64, 0.6}}};
    layout_.origin = {5, -3, 2};
    source_ = dense(layout_);
  }
  Vec3d center() const {
    return worldFromIndex(layout_, toDouble(layout_.dims - Vec3i{1, 1, 1}) * 0.5);
  }
  // Draws the options' picture and compares it with the reference, the plain and the whole one.
  FloatPicture expectRightPictures(const FrameOptions& asked, const std::string& what) {
    FloatPicture last;
    for (const bool lit : {false, true})
      for (const Projection projection : {Projection::kOrtho, Projection::kPerspective}) {
        SCOPED_TRACE(
            fmt::format("{}, lit {}, projection {}", what, lit, static_cast<int>(projection)));
        RenderScene scene(device(), *source_, transfer_, {.lit = lit});
        FrameOptions options = asked;
        options.camera.projection = projection;
        last = scene.draw(options);
        EXPECT_TRUE(within(kOfReference, last, scene.reference(options)));
        options.algorithm = Algorithm::kConventional;
        EXPECT_TRUE(within(kOfPlain, last, scene.draw(options)));
      }
    return last;
  }

  VolumeLayout layout_;
  std::unique_ptr<MemorySource> source_;
  TransferFunction transfer_ = thresholdTransfer(40, {0, 255}, 0.2, "viridis");
};

TEST_F(CropAndClipTest, cropBoxShowsWhatLiesBetweenItsOuterPlanes) {
  FrameOptions options = obliqueView(Projection::kOrtho, {64, 60});
  for (const Box3 crop : {Box3{{5, 6, 7}, {20, 19, 18}},
                          {{0, 0, 0}, {2, 30, 26}},
                          {{-10, -10, -10}, {90, 12, 90}},
                          {{0, 0, 0}, {34, 30, 26}},
                          {{40, 40, 40}, {50, 50, 50}}}) {
    options.crop = crop;
    const FloatPicture drawn = expectRightPictures(
        options, fmt::format("crop to {} {} {}", crop.hi.x, crop.hi.y, crop.hi.z));
    const Box3 left = intersect(crop, boxOf(layout_.dims));
    const bool has_cells = !left.empty() && left.size().x > 1;
    EXPECT_EQ(shownShare(drawn) > 0, has_cells);
  }
}

TEST_F(CropAndClipTest, aChangedCropTakesEffectInTheSameSession) {
  RenderScene scene(device(), *source_, transfer_);
  FrameOptions options = obliqueView(Projection::kOrtho, {64, 60});
  const FloatPicture whole = scene.draw(options);
  options.crop = Box3{{0, 0, 0}, {12, 30, 26}};
  const FloatPicture cropped = scene.draw(options);
  EXPECT_TRUE(within(kOfReference, cropped, scene.reference(options)));
  options.crop.reset();
  EXPECT_TRUE(within(0, scene.draw(options), whole));
}

TEST_F(CropAndClipTest, upToSixClipPlanes) {
  FrameOptions options = obliqueView(Projection::kOrtho, {64, 60});
  const Vec3d normals[] = {{1, 0.2, 0.1},  {-1, 0.1, 0.2}, {0.1, 1, -0.3},
                           {0.2, -2, 0.1}, {0.1, 0.2, 1},  {0, -0.1, -0.5}};
  for (const Vec3d& normal : normals) {
    options.clip_planes.push_back({normal, dot(normal, center()) + 5 * length(normal)});
    const FloatPicture drawn =
        expectRightPictures(options, fmt::format("{} planes", options.clip_planes.size()));
    EXPECT_GT(shownShare(drawn), 0.05);
  }
}

TEST_F(CropAndClipTest, clipPlanesAcrossAndAlongTheView) {
  // Axis-aligned planes and an axis-aligned view: rays lie in the planes or cross them squarely.
  for (const double azimuth : {0.0, 90.0})
    for (const Vec3d normal : {Vec3d{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 0, -1}}) {
      FrameOptions options = obliqueView(Projection::kOrtho, {64, 60});
      options.camera.azimuth_deg = azimuth;
      options.camera.elevation_deg = 0;
      // Between the slices, so that rounding decides nothing.
      options.clip_planes = {{normal, dot(normal, center()) + 0.3}};
      const FloatPicture drawn = expectRightPictures(
          options,
          fmt::format("azimuth {}, normal {} {} {}", azimuth, normal.x, normal.y, normal.z));
      EXPECT_GT(shownShare(drawn), 0.3);
    }
}

TEST_F(CropAndClipTest, planesThatKeepAllOrNothing) {
  FrameOptions options = obliqueView(Projection::kOrtho, {64, 60});
  RenderScene scene(device(), *source_, transfer_);
  const FloatPicture whole = scene.draw(options);
  options.clip_planes = {{{0, 0, 1}, 1e6}};
  EXPECT_TRUE(within(0.1, scene.draw(options), whole));
  options.clip_planes = {{{0, 0, 1}, -1e6}};
  EXPECT_EQ(shownShare(scene.draw(options)), 0);
}

TEST_F(CropAndClipTest, cropClipModesAndDepthTogether) {
  RenderScene scene(device(), *source_, transfer_, {.block_vox = 8});
  const Vec3d normal{0.3, -0.5, 0.8};
  for (const Mode mode : {Mode::kComposite, Mode::kMip, Mode::kMinip, Mode::kAverage,
                          Mode::kAttenuatedMip, Mode::kDepthMip}) {
    FrameOptions options = obliqueView(Projection::kPerspective, {64, 60});
    options.crop = Box3{{3, 4, 5}, {30, 26, 20}};
    options.clip_planes = {{normal, dot(normal, center())}};
    options.mode = mode;
    options.with_depth = mode == Mode::kComposite;
    const FloatPicture drawn = scene.draw(options), reference = scene.reference(options);
    EXPECT_TRUE(within(kOfReference, drawn, reference)) << static_cast<int>(mode);
    if (options.with_depth) {
      EXPECT_TRUE(depthsWithin(0.02, drawn, reference));
    }
  }
}

}  // namespace
}  // namespace sluice
