// Large pyramids of other programs that have no index, opened soon: what is read of their finest
// level, and what pictures, slices and probes of them show.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>

#include "tests/library/library_support.h"
#include "tests/support/ball_pyramid.h"
#include "tests/support/error_of.h"

namespace sluice {
namespace {

using testing::Contains;
using testing::Each;
using testing::Gt;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

constexpr int kBallSide = 160;
const LookOptions kBallLook{.threshold = 60, .opacity = 0.3, .light = LookOptions::Light::kOff};
const char* const kBallWords = "--threshold 60 --opacity 0.3 --no-shade";

// The picture of the whole volume.
PictureOptions whole() {
  PictureOptions picture{.width = kBallSide, .height = kBallSide};
  picture.view.from = ViewOptions::From::kPlain;
  picture.view.fit = ViewOptions::Fit::kVolume;
  return picture;
}

class OpensSoon : public testing::Test {
 protected:
  VolumeOptions options() const {
    return {.opens_soon = true, .index_folder = (folder_ / "index").string(), .threads = 2};
  }
  static RendererOptions machine() {
    return {
        .device = RendererOptions::Device::kCpu, .memory_bytes = uint64_t{256} << 20, .threads = 2};
  }
  std::string write(const BallPyramid& ball) const {
    ball.write(folder_ / "ball.zarr");
    return (folder_ / "ball.zarr").string();
  }

