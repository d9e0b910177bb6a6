// --fit: which box it looks at, and that it looks at no voxel.
#include "src/library/drawing/view_fit.h"

#include <gtest/gtest.h>

#include "src/classify/transfer/transfer_makers.h"
#include "src/render/camera/frame_setup.h"
#include "src/render/camera/index_space.h"
#include "tests/support/temp_folder.h"
#include "tools/scene/open_scene.h"

namespace sluice {
namespace {

constexpr int64_t kFittedSide = 48;

class ViewFitTest : public testing::Test {
 protected:
  // A cube of 8 voxels that moves along x, a file a step.
  ViewFitTest() {
    for (int64_t step = 0; step < 3; ++step) {
      std::string voxels;
      for (int64_t z = 0; z < kFittedSide; ++z)
        for (int64_t y = 0; y < kFittedSide; ++y)
          for (int64_t x = 0; x < kFittedSide; ++x) {
            const Box3 cube = translate(boxOf({8, 8, 8}), {4 + 12 * step, 20, 20});
            voxels += static_cast<char>(cube.contains(Vec3i{x, y, z}) ? 200 : 0);
          }
      const std::filesystem::path file = folder_ / ("step_" + std::to_string(step) + ".raw");
      writeFile(file, voxels);
      arguments_.inputs.push_back(file.string());
    }
    arguments_.open.dims = Vec3i{kFittedSide, kFittedSide, kFittedSide};
    arguments_.open.type = VoxelType::kU8;
    arguments_.time = 1;
    resources_.block = 16;
    frame_.camera.view = ViewName::kFront;
    frame_.size = {100, 100};
  }

  std::vector<Camera> fitted(FitChoice choice, int64_t frames = 1, bool this_step = false) {
    WorkerPool pool(2);
    const IndexedVolume volume = openIndexed(arguments_, resources_, IndexNeeds{}, pool);
    const uint64_t before = volume.source->storedBytesRead();
    std::vector<Camera> cameras = turnOf(frame_.camera, frames);
    const TransferFunction transfer = thresholdTransfer(100, {0, 200});
    fitCameras(cameras, choice, {{{volume, volume.step(), transfer}}, frame_, this_step}, {},
               resources_, pool);
    read_bytes_ = volume.source->storedBytesRead() - before;
    return cameras;
  }

  std::vector<Camera> fittedAlone() { return fitted(std::nullopt, 1, true); }

