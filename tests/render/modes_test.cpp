// Maximum and minimum against plain loops over the voxels, and other modes against the reference.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "src/classify/transfer/transfer_makers.h"
#include "src/render/camera/index_space.h"
#include "tests/gl/test_device.h"
#include "tests/render/render_scene.h"
#include "tests/support/random_volume.h"

namespace sluice::modes_test {
namespace {

// Software GL against a renderer in double precision.
constexpr double kOfReference = 1.5;

class ModesTest : public RenderTest {};

// Looks along an axis, up or down it, so that each pixel's ray runs through a row of voxels.
FrameOptions alongAxis(const VolumeLayout& layout, int axis, bool from_above) {
  const int up = axis == 1 ? 2 : 1, right = 3 - axis - up;
  FrameOptions options;
  options.size = {static_cast<int>(layout.dims[right]), static_cast<int>(layout.dims[up])};
  const Vec3d center = worldFromIndex(layout, toDouble(layout.dims - Vec3i{1, 1, 1}) * 0.5);
  Camera::LookAt look;
  look.target = look.eye = center;
  look.eye[axis] += from_above ? 100 : -100;
  Vec3d upwards;
  upwards[up] = 1;
  options.camera.look_at = look;
  options.camera.up = upwards;
  const View whole = resolve(options.camera, layout, options.size, 1);
  options.camera.zoom =
      whole.half_height / (0.5 * static_cast<double>(layout.dims[up]) * layout.spacing[up]);
  return options;
}

// The greatest or least voxel of the row that a pixel's ray runs through.
double extremeOfRow(const MemorySource& source, const View& view, int axis, int i, int j,
                    bool greatest) {
  const VolumeLayout& layout = source.layout();
  const double u = 2 * (i + 0.5) / view.size.width - 1, v = 1 - 2 * (j + 0.5) / view.size.height;
  const double aspect = static_cast<double>(view.size.width) / view.size.height;
  const Vec3d world =
      view.eye + view.right * (u * aspect * view.half_height) + view.up * (v * view.half_height);
  Vec3i at;
  for (int a = 0; a < 3; ++a) at[a] = std::llround(indexFromWorld(layout, world)[a]);
  double extreme = greatest ? -1 : 256;
  for (at[axis] = 0; at[axis] < layout.dims[axis]; ++at[axis]) {
    const auto index = static_cast<size_t>((at.z * layout.dims.y + at.y) * layout.dims.x + at.x);
    const auto voxel = static_cast<double>(std::to_integer<int>(source.bytes()[index]));
    extreme = greatest ? std::max(extreme, voxel) : std::min(extreme, voxel);
  }
  return extreme;
}

TEST_F(ModesTest, alongAnAxisTheExtremesAreThoseOfTheVoxels) {
  VolumeLayout layout;
  layout.dims = {22, 19, 17};
  for (const Vec3d spacing : {Vec3d{1, 1, 1}, Vec3d{1, 1, 2.5}, Vec3d{0.7, 0.7, 0.7}}) {
    layout.spacing = spacing;
    const auto noise = makeWhiteNoise(layout.dims, VoxelType::kU8, 4);
    MemorySource source(layout, {noise->bytes().begin(), noise->bytes().end()});
    RenderScene scene(device(), source, wholeRangeTransfer("grey", {0, 255}), {.block_vox = 8});
    for (int axis = 0; axis < 3; ++axis) {
      // Square pixels need square cells across the view.
      if (spacing.z != spacing.x && axis != 2) continue;
      for (const bool from_above : {false, true})
        for (const Mode mode : {Mode::kMip, Mode::kMinip})
          for (const double step : {1.0, 0.5, 3.0}) {
            SCOPED_TRACE(fmt::format("axis {} above {} mode {} step {}", axis, from_above,
                                     static_cast<int>(mode), step));
            FrameOptions options = alongAxis(layout, axis, from_above);
            options.mode = mode;
            options.step_vox = step;
            const View view = resolve(options.camera, layout, options.size, step);
            const FloatPicture drawn = scene.draw(options);
            const FloatPicture reference = scene.reference(options);
            double worst = 0, worst_of_reference = 0;
            for (int j = 0; j < options.size.height; ++j)
              for (int i = 0; i < options.size.width; ++i) {
                const double plain =
                    extremeOfRow(source, view, axis, i, j, mode == Mode::kMip) / 255;
                worst = std::max(worst, std::abs(drawn.at(i, j)[0] - plain));
                worst_of_reference =
                    std::max(worst_of_reference, std::abs(reference.at(i, j)[0] - plain));
              }
            EXPECT_LT(255 * worst, 0.1);
            EXPECT_LT(255 * worst_of_reference, 0.01);
          }
    }
  }
}

TEST_F(ModesTest, extremesFromAnywhereAreTheReferencePicture) {
  const auto noise = makeWhiteNoise({26, 21, 19}, VoxelType::kU8, 8);
  for (const int64_t block : {8, 32}) {
    RenderScene scene(device(), *noise, wholeRangeTransfer("grey", {0, 255}), {.block_vox = block});
    for (const Projection projection : kProjections)
      for (const Mode mode : {Mode::kMip, Mode::kMinip, Mode::kAverage, Mode::kAttenuatedMip})
        for (const double step : {1.0, 0.4}) {
          SCOPED_TRACE(fmt::format("projection {} mode {} step {}", static_cast<int>(projection),
                                   static_cast<int>(mode), step));
          FrameOptions options = obliqueView(projection);
          options.mode = mode;
          options.step_vox = step;
          EXPECT_TRUE(within(kOfReference, scene.draw(options), scene.reference(options)));
        }
  }
}

TEST_F(ModesTest, finerStepsOnlyAddToAMaximum) {
  const auto noise = makeWhiteNoise({26, 21, 19}, VoxelType::kU8, 8);
  RenderScene scene(device(), *noise, wholeRangeTransfer("grey", {0, 255}), {.block_vox = 8});
  FrameOptions options = obliqueView(Projection::kOrtho);
  options.mode = Mode::kMip;
  const FloatPicture coarse = scene.draw(options);
  options.step_vox = 0.25;
  const FloatPicture fine = scene.draw(options);
  for (size_t i = 0; i < coarse.rgba.size(); ++i) ASSERT_GE(fine.rgba[i], coarse.rgba[i] - 1e-4F);
}

TEST_F(ModesTest, samplesOfAMaximumAreThePlanesThatRaysMeet) {
  const auto noise = makeWhiteNoise({22, 19, 17}, VoxelType::kU8, 4);
  RenderScene scene(device(), *noise, wholeRangeTransfer("grey", {0, 255}), {.block_vox = 64});
  FrameOptions options = alongAxis(noise->layout(), 2, true);
  options.mode = Mode::kMip;
  options.count_samples = true;
  EXPECT_EQ(scene.frame(options).report.samples_drawn, 22U * 19U * 17U);
  options.step_vox = 0.5;
  EXPECT_EQ(scene.frame(options).report.samples_drawn, 22U * 19U * (2U * 16U + 1U));
}

// --- attenuated maximum

// Two slabs across z with nothing between them, of these values.
std::unique_ptr<MemorySource> twoSlabs(uint8_t nearer_top, uint8_t farther_down) {
  return makeMemorySource<uint8_t>(Vec3i{20, 20, 41}, [=](int64_t, int64_t, int64_t z) {
    return z >= 30 ? nearer_top : z <= 10 ? farther_down : uint8_t{0};
  });
}

// The value that shows where the slabs are seen from above, straight down.
double seenFromAbove(RenderScene& scene, const MemorySource& source, double step) {
  FrameOptions options = alongAxis(source.layout(), 2, true);
  options.mode = Mode::kAttenuatedMip;
  options.step_vox = step;
  return 255 * scene.draw(options).at(10, 10)[0];
}

TEST_F(ModesTest, aSlabDimsWhatIsBehindItByItsValueAndThickness) {
  const auto source = twoSlabs(51, 255);  // a fifth of the brightest, and the brightest
  TransferFunction transfer = wholeRangeTransfer("grey", {0, 255});
  for (const double attenuation : {0.0, 0.1, 0.3, 1.0}) {
    transfer.attenuation = attenuation;
    RenderScene scene(device(), *source, transfer, {.block_vox = 8});
    // Values are interpolated between the slabs and nothing: the upper one counts as 10.5 voxel
    // lengths of a fifth, and half a voxel length of the lower one lies before its face.
    const double dimmed = 255 * std::exp(-attenuation * (0.2 * 10.5 + 0.5));
    for (const double step : {1.0, 0.25}) {
      SCOPED_TRACE(fmt::format("attenuation {} step {}", attenuation, step));
      EXPECT_NEAR(seenFromAbove(scene, *source, step), std::max(51.0, dimmed), 2.5);
    }
  }
}

TEST_F(ModesTest, attenuatedMaximaAreTheSameInBlocksOfAnySize) {
  const auto noise = makeWhiteNoise({40, 33, 30}, VoxelType::kU16, 5);
  TransferFunction transfer = thresholdTransfer(20000, {0, 65535}, 1, "viridis");
  transfer.attenuation = 0.2;
  RenderScene whole(device(), *noise, transfer, {.block_vox = 64});
  for (const Projection projection : kProjections) {
    FrameOptions options = obliqueView(projection);
    options.mode = Mode::kAttenuatedMip;
    const FloatPicture picture = whole.draw(options);
    EXPECT_GT(shownShare(picture), 0.2);
    for (const int64_t block : {8, 16, 32}) {
      SCOPED_TRACE(fmt::format("block {}", block));
      RenderScene scene(device(), *noise, transfer, {.block_vox = block});
      EXPECT_TRUE(within(1, scene.draw(options), picture));
      EXPECT_TRUE(within(kOfReference, scene.draw(options), scene.reference(options)));
    }
  }
}

TEST_F(ModesTest, voxelsOfFloatsAndDescendingValuesAttenuateAlike) {
  // The device holds values of a negative scale the other way round.
  VolumeLayout layout;
  layout.dims = {24, 20, 18};
  for (const bool negative : {false, true}) {
    layout.value_scale = negative ? -2 : 2;
    layout.value_offset = negative ? 510 : 0;
    const auto noise = makeWhiteNoise(layout.dims, VoxelType::kU8, 8);
    MemorySource source(layout, {noise->bytes().begin(), noise->bytes().end()});
    TransferFunction transfer = wholeRangeTransfer("grey", {0, 510});
    transfer.attenuation = 0.2;
    RenderScene scene(device(), source, transfer, {.block_vox = 8});
    FrameOptions options = obliqueView(Projection::kOrtho);
    options.mode = Mode::kAttenuatedMip;
    EXPECT_TRUE(within(kOfReference, scene.draw(options), scene.reference(options)));
  }
  const auto floats = makeWhiteNoise({24, 20, 18}, VoxelType::kF32, 8);
  const ValueRange range = valueRangeOf(*floats);
  RenderScene scene(device(), *floats, wholeRangeTransfer("grey", range), {.block_vox = 8});
  FrameOptions options = obliqueView(Projection::kOrtho);
  options.mode = Mode::kAttenuatedMip;
  EXPECT_TRUE(within(kOfReference, scene.draw(options), scene.reference(options)));
}

// All values that show have the brightest colour, whatever entry lies next to the threshold.
TEST_F(ModesTest, aThresholdAboveTheRangeIsAsBrightAsTheMaximum) {
  const auto noise = makeWhiteNoise({24, 20, 18}, VoxelType::kU8, 8);
  VolumeLayout negative = noise->layout();
  negative.value_scale = -1;
  negative.value_offset = 255;
  MemorySource turned(negative, {noise->bytes().begin(), noise->bytes().end()});
  const auto floats = makeWhiteNoise({24, 20, 18}, VoxelType::kF32, 8);
  const double top = valueRangeOf(*floats).hi;
  FrameOptions options = obliqueView(Projection::kOrtho);
  for (const auto& [source, unit] : {std::pair<MemorySource*, double>(noise.get(), 1.0),
                                     {&turned, 1.0},
                                     {floats.get(), top / 255}})
    for (const double threshold : {149.5, 149.687, 149.999, 150.0}) {
      const ValueRange range{20 * unit, 60 * unit};
      RenderScene scene(device(), *source, thresholdTransfer(threshold * unit, range, 1, "grey"),
                        {.block_vox = 8});
      options.mode = Mode::kMip;
      const FloatPicture maximum = scene.draw(options);
      EXPECT_GT(shownShare(maximum), 0.1);
      for (const Mode mode : {Mode::kAttenuatedMip, Mode::kDepthMip}) {
        options.mode = mode;
        const FloatPicture picture = scene.draw(options);
        EXPECT_GT(shownShare(picture), 0.1);
        for (size_t i = 0; i < picture.rgba.size(); i += 4) {
          if (picture.rgba[i + 3] < 0.999F) continue;
          if (mode == Mode::kAttenuatedMip) {
            ASSERT_NEAR(picture.rgba[i], 1, 0.01) << threshold;
          }
          ASSERT_GT(picture.rgba[i + 1], 0.05) << threshold << ", mode " << static_cast<int>(mode);
        }
      }
    }
}

}  // namespace
}  // namespace sluice::modes_test
