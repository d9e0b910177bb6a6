// Opacity by the gradient's magnitude: modulation and rows of factors over the plane of values and
// magnitudes, against the reference, over block borders and between partitions.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "tests/render/blob_scene.h"
#include "tests/render/real_volumes.h"

namespace sluice::gradient_test {
namespace {

constexpr double kOfReference = 2, kOfPlain = 1;
// Blocks for boxes to be smaller than.
constexpr SceneOptions kLargeBlocks{.block_vox = 32, .ghost = true, .partition = Partition::kBoxes};

// A cube of 200, `margin_vox` of zeros about it.
std::unique_ptr<MemorySource> cube(int64_t side_vox, int64_t margin_vox) {
  return makeMemorySource<uint8_t>(
      Vec3i{side_vox, side_vox, side_vox}, [=](int64_t x, int64_t y, int64_t z) {
        const auto inside = [=](int64_t i) { return i >= margin_vox && i < side_vox - margin_vox; };
        return inside(x) && inside(y) && inside(z) ? 200.0 : 0.0;
      });
}

TransferFunction above(double share, ValueRange range) {
  return thresholdTransfer(range.lo + share * (range.hi - range.lo), range, 0.3, "viridis");
}

TransferFunction modulated(double share, ValueRange range, double full_share = 0.1) {
  return modulateByGradient(above(share, range), full_share * (range.hi - range.lo));
}

// Some material between two values in flat regions, its boundary in steep ones: soft and hard sides
// in the plane.
TransferFunction plane(ValueRange range) {
  const double span = range.hi - range.lo;
  const auto at = [&](double share) { return range.lo + share * span; };
  TransferFunction transfer = pointsTransfer("turbo", range, {{at(0.05), 0}, {at(0.1), 0.3}});
  transfer.gradients = {{0.01 * span, {{at(0.5), 0}, {at(0.6), 0.4}, {at(0.8), 0.4}, {at(0.8), 0}}},
                        {0.04 * span, {{0, 0}}},
                        {0.12 * span, {{at(0.2), 0}, {at(0.3), 1}, {at(0.6), 0.5}}}};
  return transfer;
}

// More opaque in flatter regions.
TransferFunction flatAlone(ValueRange range) {
  TransferFunction transfer = above(0.2, range);
  const double span = range.hi - range.lo;
  transfer.gradients = {{0.02 * span, {{0, 1}}}, {0.15 * span, {{0, 0}}}};
  return transfer;
}

class GradientTest : public RenderTest {
 protected:
  // Lit and unlit, orthographic and perspective, steps that correct opacities and one that does
  // not: these take turns, so that three calls have all of them.
  void expectRightPicture(VolumeSource& source, const TransferFunction& transfer,
                          double least_shown = 0.05) {
    constexpr double kSteps[] = {1.0, 0.5, 2.3};
    for (const bool lit : {false, true})
      for (const Projection projection : kProjections) {
        const double step = kSteps[turn_++ % 3];
        SCOPED_TRACE(fmt::format("{}, lit {}, projection {}, step {}", transfer.name, lit,
                                 static_cast<int>(projection), step));
        RenderScene scene(device(), source, transfer, {.block_vox = 8, .lit = lit, .ghost = true});
        FrameOptions options = obliqueView(projection, {64, 60});
        options.step_vox = step;
        const FloatPicture drawn = scene.draw(options);
        EXPECT_GE(shownShare(drawn), least_shown);
        EXPECT_TRUE(within(kOfReference, drawn, scene.reference(options)));
        options.algorithm = Algorithm::kConventional;
        EXPECT_TRUE(within(kOfPlain, drawn, scene.draw(options)));
      }
  }