  const TempFolder folder_;
  const BallPyramid ball_{};
};

TEST_F(OpensSoon, aPictureReadsNothingOfLevelZero) {
  const std::string path = write(ball_);
  spoilLevel(path, 0);
  const Volume volume(path, options());
  EXPECT_THAT(volume.info().warnings, Contains(HasSubstr("level 0 has no index yet")));
  EXPECT_EQ(volume.info().levels, 4);
  EXPECT_NEAR(volume.info().value_range[1], 240, 5);
  Renderer renderer(volume, kBallLook, machine());
  const Image image = renderer.draw(whole());
  const RenderReport report = renderer.report();
  EXPECT_THAT(report.levels, Not(IsEmpty()));
  EXPECT_THAT(report.levels, Each(Gt(0)));
  EXPECT_EQ(report.coarse_share, 1.0);
  // A disk as large as the ball. At zoom 1 the sphere around the volume fills the picture.
  const double half = length(toDouble(ball_.dims - Vec3i{1, 1, 1})) / 2;
  const double radius = ball_.radius * kBallSide / (2 * half);
  EXPECT_NEAR(static_cast<double>(visiblePixels(image.toRgba8())),
              std::numbers::pi * radius * radius, 0.1 * std::numbers::pi * radius * radius);
  // Without `opens_soon` the pass over level 0 comes first.
  VolumeOptions patient = options();
  patient.opens_soon = false;
  EXPECT_THAT(errorOf([&] { Volume(path, patient); }), HasSubstr("ball.zarr/0"));
}

// A row of coarse cells is told by its ends, which lie outside of a crop within the ball.
TEST_F(OpensSoon, aCropIsFittedToWhatShowsInIt) {
  const Volume volume(write(ball_), options());
  Renderer renderer(volume, kBallLook, machine());
  for (const int side : {41, 9, 3}) {
    const Vec3i lo = Vec3i{400, 250, 260} - Vec3i{side / 2, side / 2, side / 2};
    PictureOptions picture = whole();
    picture.view.fit = ViewOptions::Fit::kVisible;
    picture.crop = {{{lo.x, lo.y, lo.z}, {lo.x + side, lo.y + side, lo.z + side}}};
    // The cube's face, with the margin of a fit.
    const double face = 0.9375 * kBallSide;
    EXPECT_NEAR(static_cast<double>(visiblePixels(renderer.draw(picture).toRgba8())), face * face,
                0.05 * face * face)
        << side;
  }
}

TEST_F(OpensSoon, thePictureIsThatOfTheProgramAtTheSamePixelError) {
  const std::string path = write(ball_);
  const Volume volume(path, options());
  Renderer renderer(volume, kBallLook, machine());
  const Rgba8Picture program = programPicture(
      folder_, path + " " + kBallWords +
                   fmt::format(" --pixel-error 1 --device cpu --memory 256M --view plain "
                               "--fit volume --size {}",
                               kBallSide));
  const auto drawn = renderer.draw(whole()).toRgba8();
  EXPECT_GT(visiblePixels(drawn), 100U);
  EXPECT_LE(largestDifference(drawn, program.rgba), 1);
}

TEST_F(OpensSoon, whatPicturesReadOfLevelZeroIsKnownAfterwards) {
  const std::string path = write(ball_);
  PictureOptions close = whole();
  close.view.zoom = 12;
  close.view.look_at = ViewOptions::LookAt{{400, 250, 2000}, {400, 250, 260}};
  int64_t cells_before = 0;
  for (const bool is_first : {true, false}) {
    const Volume volume(path, options());
    Renderer renderer(volume, kBallLook, machine());
    const uint64_t before = renderer.report().read_bytes;
    renderer.draw(close);
    const RenderReport report = renderer.report();
    ASSERT_THAT(report.levels, Contains(0));
    EXPECT_GT(report.read_bytes, before);
    const int64_t shown = report.grey + report.black;
    if (!is_first) {
      EXPECT_LT(shown, cells_before) << "blocks beside the ball are known to be empty";
    }
    cells_before = shown;
  }
}

TEST_F(OpensSoon, slicesAndProbesShowVoxelsThatNobodyHasReadBefore) {
  const std::string path = write(ball_);
  const Volume volume(path, options());
  Renderer renderer(volume, kBallLook, machine());
  const auto probe = renderer.probe(
      [] {
        PictureOptions picture = whole();
        picture.view.look_at = ViewOptions::LookAt{{400, 250, 2000}, {400, 250, 260}};
        return picture;
      }(),
      0.5, 0.5);
  ASSERT_TRUE(probe);
  EXPECT_NEAR(probe->voxel[0], 400, 2);
  EXPECT_NEAR(probe->voxel[2], ball_.middle.z + ball_.radius, 20);
  EXPECT_GT(probe->value, 60);
  for (int axis = 0; axis < 3; ++axis)
    for (const int most : {2048, 128}) {
      const auto at = static_cast<int64_t>(ball_.middle[axis]) + 20;
      const SliceValues slice = renderer.slice({.axis = axis, .at = at, .most = most});
      const int across = axis == 0 ? 1 : 0, down = axis == 2 ? 1 : 2;
      double largest = 0;
      for (int y = 0; y < slice.height; ++y)
        for (int x = 0; x < slice.width; ++x) {
          Vec3d voxel;
          voxel[axis] = static_cast<double>(at);
          voxel[across] = static_cast<double>(x * slice.every);
          voxel[down] = static_cast<double>(y * slice.every);
          const double expected = ball_.valueAt(voxel);
          const double found =
              slice.values[static_cast<size_t>(y) * static_cast<size_t>(slice.width) +
                           static_cast<size_t>(x)];
          // A voxel of a coarser level may lie half of its width away along each axis; the face
          // of the ball is a step.
          const double near_face = std::abs(length(voxel - ball_.middle) - ball_.radius);
          if (near_face > 10) largest = std::max(largest, std::abs(expected - found));
        }
      EXPECT_LE(largest, most == 2048 ? 1 : 12) << axis << " " << most;
    }
}

TEST_F(OpensSoon, aSliceOfFewValuesReadsNothingOfLevelZero) {
  const std::string path = write(ball_);
  spoilLevel(path, 0);
  const Volume volume(path, options());
  Renderer renderer(volume, kBallLook, machine());
  EXPECT_NO_THROW(renderer.slice({.axis = 2, .at = 260, .most = 128}));
  EXPECT_THAT(errorOf([&] { renderer.slice({.axis = 2, .at = 260, .most = 2048}); }),
              HasSubstr("ball.zarr/0"));
}

TEST_F(OpensSoon, noStepOfASeriesIsPassedOver) {
  BallPyramid moving = ball_;
  moving.time_steps = 3;
  const std::string path = write(moving);
  spoilLevel(path, 0);
  const Volume volume(path, options());
  EXPECT_EQ(volume.info().time_steps, 3);
  Renderer renderer(volume, kBallLook, machine());
  std::vector<std::vector<uint8_t>> pictures;
  for (int64_t time = 0; time < 3; ++time) {
    PictureOptions picture = whole();
    picture.time = time;
    pictures.push_back(renderer.draw(picture).toRgba8());
    EXPECT_GT(visiblePixels(pictures.back()), 100U) << time;
  }
  EXPECT_GT(largestDifference(pictures[0], pictures[1]), 50) << "the ball moves";
  EXPECT_GT(largestDifference(pictures[1], pictures[2]), 50);
  // The fit covers all steps.
  PictureOptions fitted = whole();
  fitted.view.fit = ViewOptions::Fit::kVisible;
  fitted.time = 2;
  EXPECT_GT(visiblePixels(renderer.draw(fitted).toRgba8()), 500U);
}

TEST_F(OpensSoon, coarserLevelsAreNotPassedOverEitherIfLevelZeroHasItsIndex) {
  const std::string path = write(ball_);
  programPicture(folder_, path +
                              " --threshold 60 --pixel-error 0.1 --size 64 --view plain "
                              "--index-dir " +
                              (folder_ / "index").string());
  // The index of level 1 belongs to another state of it from now on.
  spoilLevel(path, 1);
  const Volume volume(path, options());
  EXPECT_THAT(volume.info().warnings, Not(Contains(HasSubstr("no index"))));
  Renderer renderer(volume, kBallLook, machine());
  renderer.draw(whole());
  EXPECT_THAT(renderer.report().levels, Each(Gt(1)));
}

TEST_F(OpensSoon, smallVolumesGetTheirIndex) {
  BallPyramid small{.dims = {256, 128, 128}, .levels = 3, .middle = {120, 60, 64}, .radius = 40};
  const Volume volume(write(small), options());
  EXPECT_THAT(volume.info().warnings, Not(Contains(HasSubstr("no index"))));
  EXPECT_EQ(volume.info().levels, 1) << "levels of another program are drawn on request";
}

}  // namespace
}  // namespace sluice
