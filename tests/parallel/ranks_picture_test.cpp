// Pictures of 1, 2, 4 and 7 ranks, whose blocks interleave along every ray, against one process's
// picture.
#include "src/classify/transfer/automatic_look.h"
#include "tests/parallel/rank_scene.h"
#include "tests/render/blob_scene.h"
#include "tests/support/plain_device.h"

namespace sluice {
namespace {

constexpr double kSame = 1;  // in 1/255

class RanksPicture : public RenderTest {
 protected:
  // Compares with a session's picture on its own device.
  static void expectSame(VolumeSource& source, const TransferFunction& transfer,
                         const SceneOptions& scene, const FrameOptions& options,
                         const DeviceMaker& maker = makeSuiteDevice) {
    RenderScene alone(device(), source, transfer, scene);
    const FloatPicture whole = alone.draw(options);
    EXPECT_GE(shownShare(whole), 0.05);
    for (const int ranks : {1, 2, 4, 7}) {
      SCOPED_TRACE(fmt::format("{} ranks", ranks));
      const FloatPicture parts = drawOnRanks(ranks, source, transfer, scene, options, maker);
      EXPECT_TRUE(within(kSame, whole, parts));
      if (options.with_depth) {
        EXPECT_TRUE(depthsWithin(1e-2, whole, parts));
      }
    }
  }
};

TEST_F(RanksPicture, compositeLitAndUnlit) {
  const auto source = spacedBlobs();
  for (const Projection projection : kProjections)
    for (const bool lit : {false, true}) {
      SCOPED_TRACE(fmt::format("projection {} lit {}", static_cast<int>(projection), lit));
      FrameOptions options = obliqueView(projection);
      options.with_depth = !lit;
      expectSame(*source, someTransfer(), {.block_vox = 8, .lit = lit}, options);
    }
}

TEST_F(RanksPicture, withShadows) {
  const auto source = spacedBlobs();
  FrameOptions options = obliqueView(Projection::kPerspective);
  options.lighting.shadows = 1;
  options.lighting.occlusion = 0.8;
  expectSame(*source, someTransfer(), {.block_vox = 8, .lit = true}, options);
}

TEST_F(RanksPicture, otherModes) {
  const auto source = spacedBlobs();
  for (const Projection projection : kProjections)
    for (const Mode mode :
         {Mode::kMip, Mode::kMinip, Mode::kAverage, Mode::kAttenuatedMip, Mode::kDepthMip}) {
      SCOPED_TRACE(fmt::format("projection {} mode {}", static_cast<int>(projection),
                               static_cast<int>(mode)));
      FrameOptions options = obliqueView(projection);
      options.mode = mode;
      expectSame(*source, someTransfer(), {.block_vox = 8}, options);
    }
}

TEST_F(RanksPicture, ofEveryType) {
  for (const VoxelType type : {VoxelType::kI16, VoxelType::kF32}) {
    const auto source = spacedBlobs(type);
    const ValueRange range = valueRangeOf(*source);
    const auto transfer =
        thresholdTransfer(range.lo + 0.2 * (range.hi - range.lo), range, 0.2, "viridis");
    for (const Mode mode : {Mode::kComposite, Mode::kMip}) {
      FrameOptions options = obliqueView(Projection::kOrtho);
      options.mode = mode;
      expectSame(*source, transfer, {.block_vox = 8}, options);
    }
  }
}

TEST_F(RanksPicture, denseAndOpaque) {
  const auto source = makeWhiteNoise({40, 44, 50}, VoxelType::kU8, 4);
  for (const double opacity : {0.02, 1.0})
    for (const Projection projection : kProjections)
      expectSame(*source, thresholdTransfer(20, {0, 255}, opacity, "turbo"), {.block_vox = 8},
                 obliqueView(projection));
}

TEST_F(RanksPicture, fromWithinTheVolume) {
  const auto source = makeWhiteNoise({40, 44, 50}, VoxelType::kU8, 5);
  FrameOptions options = insideView(source->layout(), {0.4, 0.6, 0.5}, {0.9, 0.2, 0.7});
  expectSame(*source, thresholdTransfer(60, {0, 255}, 0.1, "turbo"), {.block_vox = 8}, options);
}

TEST_F(RanksPicture, croppedClippedAndInGrowingBoxes) {
  const auto source = spacedBlobs();
  FrameOptions options = obliqueView(Projection::kPerspective);
  options.crop = Box3{{5, 3, 9}, {50, 44, 47}};
  options.clip_planes = {{{1, 0.3, 0.2}, 60}};
  expectSame(*source, someTransfer(), {.block_vox = 8}, options);
  options = obliqueView(Projection::kOrtho);
  options.partition = Partition::kBoxes;
  expectSame(*source, someTransfer(), {.block_vox = 16, .partition = Partition::kBoxes}, options);
}

// Each rank loads and draws every block of its own hands: each drew all blocks of the volume, so
// that opacities added up once for each rank.
TEST_F(RanksPicture, ofAlgorithmsThatLoadEveryBlock) {
  const auto source = spacedBlobs();
  for (const Algorithm algorithm : {Algorithm::kConventional, Algorithm::kClipped})
    for (const Mode mode : {Mode::kComposite, Mode::kMip, Mode::kAttenuatedMip, Mode::kAverage}) {
      SCOPED_TRACE(fmt::format("{} mode {}", name(algorithm), static_cast<int>(mode)));
      FrameOptions options = obliqueView(Projection::kPerspective);
      options.algorithm = algorithm;
      options.mode = mode;
      expectSame(*source, someTransfer(), {.block_vox = 8}, options);
      options.crop = Box3{{5, 3, 9}, {50, 44, 47}};
      expectSame(*source, someTransfer(), {.block_vox = 8}, options);
    }
}

TEST_F(RanksPicture, readsEachOfEveryBlockAtOneRank) {
  const auto source = spacedBlobs();
  for (const Algorithm algorithm : {Algorithm::kConventional, Algorithm::kClipped}) {
    FrameOptions options = obliqueView(Projection::kOrtho);
    options.algorithm = algorithm;
    RenderScene alone(device(), *source, someTransfer(), {.block_vox = 8});
    const uint64_t one = alone.frame(options).report.decoded_bytes;
    ASSERT_GT(one, 0U);
    for (const int ranks : {2, 3}) {
      std::atomic<uint64_t> all = 0;
      drawOnRanks(ranks, *source, someTransfer(), {.block_vox = 8}, options, makeSuiteDevice, 1,
                  [&](const FrameReport& report) { all += report.decoded_bytes; });
      EXPECT_EQ(all, one) << name(algorithm) << " on " << ranks << " ranks";
    }
  }
}

// A rank that has room for a few chunks alone takes its part in several goes.
TEST_F(RanksPicture, outOfCore) {
  const auto source = spacedBlobs();
  for (const Projection projection : kProjections)
    expectSame(*source, someTransfer(),
               {.block_vox = 8, .page_vox = {8, 8, 8}, .pages = 8, .memory_bytes = 2 << 20},
               obliqueView(projection));
}

TEST_F(RanksPicture, withOcclusion) {
  const auto source = makeWhiteNoise({40, 44, 50}, VoxelType::kU8, 6);
  FrameOptions options = obliqueView(Projection::kPerspective);
  options.occlusion = Occlusion::kClip;
  options.opacity_threshold = 1;
  expectSame(*source, thresholdTransfer(20, {0, 255}, 0.5, "turbo"), {.block_vox = 8}, options);
}

// A device that knows nothing of parts draws a layer after another.
TEST_F(RanksPicture, onADeviceOfWholePictures) {
  const auto source = blobs({30, 26, 28});
  const auto maker = [] { return std::make_unique<PlainDevice>(); };
  for (const Mode mode : {Mode::kComposite, Mode::kMip, Mode::kMinip, Mode::kAverage,
                          Mode::kAttenuatedMip, Mode::kDepthMip})
    for (const int64_t pages : {8, 1 << 12}) {
      SCOPED_TRACE(fmt::format("mode {} pages {}", static_cast<int>(mode), pages));
      FrameOptions options = obliqueView(Projection::kPerspective, {50, 37});
      options.mode = mode;
      options.with_depth = mode == Mode::kComposite;
      const SceneOptions scene{.block_vox = 8, .pages = pages};
      PlainDevice plain;
      RenderScene alone(plain, *source, someTransfer(), scene);
      const FloatPicture whole = alone.draw(options);
      for (const int ranks : {1, 3}) {
        const FloatPicture parts =
            drawOnRanks(ranks, *source, someTransfer(), scene, options, maker);
        EXPECT_TRUE(within(kSame, whole, parts)) << ranks;
        if (options.with_depth) {
          EXPECT_TRUE(depthsWithin(1e-2, whole, parts));
        }
      }
    }
}

}  // namespace
}  // namespace sluice
