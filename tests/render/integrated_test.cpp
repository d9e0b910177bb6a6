// Pre-integration: pictures whose samples show all values between them, against the reference, for
// any blocks, and against a picture of many more samples.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/render/blob_scene.h"
#include "tests/render/right_picture.h"

namespace sluice::integrated_test {
namespace {

constexpr double kOfReference = 2;

// A thin shell and a solid inside, without a step.
TransferFunction shellAndCore(ValueRange range, double opacity = 0.4) {
  const auto at = [&](double share) { return range.lo + share * (range.hi - range.lo); };
  return pointsTransfer("viridis", range,
                        {{at(0.3), 0},
                         {at(0.33), opacity},
                         {at(0.36), 0},
                         {at(0.7), 0},
                         {at(0.8), 0.2},
                         {at(0.95), 0.9}});
}

class IntegratedTest : public RightPictureTest {
 protected:
  void expectRightPicture(VolumeSource& source, const TransferFunction& transfer,
                          FrameOptions options, bool lit) {
    options.integrates = true;
    RightPictureTest::expectRightPicture(source, transfer, options, options, lit);
  }
};

TEST_F(IntegratedTest, givesTheReferencePicture) {
  drawBlobsOfAllKinds([&](MemorySource& source, const FrameOptions& options, bool lit) {
    expectRightPicture(source, shellAndCore(valueRangeOf(source)), options, lit);
  });
}

TEST_F(IntegratedTest, factorsOfGradientsAreForTheMeanOfBothEnds) {
  const auto source = spacedBlobs(VoxelType::kU8);
  const ValueRange range = valueRangeOf(*source);
  TransferFunction transfer = shellAndCore(range);
  const double span = range.hi - range.lo;
  transfer.gradients = {{0.01 * span, {{range.lo, 0.2}, {range.hi, 1}}},
                        {0.1 * span, {{range.lo, 1}, {range.hi, 0.5}}}};
  for (const Projection projection : kProjections) {
    FrameOptions options = obliqueView(projection, {64, 60});
    options.step_vox = 1.5;
    expectRightPicture(*source, transfer, options, true);
  }
}

TEST_F(IntegratedTest, cropsAndClipPlanesCutSegmentsAtTheirMiddles) {
  const auto source = spacedBlobs(VoxelType::kU8);
  FrameOptions options = obliqueView(Projection::kOrtho, {64, 60});
  options.crop = Box3{{12, 9, 8}, {52, 45, 48}};
  options.clip_planes = {{{0.3, -1, 0.2}, -2}};
  options.step_vox = 1.6;
  expectRightPicture(*source, shellAndCore(valueRangeOf(*source)), options, true);
}

TEST_F(IntegratedTest, anEndThatIsNoNumberLeavesTheOtherOne) {
  const float kNan = std::numeric_limits<float>::quiet_NaN();
  VolumeLayout layout;
  layout.dims = {26, 24, 22};
  const auto source = makeMemorySource<float>(layout, [&](int64_t x, int64_t y, int64_t z) {
    if (x > 17 && y > 12) return kNan;
    return static_cast<float>(0.5 + 0.4 * std::sin(static_cast<double>(x + 2 * y + z) / 6));
  });
  FrameOptions options = obliqueView(Projection::kPerspective, {64, 60});
  options.step_vox = 1.3;
  expectRightPicture(*source, shellAndCore({0.1, 0.9}), options, false);
}

// The blocks beside a shell show it: half a segment reaches into them.
TEST_F(IntegratedTest, blocksBesideVisibleOnesAreDrawn) {
  const auto source = makeMemorySource<uint8_t>(
      Vec3i{29, 17, 17}, [](int64_t x, int64_t, int64_t) { return x == 14 ? 200.0 : 0.0; });
  const TransferFunction transfer = pointsTransfer("grey", {0, 255}, {{150, 0}, {190, 0.5}});
  FrameOptions options = obliqueView(Projection::kOrtho, {64, 60});
  for (const double step : {1.0, 2.0}) {
    options.step_vox = step;
    // Blocks of 5, 13 and 29 cells: the plane lies on a face, next to one, and inside.
    for (const int64_t block : {8, 16, 32}) {
      SCOPED_TRACE(fmt::format("step {}, blocks of {}", step, block));
      options.integrates = true;
      RenderScene scene(device(), *source, transfer, {.block_vox = block, .ghost = true});
      EXPECT_TRUE(within(kOfReference, scene.draw(options), scene.reference(options)));
    }
  }
}

double errorOf(const FloatPicture& picture, const FloatPicture& truth) {
  double sum = 0;
  for (size_t i = 0; i < picture.rgba.size(); ++i)
    sum += std::pow(static_cast<double>(picture.rgba[i]) - static_cast<double>(truth.rgba[i]), 2);
  return std::sqrt(sum / static_cast<double>(picture.rgba.size()));
}

TEST_F(IntegratedTest, isNearerToTheTruthThanSamplesHalfAsFarApart) {
  const auto source = spacedBlobs(VoxelType::kU8);
  RenderScene scene(device(), *source, shellAndCore(valueRangeOf(*source)), {.ghost = true});
  FrameOptions options = obliqueView(Projection::kOrtho, {64, 60});
  options.step_vox = 1.0 / 8;
  const FloatPicture truth = scene.draw(options);
  options.step_vox = 1;
  const double plain = errorOf(scene.draw(options), truth);
  options.integrates = true;
  const double same_step = errorOf(scene.draw(options), truth);
  options.step_vox = 2;
  const double twice = errorOf(scene.draw(options), truth);
  EXPECT_LT(same_step, 0.5 * plain);
  EXPECT_LT(twice, plain);
}

}  // namespace
}  // namespace sluice::integrated_test