  TempFolder folder_;
  VolumeArguments arguments_;
  ResourceArguments resources_;
  FrameOptions frame_;
  uint64_t read_bytes_ = 0;
};

TEST_F(ViewFitTest, aSeriesIsFittedInAllItsSteps) {
  const Camera camera = fitted(std::nullopt).front();
  ASSERT_TRUE(camera.framing.has_value());
  // The cubes lie from 4 to 36 along x, with up to a voxel around them.
  EXPECT_NEAR(camera.framing->target.x, 19.5, 0.6);
  EXPECT_NEAR(camera.framing->target.y, 23.5, 0.6);
  EXPECT_NEAR(camera.framing->reach, 17, 1.5);
}

TEST_F(ViewFitTest, aStepIsFittedAlone) {
  const Camera camera = fittedAlone().front();
  ASSERT_TRUE(camera.framing.has_value());
  EXPECT_NEAR(camera.framing->target.x, 19.5, 0.6);
  EXPECT_NEAR(camera.framing->reach, 4.8, 1);
  arguments_.time = 2;
  EXPECT_NEAR(fittedAlone().front().framing->target.x, 31.5, 0.6);
}

TEST_F(ViewFitTest, noVoxelIsReadForIt) {
  fitted(std::nullopt);
  EXPECT_GT(read_bytes_, 0U) << "the other steps had no index yet";
  fitted(std::nullopt);
  EXPECT_EQ(read_bytes_, 0U);
  fittedAlone();
  EXPECT_EQ(read_bytes_, 0U);
}

TEST_F(ViewFitTest, aCropIsFitted) {
  frame_.crop = Box3{{0, 0, 0}, {40, 24, 48}};
  const Camera camera = fittedAlone().front();
  EXPECT_NEAR(camera.framing->target.y, 21.5, 0.6);
}

TEST_F(ViewFitTest, theVolumesSphereHasNoFraming) {
  EXPECT_FALSE(fitted(Fit::kVolume).front().framing.has_value());
  frame_.camera.view = ViewName::kPlain;
  EXPECT_FALSE(fitted(std::nullopt).front().framing.has_value());
  EXPECT_TRUE(fitted(Fit::kVisible).front().framing.has_value());
}

TEST_F(ViewFitTest, aTurnIsOnceAroundWithOneFraming) {
  const std::vector<Camera> cameras = fitted(std::nullopt, 4);
  for (size_t i = 0; i < 4; ++i) {
    EXPECT_DOUBLE_EQ(cameras[i].azimuth_deg, 90.0 * static_cast<double>(i));
    EXPECT_EQ(cameras[i].framing->reach, cameras[0].framing->reach);
    EXPECT_EQ(cameras[i].framing->target, cameras[0].framing->target);
  }
}

TEST_F(ViewFitTest, nothingVisibleFallsBackToTheSphere) {
  frame_.crop = Box3{{0, 0, 0}, {48, 10, 48}};
  EXPECT_FALSE(fittedAlone().front().framing.has_value());
}

// The depths of a picture that depends on them are those of the cube, for any size of blocks.
TEST_F(ViewFitTest, depthsAreThoseOfWhatShows) {
  const TransferFunction transfer = thresholdTransfer(100, {0, 200});
  WorkerPool pool(2);
  for (const int64_t block : {8, 16, 64}) {
    resources_.block = block;
    const IndexedVolume volume = openIndexed(arguments_, resources_, IndexNeeds{}, pool);
    const VolumeLayout& layout = volume.source->layout();
    frame_.depth_cueing = 0;
    const FitRequest request{{{volume, volume.step(), transfer}}, frame_, true};
    EXPECT_EQ(depthPoints(request, resources_, pool), nullptr);
    frame_.depth_cueing = 1;
    frame_.shown_points = depthPoints(request, resources_, pool);
    const View view = resolve(frame_.camera, layout, frame_.size, 1);
    const auto [near, far] = shownDepths(view, layout, frame_);
    // Seen along y: cells begin a voxel before the cube and end one behind it.
    const double middle = dot(worldFromIndex(layout, {23.5, 23.5, 23.5}) - view.eye, view.forward);
    EXPECT_NEAR(near, middle - 4.5, 1e-9) << block;
    EXPECT_NEAR(far, middle + 4.5, 1e-9) << block;
    frame_.shown_points = nullptr;
    const auto [front, back] = shownDepths(view, layout, frame_);
    EXPECT_NEAR(back - front, kFittedSide - 1, 1e-9);
  }
}

// A clip plane takes away the nearest part of the cube, so depths begin at the plane.
TEST_F(ViewFitTest, depthsFollowClipPlanes) {
  const TransferFunction transfer = thresholdTransfer(100, {0, 200});
  WorkerPool pool(2);
  const IndexedVolume volume = openIndexed(arguments_, resources_, IndexNeeds{}, pool);
  const VolumeLayout& layout = volume.source->layout();
  frame_.depth_cueing = 1;
  const FitRequest request{{{volume, volume.step(), transfer}}, frame_, true};
  frame_.shown_points = depthPoints(request, resources_, pool);
  const View view = resolve(frame_.camera, layout, frame_.size, 1);
  const double middle = dot(worldFromIndex(layout, {23.5, 23.5, 23.5}) - view.eye, view.forward);
  const double plane = middle + 1 + dot(view.eye, view.forward);
  frame_.clip_planes = {{view.forward * -1.0, -plane}};
  const auto [near, far] = shownDepths(view, layout, frame_);
  EXPECT_NEAR(near, middle + 1, 1e-9);
  EXPECT_NEAR(far, middle + 4.5, 1e-9);
  // Planes that leave nothing change nothing.
  frame_.clip_planes = {{view.forward, -1e6}};
  const auto [all_near, all_far] = shownDepths(view, layout, frame_);
  EXPECT_NEAR(all_near, middle - 4.5, 1e-9);
  EXPECT_NEAR(all_far, middle + 4.5, 1e-9);
}

}  // namespace
}  // namespace sluice