 private:
  size_t turn_ = 0;
};

TEST_F(GradientTest, modulationGivesTheReferencePicture) {
  for (const VoxelType type : {VoxelType::kU8, VoxelType::kI16, VoxelType::kF32}) {
    SCOPED_TRACE(name(type));
    const auto source = spacedBlobs(type);
    expectRightPicture(*source, modulated(0.3, valueRangeOf(*source)));
  }
}

TEST_F(GradientTest, rowsOverThePlaneGiveTheReferencePicture) {
  for (const VoxelType type : {VoxelType::kU8, VoxelType::kU16, VoxelType::kF32}) {
    SCOPED_TRACE(name(type));
    const auto source = spacedBlobs(type, 2);
    const ValueRange range = valueRangeOf(*source);
    expectRightPicture(*source, plane(range));
    expectRightPicture(*source, flatAlone(range), 0.02);
  }
}

TEST_F(GradientTest, modulationChangesThePictureAndFlatCoresVanish) {
  // A cube of one value: its faces show, its inside does not.
  const auto source = cube(24, 4);
  const TransferFunction thin = thresholdTransfer(60, {0, 200}, 0.05);
  RenderScene scene(device(), *source, modulateByGradient(thin, 50), {.ghost = true});
  FrameOptions options = obliqueView(Projection::kOrtho, {65, 65});
  options.camera.azimuth_deg = options.camera.elevation_deg = 0;
  const FloatPicture drawn = scene.draw(options);
  RenderScene plain(device(), *source, thin);
  const FloatPicture whole = plain.draw(options);
  EXPECT_GT(drawn.at(32, 32)[3], 0.05F) << "the two faces";
  EXPECT_LT(drawn.at(32, 32)[3], 0.6F * whole.at(32, 32)[3]) << "and nothing between them";
}

TEST_F(GradientTest, scaledValuesScaleTheirMagnitudes) {
  for (const double scale : {0.01, 3.0, -0.5}) {
    VolumeLayout layout;
    layout.dims = {30, 27, 24};
    layout.value_scale = scale;
    layout.value_offset = 7;
    layout.spacing = {2, 2.5, 3};
    const auto source = makeMemorySource<uint8_t>(layout, [](int64_t x, int64_t y, int64_t z) {
      return 127 + 60 * std::sin(static_cast<double>(x) / 3) +
             60 * std::cos(static_cast<double>(y + z) / 4);
    });
    expectRightPicture(*source, modulated(0.4, valueRangeOf(*source), 0.15));
  }
}

TEST_F(GradientTest, whatIsNoNumberHasNoGradient) {
  const float kNan = std::numeric_limits<float>::quiet_NaN();
  const float kInfinity = std::numeric_limits<float>::infinity();
  VolumeLayout layout;
  layout.dims = {26, 24, 22};
  const auto source = makeMemorySource<float>(layout, [&](int64_t x, int64_t y, int64_t z) {
    if (x > 17 && y > 12) return kNan;
    if (x == 5 && y == 6 && z == 7) return kInfinity;
    return static_cast<float>(0.5 + 0.4 * std::sin(static_cast<double>(x + 2 * y) / 6));
  });
  const TransferFunction transfer = modulated(0.3, {0.1, 0.9}, 0.1);
  expectRightPicture(*source, transfer);
  RenderScene scene(device(), *source, transfer, kLargeBlocks);
  EXPECT_TRUE(boxesDrawTheSame(scene, obliqueView(Projection::kPerspective, {64, 60})));
}

TEST_F(GradientTest, blockBordersDoNotShow) {
  const auto source = spacedBlobs(VoxelType::kU8, 3);
  const ValueRange range = valueRangeOf(*source);
  for (const bool lit : {false, true})
    for (const TransferFunction& transfer : {modulated(0.2, range), plane(range)}) {
      FrameOptions options = obliqueView(Projection::kPerspective);
      std::optional<FloatPicture> whole;
      for (const int64_t block : {64, 32, 8, 4})
        for (const int threads : {1, 4}) {
          SCOPED_TRACE(fmt::format("blocks of {}, {} threads, lit {}", block, threads, lit));
          RenderScene scene(device(), *source, transfer,
                            {.block_vox = block, .threads = threads, .lit = lit, .ghost = true});
          const FloatPicture drawn = scene.draw(options);
          if (!whole) whole = drawn;
          EXPECT_TRUE(within(0.25, drawn, *whole));
        }
    }
}

TEST_F(GradientTest, depthAndEarlyEndsCountWhatIsLeftOfTheOpacity) {
  const auto source = spacedBlobs(VoxelType::kU8, 4);
  RenderScene scene(device(), *source, modulated(0.2, valueRangeOf(*source)), {.ghost = true});
  for (const Projection projection : kProjections) {
    FrameOptions options = obliqueView(projection);
    options.step_vox = 0.7;
    options.with_depth = true;
    const FloatPicture drawn = scene.draw(options), reference = scene.reference(options);
    EXPECT_TRUE(depthsWithin(0.02, drawn, reference));
    EXPECT_TRUE(within(kOfReference, drawn, reference));
    options.opacity_threshold = 0.5;
    EXPECT_TRUE(within(127.6, scene.draw(options), drawn));
    EXPECT_FALSE(within(5, scene.draw(options), drawn)) << "the threshold has no effect";
  }
}

// Drawing every sample, against which benches measure skipping, gives the same picture.
TEST_F(GradientTest, samplesThatAreLeftOutShowNothing) {
  for (const VoxelType type : {VoxelType::kU8, VoxelType::kF32})
    for (const Projection projection : kProjections)
      for (const bool lit : {false, true}) {
        const auto source = spacedBlobs(type, 6);
        RenderScene scene(device(), *source, modulated(0.2, valueRangeOf(*source)),
                          {.lit = lit, .ghost = true});
        FrameOptions options = obliqueView(projection);
        const FloatPicture drawn = scene.draw(options);
        options.skipping = Skipping::kNone;
        EXPECT_TRUE(within(0.25, scene.draw(options), drawn)) << name(type) << ", lit " << lit;
      }
}

TEST_F(GradientTest, otherModesLookAtValuesAlone) {
  const auto source = spacedBlobs(VoxelType::kU8, 5);
  const ValueRange range = valueRangeOf(*source);
  RenderScene scene(device(), *source, modulated(0.3, range),
                    {.ghost = true, .partition = Partition::kBoxes});
  RenderScene plain(device(), *source, above(0.3, range));
  FrameOptions options = obliqueView(Projection::kOrtho);
  const FloatPicture composite = scene.draw(options);
  for (const Mode mode : {Mode::kMip, Mode::kMinip, Mode::kAverage})
    for (const Partition partition : {Partition::kBlocks, Partition::kBoxes}) {
      options.mode = mode;
      options.partition = partition;
      const FloatPicture drawn = scene.draw(options);
      options.partition = Partition::kBlocks;
      EXPECT_TRUE(within(0.1, drawn, plain.draw(options))) << static_cast<int>(mode);
    }
  options.mode = Mode::kComposite;
  EXPECT_EQ(scene.draw(options).rgba, composite.rgba) << "and back";
}

TEST_F(GradientTest, growingBoxesGiveThePictureOfBlocks) {
  std::mt19937_64 random(11);
  for (int i = 0; i < 12; ++i) {
    const VoxelType type = i % 3 == 0   ? VoxelType::kU8
                           : i % 3 == 1 ? VoxelType::kI16
                                        : VoxelType::kF32;
    const auto source = spacedBlobs(type, random());
    const ValueRange range = valueRangeOf(*source);
    const TransferFunction transfers[] = {modulated(0.3, range), plane(range), flatAlone(range)};
    for (const TransferFunction& transfer : transfers) {
      RenderScene scene(device(), *source, transfer,
                        {.block_vox = 32,
                         .lit = random() % 2 == 0,
                         .ghost = true,
                         .partition = Partition::kBoxes});
      FrameOptions options = obliqueView(kProjections[random() % 2], {64, 60});
      options.camera.azimuth_deg = static_cast<double>(random() % 360);
      options.count_samples = true;
      const Frame blocks = scene.frame(options);
      options.partition = Partition::kBoxes;
      const Frame boxes = scene.frame(options);
      FloatPicture a, b;
      a.width = b.width = 64, a.height = b.height = 60;
      a.rgba = blocks.picture.rgba, b.rgba = boxes.picture.rgba;
      EXPECT_TRUE(within(kOfPlain, a, b)) << i << ", " << name(type);
      EXPECT_LT(boxes.report.samples_drawn, blocks.report.samples_drawn);
    }
  }
}

// A flat box is skipped if flat regions show nothing: growing boxes are worth more with modulation
// (Li 2003, section 6).
TEST_F(GradientTest, flatBoxesAreSkipped) {
  const auto source = cube(65, 8);
  FrameOptions options = obliqueView(Projection::kOrtho, {64, 60});
  options.count_samples = true;
  options.partition = Partition::kBoxes;
  RenderScene plain(device(), *source, above(0.3, {0, 200}),
                    {.block_vox = 32, .partition = Partition::kBoxes});
  RenderScene scene(device(), *source, modulated(0.3, {0, 200}), kLargeBlocks);
  const FrameReport report = scene.frame(options).report;
  EXPECT_LT(report.samples_drawn, plain.frame(options).report.samples_drawn * 7 / 10);
  EXPECT_TRUE(within(kOfReference, scene.draw(options), scene.reference(options)));
}

TEST_F(GradientTest, obliqueAxesBoundTheirGradients) {
  VolumeLayout layout;
  layout.dims = {40, 36, 32};
  layout.axes = {Vec3d{1, 0, 0}, normalized({0.6, 1, 0}), normalized({-0.3, 0.4, 1})};
  layout.spacing = {1, 1.5, 1.2};
  const auto source = makeMemorySource<uint8_t>(layout, [](int64_t x, int64_t y, int64_t z) {
    return std::clamp(20.0 * static_cast<double>(x + y + z) - 800, 0.0, 250.0);
  });
  // Visible in a narrow band of magnitudes about the slope's true one, which differs from the
  // magnitude for orthogonal axes.
  TransferFunction transfer = above(0.1, {0, 250});
  const Vec3d slope =
      layout.axes[0] * (20 / 1.0) + layout.axes[1] * (20 / 1.5) + layout.axes[2] * (20 / 1.2);
  const double magnitude = length(slope);
  transfer.gradients = {
      {0.93 * magnitude, {{0, 0}}}, {magnitude, {{0, 1}}}, {1.07 * magnitude, {{0, 0}}}};
  RenderScene scene(device(), *source, transfer, kLargeBlocks);
  const FrameOptions options = obliqueView(Projection::kOrtho, {64, 60});
  const FloatPicture blocks = scene.draw(options);
  EXPECT_GT(shownShare(blocks), 0.1);
  EXPECT_TRUE(within(kOfReference, blocks, scene.reference(options)));
  EXPECT_TRUE(boxesDrawTheSame(scene, options));
}

class GradientDataTest : public GradientTest, public testing::WithParamInterface<RealVolume> {};

TEST_P(GradientDataTest, modulatedPictureIsRightAndBoxesDrawIt) {
  const auto file = openReal(GetParam());
  if (!file) GTEST_SKIP() << GetParam().input << " is not there";
  const Vec3i dims = file->layout().dims;
  const Vec3i size = min(dims, Vec3i{96, 96, 96});
  // Parts of some are one value.
  Vec3i lo = (dims - size) / Vec3i{4, 4, 4};
  std::unique_ptr<MemorySource> source = cropped(*file, {lo, lo + size}, GetParam().time);
  for (int a = 0; a < 3 && valueRangeOf(*source).hi == valueRangeOf(*source).lo; ++a) {
    lo[a] = 0;
    source = cropped(*file, {lo, lo + size}, GetParam().time);
  }
  const ValueRange range = valueRangeOf(*source);
  for (const bool lit : {false, true})
    for (const TransferFunction& transfer : {modulated(0.25, range), plane(range)}) {
      RenderScene scene(
          device(), *source, transfer,
          {.block_vox = 32, .lit = lit, .ghost = true, .partition = Partition::kBoxes});
      FrameOptions options =
          obliqueView(lit ? Projection::kOrtho : Projection::kPerspective, {72, 64});
      options.step_vox = 0.5;
      EXPECT_TRUE(within(kOfReference, scene.draw(options), scene.reference(options)))
          << "lit " << lit;
      EXPECT_TRUE(boxesDrawTheSame(scene, options)) << "lit " << lit;
    }
}

INSTANTIATE_TEST_SUITE_P(Data, GradientDataTest, testing::ValuesIn(realVolumes()),
                         [](const auto& each) { return std::string(each.param.name); });

}  // namespace
}  // namespace sluice::gradient_test
