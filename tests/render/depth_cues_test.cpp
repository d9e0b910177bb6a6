// Colours by depth, depth cueing, and rays whose samples are moved by noise: against the reference,
// for any blocks, and against what can be computed by hand.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <vector>

#include "src/device/pictures/blue_noise.h"
#include "src/render/camera/index_space.h"
#include "tests/render/blob_scene.h"
#include "tests/render/right_picture.h"

namespace sluice {
namespace {

class DepthCuesTest : public RightPictureTest {};

// Seen from above, straight down: the last slice of z is the nearest.
FrameOptions fromAbove(const VolumeLayout& layout, Mode mode) {
  FrameOptions options;
  options.size = {static_cast<int>(layout.dims.x), static_cast<int>(layout.dims.y)};
  const Vec3d center = worldFromIndex(layout, toDouble(layout.dims - Vec3i{1, 1, 1}) * 0.5);
  options.camera.look_at = Camera::LookAt{center + Vec3d{0, 0, 100}, center};
  options.camera.up = Vec3d{0, 1, 0};
  options.mode = mode;
  return options;
}

// From the first colour at the far face to the last at the near one.
TransferFunction redToBlue(double lo, double hi) {
  return {{{lo, {1, 0, 0}}, {hi, {0, 0, 1}}}, {{lo, 1}, {hi, 1}}, "red to blue"};
}

TEST_F(DepthCuesTest, theGreatestValueHasTheColourOfItsDepth) {
  for (const int64_t at : {0, 7, 20, 39, 40}) {
    const auto source = makeMemorySource<uint8_t>(
        Vec3i{16, 16, 41}, [&](int64_t, int64_t, int64_t z) { return z == at ? 200.0 : 30.0; });
    RenderScene scene(device(), *source, redToBlue(0, 250), {.block_vox = 8});
    const auto pixel = scene.draw(fromAbove(source->layout(), Mode::kDepthMip)).at(8, 8);
    const double bright = 200.0 / 250, near = static_cast<double>(at) / 40;
    EXPECT_NEAR(pixel[0], bright * (1 - near), 0.003) << at;
    EXPECT_NEAR(pixel[2], bright * near, 0.003) << at;
    EXPECT_EQ(pixel[3], 1);
  }
}

TEST_F(DepthCuesTest, ofEqualValuesTheNearestCounts) {
  // A flat part, in whose middle rounding must not choose.
  const auto source = makeMemorySource<uint8_t>(Vec3i{16, 16, 41}, [](int64_t, int64_t, int64_t z) {
    return z < 11 ? 1.0 : z < 31 ? 2 : 0;
  });
  for (const int64_t block : {8, 16, 64}) {
    RenderScene scene(device(), *source, redToBlue(0, 4), {.block_vox = block});
    for (const double step : {1.0, 0.3}) {
      FrameOptions options = fromAbove(source->layout(), Mode::kDepthMip);
      options.step_vox = step;
      const auto pixel = scene.draw(options).at(8, 8);
      EXPECT_NEAR(pixel[0], 0.5 * (1 - 30.0 / 40), 0.003) << block;
      EXPECT_NEAR(pixel[2], 0.5 * (30.0 / 40), 0.003) << block;
    }
  }
}

TEST_F(DepthCuesTest, coloursByDepthAreTheReferencePicture) {
  for (const VoxelType type : {VoxelType::kU8, VoxelType::kU16, VoxelType::kF32}) {
    const auto source = spacedBlobs(type);
    const ValueRange range = valueRangeOf(*source);
    for (const Projection projection : kProjections)
      for (const double step : {1.0, 0.4}) {
        SCOPED_TRACE(
            fmt::format("{} {} {}", static_cast<int>(type), static_cast<int>(projection), step));
        FrameOptions options = obliqueView(projection);
        options.mode = Mode::kDepthMip;
        options.step_vox = step;
        options.crop = Box3{{3, 4, 5}, {55, 46, 50}};
        expectRightPicture(*source, wholeRangeTransfer("turbo", range), options, options, false);
      }
  }
}

TEST_F(DepthCuesTest, cueingDarkensByTheDepth) {
  for (const int64_t at : {2, 20, 38}) {
    const auto source = makeMemorySource<uint8_t>(Vec3i{16, 16, 41}, [&](auto, auto, int64_t z) {
      return std::abs(z - at) < 2 ? 200.0 : 0.0;
    });
    TransferFunction transfer{{{0, {0, 1, 0}}}, {{90, 0}, {100, 1}}, "opaque"};
    RenderScene scene(device(), *source, transfer, {.block_vox = 8});
    FrameOptions options = fromAbove(source->layout(), Mode::kComposite);
    options.step_vox = 0.25;
    for (const double share : {0.0, 0.5, 1.0}) {
      options.depth_cueing = share;
      // Opaque from half a voxel before its upper face on.
      const double depth = (40 - (static_cast<double>(at) + 1.5)) / 40;
      EXPECT_NEAR(scene.draw(options).at(8, 8)[1], 1 - share * depth, 0.01) << at;
    }
  }
}

TEST_F(DepthCuesTest, cuedPicturesAreTheReferencePicture) {
  const auto source = spacedBlobs();
  TransferFunction surfaces = someTransfer();
  surfaces.surfaces = {{70, 0.4, {1, 0.5, 0}}, {130, 1, {0, 0.5, 1}}};
  TransferFunction ramp{
      {{0, {0.2, 0.1, 0.9}}, {200, {1, 0.9, 0.4}}}, {{30, 0}, {200, 0.3}}, "ramp"};
  for (const Projection projection : kProjections)
    for (const bool lit : {false, true}) {
      SCOPED_TRACE(fmt::format("projection {} lit {}", static_cast<int>(projection), lit));
      FrameOptions options = obliqueView(projection);
      options.depth_cueing = 0.8;
      expectRightPicture(*source, someTransfer(), options, options, lit);
      options.integrates = true;
      expectRightPicture(*source, ramp, options, options, lit);
      options.integrates = false;
      options.crop = Box3{{3, 4, 5}, {55, 46, 50}};
      expectRightPicture(*source, surfaces, options, options, true);
    }
}

// What shows may take a part of the volume's depth: its nearest part is bright, its farthest black.
TEST_F(DepthCuesTest, depthsAreThoseOfWhatShows) {
  const auto source = makeMemorySource<uint8_t>(
      Vec3i{16, 16, 41}, [](auto, auto, int64_t z) { return z >= 10 && z <= 20 ? 200.0 : 0.0; });
  const VolumeLayout& layout = source->layout();
  const auto shown = std::make_shared<const std::vector<Vec3d>>(
      std::vector{worldFromIndex(layout, {0, 0, 10}), worldFromIndex(layout, {15, 15, 20})});
  TransferFunction green{{{0, {0, 1, 0}}}, {{90, 0}, {100, 1}}, "opaque"};
  for (const int64_t block : {8, 16, 64}) {
    RenderScene scene(device(), *source, green, {.block_vox = block});
    FrameOptions options = fromAbove(layout, Mode::kComposite);
    options.step_vox = 0.25;
    options.depth_cueing = 1;
    // The upper face is the nearest; seen from below, the lower one.
    options.shown_points = shown;
    EXPECT_NEAR(scene.draw(options).at(8, 8)[1], 1, 0.06) << block;
    // A crop and a clip plane make another part the nearest.
    options.crop = Box3{{0, 0, 0}, {16, 16, 16}};
    EXPECT_NEAR(scene.draw(options).at(8, 8)[1], 1, 0.06) << block;
    options.crop.reset();
    options.clip_planes = {{{0, 0, 1}, worldFromIndex(layout, {0, 0, 15}).z}};
    EXPECT_NEAR(scene.draw(options).at(8, 8)[1], 1, 0.06) << block;
  }
  RenderScene maximum(device(), *source, redToBlue(0, 200), {.block_vox = 8});
  FrameOptions options = fromAbove(layout, Mode::kDepthMip);
  options.shown_points = shown;
  EXPECT_NEAR(maximum.draw(options).at(8, 8)[2], 1, 0.003);
  options.clip_planes = {{{0, 0, 1}, worldFromIndex(layout, {0, 0, 15}).z}};
  EXPECT_NEAR(maximum.draw(options).at(8, 8)[2], 1, 0.003);
}

TEST_F(DepthCuesTest, picturesOfShownDepthsAreTheReferencePicture) {
  const auto source = spacedBlobs();
  const VolumeLayout& layout = source->layout();
  FrameOptions options = obliqueView(kProjections[0]);
  options.shown_points = std::make_shared<const std::vector<Vec3d>>(
      std::vector{worldFromIndex(layout, {20, 18, 16}), worldFromIndex(layout, {40, 30, 35})});
  for (const Projection projection : kProjections) {
    options.camera.projection = projection;
    options.depth_cueing = 0.8;
    options.mode = Mode::kComposite;
    expectRightPicture(*source, someTransfer(), options, options, true);
    options.mode = Mode::kDepthMip;
    expectRightPicture(*source, wholeRangeTransfer("turbo", valueRangeOf(*source)), options,
                       options, false);
  }
}

TEST_F(DepthCuesTest, jitteredPicturesAreTheReferencePicture) {
  const auto source = spacedBlobs();
  TransferFunction ramp{
      {{0, {0.2, 0.1, 0.9}}, {200, {1, 0.9, 0.4}}}, {{30, 0}, {200, 0.3}}, "ramp"};
  for (const Projection projection : kProjections)
    for (const bool lit : {false, true})
      for (const double jitter : {0.4, 1.0}) {
        SCOPED_TRACE(fmt::format("projection {} lit {}", static_cast<int>(projection), lit));
        FrameOptions options = obliqueView(projection);
        options.jitter = jitter;
        options.depth_cueing = lit ? 0.7 : 0;
        expectRightPicture(*source, someTransfer(), options, options, lit);
        options.integrates = true;
        expectRightPicture(*source, ramp, options, options, lit);
      }
}

TEST_F(DepthCuesTest, noiseTakesTheStepsFromASlopingSheet) {
  // Slices that are farther from each other than the sheet is thick meet it or miss it by turns.
  const auto source = makeMemorySource<uint8_t>(Vec3i{64, 64, 24}, [](auto x, auto, auto z) {
    return std::max(0.0, 255 - 100 * std::abs(static_cast<double>(z) - 9 - x / 16.0));
  });
  TransferFunction sheet{{{0, {1, 1, 1}}}, {{100, 0}, {255, 0.5}}, "sheet"};
  RenderScene scene(device(), *source, sheet, {.block_vox = 16});
  FrameOptions options = fromAbove(source->layout(), Mode::kComposite);
  const auto drawn = [&](double step, double jitter) {
    options.step_vox = step;
    options.jitter = jitter;
    return scene.draw(options);
  };
  // The sheet looks alike everywhere: the greatest difference between columns of pixels.
  const auto unevenness = [&](const FloatPicture& picture) {
    double least = 1, most = 0;
    for (int x = 16; x < 48; x += 4) {
      double sum = 0;
      for (int j = 16; j < 48; ++j)
        for (int i = x; i < x + 4; ++i) sum += double{picture.at(i, j)[3]};
      least = std::min(least, sum / 128);
      most = std::max(most, sum / 128);
    }
    return most - least;
  };
  const double with_steps = unevenness(drawn(4, 0));
  EXPECT_GT(with_steps, 0.3);
  EXPECT_LT(unevenness(drawn(4, 1)), 0.2 * with_steps);
}

TEST(BlueNoise, isEvenlySpreadAndHasNoClouds) {
  const std::vector<float>& noise = blueNoise();
  constexpr int kSide = kBlueNoiseSide;
  std::vector<float> sorted = noise;
  std::ranges::sort(sorted);
  ASSERT_EQ(sorted.size(), size_t{kSide} * kSide);
  for (size_t i = 0; i < sorted.size(); ++i)
    ASSERT_NEAR(sorted[i], (static_cast<double>(i) + 0.5) / (kSide * kSide) - 0.5, 1e-6);
  // Means of 8 x 8 pixels: those of white noise deviate by sqrt(1 / 12) / 8.
  double squares = 0;
  for (int y = 0; y < kSide; ++y)
    for (int x = 0; x < kSide; ++x) {
      double sum = 0;
      for (int i = 0; i < 64; ++i)
        sum +=
            double{noise[static_cast<size_t>((y + i / 8) % kSide * kSide + (x + i % 8) % kSide)]};
      squares += sum / 64 * (sum / 64);
    }
  EXPECT_LT(std::sqrt(squares / (kSide * kSide)), 0.35 * std::sqrt(1.0 / 12) / 8);
}

}  // namespace
}  // namespace sluice
