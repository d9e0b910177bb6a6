// Pictures of cuts through levels of resolution equal the levels' own, without a seam where levels
// meet.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "tests/render/level_scene.h"
#include "tests/support/function_source.h"

namespace sluice {
namespace {

// Clips off `margin` at each face of the volume: a level ends sooner than the volume does, beyond
// that the cut shows its outermost voxels. Requires: axes along the world's, a spacing of 1.
std::vector<WorldPlane> insidePlanes(const VolumeLayout& layout, double margin) {
  std::vector<WorldPlane> planes;
  for (int a = 0; a < 3; ++a) {
    Vec3d normal;
    normal[a] = 1;
    const double end = static_cast<double>(layout.dims[a] - 1) - margin;
    planes.push_back({normal, dot(layout.origin, normal) + end});
    planes.push_back({normal * -1.0, -dot(layout.origin, normal) - margin});
  }
  return planes;
}

// A level by itself is a volume: its own source, drawn from the same camera with the same slices.
// Its opacities apply to a length of its voxels there.
TEST_F(LevelCutTest, aLevelLooksLikeItsVoxelsAsAVolumeOfTheirOwn) {
  constexpr double kOpacity = 0.15, kThreshold = 30;
  const auto transferOf = [](double opacity) {
    TransferFunction transfer;
    transfer.colors = {{kThreshold, {0.2, 0.5, 1}}, {255, {1, 0.7, 0.1}}};
    transfer.opacities = {{kThreshold - 1e-6, 0}, {kThreshold, opacity}, {255, opacity}};
    return transfer;
  };
  const auto source = manyBlobs({90, 83, 77});
  for (const bool lit : {false, true}) {
    Pyramid pyramid(*source, 3, lit);
    const auto session = sessionOf(pyramid, transferOf(kOpacity), lit);
    for (const Projection projection : kProjections)
      for (const int level : {1, 2}) {
        FrameOptions options = obliqueView(projection);
        options.cut = CutOptions{.level = level};
        options.clip_planes = insidePlanes(source->layout(), 6);
        const Drawn drawn = draw(*session, options);
        ASSERT_TRUE(drawn.report.cut.has_value());
        ASSERT_EQ(drawn.report.cut->levels.size(), 1U);
        EXPECT_EQ(drawn.report.cut->levels[0].level, level);

        const double voxel = std::pow(2.0, level);
        ReferenceScene scene;
        scene.transfer = transferOf(1 - std::pow(1 - kOpacity, voxel));
        if (lit) {
          scene.lighting = options.lighting;
          scene.lighting->flat_share *= voxel;
        }
        scene.value_range = valueRangeOf(*source);
        for (const WorldPlane& plane : options.clip_planes)
          scene.clip_planes.push_back({plane.normal, plane.offset});
        const FloatPicture expected =
            renderReference(*pyramid.step.coarser[static_cast<size_t>(level) - 1].source,
                            viewOf(pyramid, options), scene);
        EXPECT_GT(shownShare(expected), 0.05);
        // Samples next to the threshold may fall on either side of it.
        EXPECT_LT(compare(drawn.picture, expected).mean_255, 0.05)
            << "level " << level << (lit ? ", lit" : "");
      }
  }
}

// Cells of a level lie half a voxel beside the regions of its blocks, so that a region may end
// within a cell of the next block.
TEST_F(LevelCutTest, aLevelLooksTheSameInBlocksOfAnySize) {
  const auto source = manyBlobs({96, 48, 104});
  Pyramid small(*source, 4, false, Spreads::kNone, 8), large(*source, 4, false, Spreads::kNone, 64);
  const TransferFunction transfer = opaqueAbove(60, 200, 0.9);
  const auto in_small = sessionOf(small, transfer), in_large = sessionOf(large, transfer);
  for (const Projection projection : kProjections)
    for (const int level : {1, 2, 3}) {
      FrameOptions options = obliqueView(projection);
      options.cut = CutOptions{.level = level};
      const FloatPicture expected = draw(*in_large, options).picture;
      EXPECT_GT(shownShare(expected), 0.005);
      EXPECT_TRUE(within(1, draw(*in_small, options).picture, expected)) << "level " << level;
    }
}

// Means of a linear function lie on it: a cut at any levels gives the picture of the finest one,
// even across the faces where levels meet.
TEST_F(LevelCutTest, levelsMeetWithoutASeamOnARamp) {
  for (const Spreads spreads : {Spreads::kNone, Spreads::kKept}) {
    FunctionSource ramp(functionLayout({100, 90, 80}, VoxelType::kF32), [](int64_t, Vec3i v) {
      return 0.3 * static_cast<double>(v.x) + 0.5 * static_cast<double>(v.y) +
             0.2 * static_cast<double>(v.z);
    });
    Pyramid pyramid(ramp, 4, false, spreads);
    TransferFunction transfer;
    transfer.colors = {{0, {0, 0, 1}}, {91, {1, 1, 0}}};
    transfer.opacities = {{0, 0.005}, {91, 0.03}};
    const auto session = sessionOf(pyramid, transfer);
    std::vector<FrameOptions> views{obliqueView(Projection::kOrtho),
                                    obliqueView(Projection::kOrtho),
                                    insideView(ramp.layout(), {0.2, 0.5, 0.5}, {0.9, 0.6, 0.5}),
                                    insideView(ramp.layout(), {0.5, 0.5, 0.9}, {0.4, 0.6, 0.1})};
    views[0].cut = CutOptions{.pixel_error = 0.01, .most_stored_bytes = 2'000'000};
    views[1].cut = CutOptions{.pixel_error = 0.01, .most_stored_bytes = 300'000};
    views[2].cut = CutOptions{.pixel_error = 3};
    views[3].cut = CutOptions{.pixel_error = 2};
    size_t mixed = 0;
    for (FrameOptions& options : views) {
      // Half a voxel of the coarsest level from the faces, where levels show their outermost
      // voxels.
      options.crop = Box3{{5, 5, 5}, {92, 82, 72}};
      const Drawn drawn = draw(*session, options);
      mixed += drawn.report.cut->levels.size() > 1 ? 1 : 0;
      EXPECT_GT(drawn.report.cut->coarse_share, 0.05);
      options.cut.reset();
      const Drawn finest = draw(*session, options);
      EXPECT_FALSE(finest.report.cut.has_value());
      EXPECT_GT(shownShare(finest.picture), 0.1);
      EXPECT_TRUE(within(1, drawn.picture, finest.picture)) << "view " << (&options - views.data());
    }
    EXPECT_EQ(mixed, views.size());
  }
}

TEST_F(LevelCutTest, everyAlgorithmAndOcclusionDrawsTheSameCut) {
  for (const Spreads spreads : {Spreads::kNone, Spreads::kKept}) {
    const auto source = manyBlobs({120, 101, 95});
    Pyramid pyramid(*source, 4, false, spreads);
    const auto session = sessionOf(pyramid, opaqueAbove(30, 200, 0.8));
    FrameOptions options = insideView(source->layout(), {0.2, 0.5, 0.5}, {0.9, 0.6, 0.5});
    options.cut = CutOptions{.pixel_error = 3};
    const Drawn expected = draw(*session, options);
    EXPECT_GE(expected.report.cut->levels.size(), 3U);
    EXPECT_GT(shownShare(expected.picture), 0.1);
    for (const Algorithm algorithm : kAlgorithms)
      for (const Occlusion occlusion : {Occlusion::kOff, Occlusion::kClip}) {
        options.algorithm = algorithm;
        options.occlusion = occlusion;
        options.opacity_threshold = 1;
        EXPECT_TRUE(within(1, draw(*session, options).picture, expected.picture))
            << name(algorithm);
      }
  }
}

// Two values by turns: their expected look shows values beyond both, where the finest level shows
// nothing.
TEST_F(LevelCutTest, everyAlgorithmEndsLevelsWithSpreadsAtTheSameBoxes) {
  FunctionSource source(functionLayout({60, 60, 60}, VoxelType::kU8), [](int64_t, Vec3i v) {
    const bool is_ball = length(toDouble(v) - Vec3d{18, 18, 18}) < 5;
    return is_ball ? 200.0 : (v.x + v.y + v.z) % 2 * 100.0;
  });
  Pyramid pyramid(source, 2, false, Spreads::kKept);
  const auto session = sessionOf(pyramid, opaqueAbove(110, 200, 0.8));
  FrameOptions options = obliqueView(Projection::kOrtho);
  options.cut = CutOptions{.level = 1};
  const Drawn expected = draw(*session, options);
  EXPECT_GT(shownShare(expected.picture), 0.005);
  for (const Algorithm algorithm : kAlgorithms) {
    options.algorithm = algorithm;
    EXPECT_TRUE(within(1, draw(*session, options).picture, expected.picture)) << name(algorithm);
  }
}

}  // namespace
}  // namespace sluice
