// Pictures against the independent reference: algorithms, views, lighting, modes, steps, sizes.
#include <gtest/gtest.h>

#include <numbers>

#include "io/synth/synth_source.h"
#include "src/classify/transfer/transfer_makers.h"
#include "tests/render/render_scene.h"
#include "tests/support/random_volume.h"

namespace sluice::picture_test {
namespace {

// Tolerances in 1/255: to the reference, and to the unaccelerated picture.
constexpr double kOfReference = 2, kOfPlain = 1;

std::unique_ptr<MemorySource> blobs(VoxelType type = VoxelType::kU8) {
  BlobOptions options;
  options.type = type;
  options.blobs = 24;
  options.radius_vox = 9;
  return makeSparseBlobs(options);
}

TransferFunction blobTransfer(const VolumeSource& source) {
  const bool is_float =
      source.layout().type == VoxelType::kF32 || source.layout().type == VoxelType::kF64;
  const double top = source.layout().type == VoxelType::kU8   ? 200
                     : source.layout().type == VoxelType::kI8 ? 100
                     : is_float                               ? 200.0 / 255
                                                              : 0;
  return thresholdTransfer(0.2 * top, {0, top}, 0.2, "viridis");
}

using PictureTest = RenderTest;

TEST_F(PictureTest, everyAlgorithmGivesTheReferencePicture) {
  const auto source = blobs();
  for (const bool lit : {false, true})
    for (const Projection projection : kProjections) {
      RenderScene scene(device(), *source, blobTransfer(*source), {.lit = lit});
      FrameOptions options = obliqueView(projection);
      const FloatPicture reference = scene.reference(options);
      EXPECT_GT(shownShare(reference), 0.2);
      options.algorithm = Algorithm::kConventional;
      const FloatPicture plain = scene.draw(options);
      for (const Algorithm algorithm : kAlgorithms) {
        SCOPED_TRACE(fmt::format("{}, lit {}, projection {}", name(algorithm), lit,
                                 static_cast<int>(projection)));
        options.algorithm = algorithm;
        const FloatPicture drawn = scene.draw(options);
        EXPECT_TRUE(within(kOfReference, drawn, reference));
        EXPECT_TRUE(within(kOfPlain, drawn, plain));
      }
    }
}

TEST_F(PictureTest, perspectiveEyeMayBeInsideTheVolume) {
  const auto source = blobs();
  struct {
    Vec3d eye, target;
  } const views[] = {{{0.5, 0.5, 0.5}, {0.9, 0.6, 0.4}},
                     {{0.31, 0.62, 0.47}, {0.1, 0.2, 0.9}},
                     {{0.03, 0.5, 0.98}, {0.5, 0.45, 0.5}}};
  for (const bool lit : {false, true}) {
    RenderScene scene(device(), *source, blobTransfer(*source), {.block_vox = 8, .lit = lit});
    for (const auto& [eye, target] : views) {
      SCOPED_TRACE(fmt::format("eye at {} {} {}, lit {}", eye.x, eye.y, eye.z, lit));
      FrameOptions options = insideView(source->layout(), eye, target);
      options.step_vox = 0.5;
      const FloatPicture drawn = scene.draw(options);
      EXPECT_GT(shownShare(drawn), 0.2);
      EXPECT_TRUE(within(kOfReference, drawn, scene.reference(options)));
      options.algorithm = Algorithm::kConventional;
      EXPECT_TRUE(within(kOfPlain, drawn, scene.draw(options)));
    }
  }
}

TEST_F(PictureTest, eyeMayLieOnABlockFace) {
  const auto source = blobs();
  RenderScene scene(device(), *source, blobTransfer(*source), {.block_vox = 8});
  for (const Vec3d eye : {Vec3d{21, 14, 14}, Vec3d{21, 13.3, 14}, Vec3d{21, 13.3, 15.2}}) {
    FrameOptions options = insideView(source->layout(), {0, 0, 0}, {1, 1, 1});
    options.camera.look_at = Camera::LookAt{eye, {40, 15, 12}};
    EXPECT_TRUE(within(kOfReference, scene.draw(options), scene.reference(options)))
        << eye.x << " " << eye.y << " " << eye.z;
  }
}

TEST_F(PictureTest, axisAlignedAndDiagonalViews) {
  const auto source = blobs();
  RenderScene scene(device(), *source, blobTransfer(*source));
  struct {
    double azimuth, elevation;
  } const views[] = {{0, 0},   {90, 0},   {180, 0},   {270, 0},
                     {0, 90},  {0, -90},  {90, 90},   {180, 89},
                     {45, 0},  {135, 45}, {225, -45}, {45, 35.264389682754654},
                     {-90, 0}, {360, 0},  {720, 180}, {30, 135}};
  for (const Projection projection : kProjections)
    for (const auto& [azimuth, elevation] : views) {
      FrameOptions options = obliqueView(projection, {64, 64});
      options.camera.azimuth_deg = azimuth;
      options.camera.elevation_deg = elevation;
      const FloatPicture drawn = scene.draw(options);
      EXPECT_GT(shownShare(drawn), 0.2);
      EXPECT_TRUE(within(kOfReference, drawn, scene.reference(options)))
          << azimuth << " " << elevation << " projection " << static_cast<int>(projection);
    }
}

TEST_F(PictureTest, algorithmsAgreeInEveryOctantOfDirections) {
  const auto source = blobs();
  // A cache of two blocks, so that clusters are many and their order matters.
  RenderScene scene(device(), *source, blobTransfer(*source), {.block_vox = 8, .pages = 2});
  for (const Projection projection : kProjections)
    for (const double azimuth : {38.0, 127.0, 221.0, 310.0})
      for (const double elevation : {-41.0, 33.0}) {
        SCOPED_TRACE(fmt::format("azimuth {}, elevation {}, projection {}", azimuth, elevation,
                                 static_cast<int>(projection)));
        FrameOptions options = obliqueView(projection, {64, 56});
        options.camera.azimuth_deg = azimuth;
        options.camera.elevation_deg = elevation;
        options.algorithm = Algorithm::kConventional;
        const FloatPicture plain = scene.draw(options);
        EXPECT_GT(shownShare(plain), 0.2);
        EXPECT_TRUE(within(kOfReference, plain, scene.reference(options)));
        for (const Algorithm algorithm : kAlgorithms)
          for (const MergeOrder order : {MergeOrder::kPaper, MergeOrder::kFirstFit}) {
            options.algorithm = algorithm;
            options.merge_order = order;
            EXPECT_TRUE(within(kOfPlain, scene.draw(options), plain))
                << name(algorithm) << ", order of merges " << static_cast<int>(order);
          }
      }
}

TEST_F(PictureTest, stepsFromAQuarterOfAVoxelToSeveral) {
  const auto source = blobs();
  for (const bool lit : {false, true}) {
    RenderScene scene(device(), *source, blobTransfer(*source), {.lit = lit});
    for (const Projection projection : kProjections)
      for (const double step : {0.25, 1.0, 3.7, 40.0}) {
        FrameOptions options = obliqueView(projection, {64, 56});
        options.step_vox = step;
        EXPECT_TRUE(within(kOfReference, scene.draw(options), scene.reference(options)))
            << step << " projection " << static_cast<int>(projection) << " lit " << lit;
      }
  }
}

TEST_F(PictureTest, anyPictureSize) {
  const auto source = blobs();
  RenderScene scene(device(), *source, blobTransfer(*source));
  for (const Projection projection : kProjections)
    for (const PictureSize size :
         {PictureSize{1, 1}, {2, 1}, {1, 3}, {200, 17}, {13, 190}, {64, 64}, {1, 1}}) {
      const FrameOptions options = obliqueView(projection, size);
      const FloatPicture drawn = scene.draw(options);
      EXPECT_EQ(drawn.width, size.width);
      EXPECT_EQ(drawn.height, size.height);
      EXPECT_TRUE(within(kOfReference, drawn, scene.reference(options)))
          << size.width << " x " << size.height;
    }
}

TEST_F(PictureTest, blockAndPageSizesDoNotShow) {
  const auto source = blobs();
  FrameOptions options = obliqueView(Projection::kPerspective);
  struct {
    int64_t block;
    Vec3i page;
  } const geometries[] = {{4, {4, 4, 4}},     {8, {8, 8, 8}},   {16, {32, 16, 2}}, {32, {8, 16, 4}},
                          {64, {64, 32, 32}}, {8, {32, 64, 2}}, {16, {1, 1, 1}}};
  for (const bool lit : {false, true}) {
    std::optional<FloatPicture> first;
    for (const auto& [block, page] : geometries) {
      RenderScene scene(device(), *source, blobTransfer(*source),
                        {.block_vox = block, .page_vox = page, .pages = 1 << 12, .lit = lit});
      const FloatPicture drawn = scene.draw(options);
      if (!first) {
        first = scene.reference(options);
        EXPECT_TRUE(within(kOfReference, drawn, *first)) << block;
        first = drawn;
      }
      EXPECT_TRUE(within(kOfPlain, drawn, *first)) << block << " lit " << lit;
    }
  }
}

TEST_F(PictureTest, mipMinipAndAverageGiveTheReferencePicture) {
  const auto source = blobs();
  RenderScene scene(device(), *source, blobTransfer(*source));
  for (const Mode mode : {Mode::kMip, Mode::kMinip, Mode::kAverage})
    for (const Projection projection : kProjections) {
      SCOPED_TRACE(fmt::format("mode {}, projection {}", static_cast<int>(mode),
                               static_cast<int>(projection)));
      FrameOptions options = obliqueView(projection);
      options.mode = mode;
      const FloatPicture drawn = scene.draw(options);
      EXPECT_GT(shownShare(drawn), 0.2);
      EXPECT_TRUE(within(kOfReference, drawn, scene.reference(options)));
      options.algorithm = Algorithm::kConventional;
      EXPECT_TRUE(within(kOfPlain, drawn, scene.draw(options)));
    }
}

TEST_F(PictureTest, modesIgnoreLighting) {
  const auto source = blobs();
  RenderScene lit(device(), *source, blobTransfer(*source), {.lit = true});
  RenderScene unlit(device(), *source, blobTransfer(*source));
  FrameOptions options = obliqueView(Projection::kOrtho);
  options.mode = Mode::kMip;
  // Samples within kPlaneEdge of a face are moved onto it, and lit blocks have other faces.
  EXPECT_TRUE(within(0.5, lit.draw(options), unlit.draw(options)));
}

TEST_F(PictureTest, depthIsTheMeanDepthOfWhatShows) {
  const auto source = blobs();
  // Half precision of the target would show here: depths of some hundred voxels.
  constexpr double kTolerance = 0.02;  // voxels
  for (const Projection projection : kProjections) {
    RenderScene scene(device(), *source, blobTransfer(*source), {.block_vox = 8});
    FrameOptions options = obliqueView(projection);
    options.with_depth = true;
    const FloatPicture drawn = scene.draw(options), reference = scene.reference(options);
    EXPECT_TRUE(depthsWithin(kTolerance, drawn, reference)) << static_cast<int>(projection);
    EXPECT_TRUE(within(kOfReference, drawn, reference));
    EXPECT_TRUE(std::isinf(drawn.depth[0])) << "nothing in the corner";
    options.with_depth = false;
    EXPECT_TRUE(scene.draw(options).depth.empty());
  }
}

TEST_F(PictureTest, rayThatEndsEarlyLosesNoMoreThanItsThresholdSays) {
  const auto source = blobs();
  TransferFunction opaque = thresholdTransfer(40, {0, 200}, 0.9);
  for (const Projection projection : kProjections) {
    RenderScene scene(device(), *source, opaque, {.block_vox = 8});
    FrameOptions options = obliqueView(projection);
    const FloatPicture whole = scene.draw(options);
    options.count_samples = true;
    for (const double threshold : {0.5, 0.95, 0.99}) {
      options.opacity_threshold = threshold;
      const FloatPicture early = scene.draw(options);
      EXPECT_TRUE(within(255 * (1 - threshold) + 0.1, early, whole)) << threshold;
      EXPECT_TRUE(within(255 * (1 - threshold) + kOfReference, early, scene.reference(options)));
    }
    options.opacity_threshold = 0.5;
    EXPECT_FALSE(within(1, scene.draw(options), whole)) << "the threshold has no effect";
  }
}

TEST_F(PictureTest, threadsDoNotShow) {
  const auto source = blobs();
  std::optional<FloatPicture> first;
  for (const int threads : {1, 2, 5}) {
    RenderScene scene(device(), *source, blobTransfer(*source),
                      {.block_vox = 8, .threads = threads, .lit = true});
    const FloatPicture drawn = scene.draw(obliqueView(Projection::kPerspective));
    if (!first) first = drawn;
    EXPECT_EQ(drawn.rgba, first->rgba) << threads;
  }
}

TEST_F(PictureTest, syntheticVolumesOfEveryKind) {
  for (const SynthKind kind : synthKinds())
    for (const VoxelType type : {VoxelType::kU8, VoxelType::kU16, VoxelType::kF32}) {
      if (kSanitized && type == VoxelType::kU16) continue;  // the reference is slow under them
      const bool is_labels = kind == SynthKind::kParts;
      if (is_labels && type == VoxelType::kF32) continue;
      SynthOptions synth;
      synth.kind = kind;
      synth.dims = {45, 40, 50};
      synth.type = type;
      synth.spacing = {1, 1.5, 0.75};
      if (kind == SynthKind::kSparse)
        synth.object_share = 0.4;  // few balls fit into so small a one
      const auto source = openSynth(synth);
      const double top = is_labels                 ? 10
                         : type == VoxelType::kU8  ? 255
                         : type == VoxelType::kU16 ? 65535
                                                   : 1;
      const TransferFunction transfer = pointsTransfer("inferno", {0, top}, {{0, 0}, {top, 0.2}});
      for (const bool lit : {false, true}) {
        SCOPED_TRACE(fmt::format("{}, {}, lit {}", name(kind), name(type), lit));
        RenderScene scene(device(), *source, transfer, {.lit = lit});
        FrameOptions options =
            obliqueView(lit ? Projection::kOrtho : Projection::kPerspective, {72, 64});
        const FloatPicture drawn = scene.draw(options);
        EXPECT_GT(shownShare(drawn), 0.05);
        EXPECT_TRUE(within(kOfReference, drawn, scene.reference(options)));
        options.algorithm = Algorithm::kConventional;
        EXPECT_TRUE(within(kOfPlain, drawn, scene.draw(options)));
      }
    }
}

}  // namespace
}  // namespace sluice::picture_test
