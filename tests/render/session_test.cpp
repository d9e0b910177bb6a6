// A session over several frames: its uploads, its reports, and sources that fail.
#include "src/render/session/session.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>

#include "src/base/error.h"
#include "tests/render/blob_scene.h"
#include "tests/support/counting_source.h"
#include "tests/support/failing_source.h"

namespace sluice {
namespace {

using SessionTest = RenderTest;

TEST_F(SessionTest, unchangedFrameUploadsNothing) {
  const auto source = blobs();
  CountingSource counting(*source);
  RenderScene scene(device(), counting, someTransfer());
  const Frame first = scene.frame(smallView());
  EXPECT_GT(first.report.pages_loaded, 0U);
  EXPECT_EQ(first.report.uploaded_bytes, copied(first.report.pages_loaded * 8 * 8 * 8));
  counting.reset();
  const Frame second = scene.frame(smallView());
  EXPECT_EQ(second.report.uploaded_bytes, 0U);
  EXPECT_EQ(second.report.pages_loaded, 0U);
  EXPECT_EQ(counting.counts().calls, 0);
  EXPECT_EQ(second.picture.rgba, first.picture.rgba);
}

// The step that was expected after a frame that was stopped is read by no other frame.
TEST_F(SessionTest, whatIsExpectedAfterAFrameEndsWithIt) {
  const auto source = makeSparseBlobs({.drift_vox = 6, .time_steps = 2});
  CountingSource counting(*source);
  RenderScene scene(device(), counting, someTransfer(), {.block_vox = 8, .threads = 1});
  RenderScene other(device(), *source, someTransfer(), {.block_vox = 8, .time = 1});
  const TimeStep next{&counting, 1, other.step().ranges};
  const auto readsOfNext = [&] {
    const auto reads = counting.reads();
    return std::count_if(reads.begin(), reads.end(),
                         [](const auto& read) { return read.time == 1; });
  };
  Session& session = scene.session();
  std::atomic<bool> stop = true;
  FrameOptions stopped = smallView();
  stopped.stop = StopToken(stop);
  session.setOptions(stopped);
  session.expectAfterwards(next);
  EXPECT_THROW(session.frame(), Interrupted);
  for (int i = 0; i < 2; ++i) scene.frame(smallView());
  EXPECT_EQ(readsOfNext(), 0);
  session.setOptions(smallView());
  session.expectAfterwards(next);
  session.frame();
  session.setTimeStep(next);  // and the expected data is read, by this frame at the latest
  session.frame();
  EXPECT_GT(readsOfNext(), 0);
}

TEST_F(SessionTest, changedViewUploadsNothingWhenAllFits) {
  const auto source = blobs();
  RenderScene scene(device(), *source, someTransfer());
  scene.frame(smallView(0));
  for (const double azimuth : {40.0, 133.0, 250.0}) {
    FrameOptions options = smallView(azimuth);
    options.step_vox = 0.7;
    options.size = {30, 60};
    EXPECT_EQ(scene.frame(options).report.pages_loaded, 0U) << azimuth;
    EXPECT_TRUE(within(2, scene.draw(options), scene.reference(options)));
  }
}

TEST_F(SessionTest, changedThresholdUploadsOnlyChunksThatItChanges) {
  const auto source = blobs();
  RenderScene scene(device(), *source, someTransfer());
  FrameOptions options = smallView();
  options.algorithm = Algorithm::kTrimmed;
  scene.frame(options);
  // The same opacities in other colours: no chunk changes.
  scene.setTransfer(thresholdTransfer(40, {0, 200}, 0.2, "inferno"));
  EXPECT_EQ(scene.frame(options).report.pages_loaded, 0U);
  EXPECT_TRUE(within(2, scene.draw(options), scene.reference(options)));
  // A higher threshold, and back: the chunks loaded for the first are still there.
  scene.setTransfer(thresholdTransfer(120, {0, 200}, 0.2, "viridis"));
  EXPECT_GT(scene.frame(options).report.pages_loaded, 0U);
  EXPECT_TRUE(within(2, scene.draw(options), scene.reference(options)));
  scene.setTransfer(someTransfer());
  EXPECT_EQ(scene.frame(options).report.pages_loaded, 0U);
  EXPECT_TRUE(within(2, scene.draw(options), scene.reference(options)));
}

TEST_F(SessionTest, reportCountsBlocksChunksAndPages) {
  // A single object voxel in the middle of the last of 2 x 2 x 2 blocks.
  const auto source = makeMemorySource<uint8_t>(
      Vec3i{15, 15, 15},
      [](int64_t x, int64_t y, int64_t z) { return x == 11 && y == 11 && z == 11 ? 200 : 0; });
  RenderScene scene(device(), *source, someTransfer(), {.block_vox = 8, .page_vox = {8, 8, 1}});
  FrameOptions options = smallView();
  options.algorithm = Algorithm::kTrimmed;
  FrameReport report = scene.frame(options).report;
  EXPECT_EQ(report.blocks.white, 7);
  EXPECT_EQ(report.blocks.grey, 1);
  EXPECT_EQ(report.blocks.black, 0);
  EXPECT_EQ(report.clusters, 1);
  EXPECT_EQ(report.chunks, 1);
  EXPECT_EQ(report.pages, 3) << "two cells, three planes of a page each";
  EXPECT_EQ(report.uploaded_bytes, copied(3U * 64));
  EXPECT_EQ(report.binds, 1U);
  EXPECT_EQ(report.samples_drawn, 0U) << "not counted unless asked for";
  options.algorithm = Algorithm::kConventional;
  report = scene.frame(options).report;
  EXPECT_EQ(report.chunks, 8);
  EXPECT_EQ(report.pages, 64);
}

TEST_F(SessionTest, failingReadSurfacesAndTheSessionGoesOn) {
  const auto source = blobs();
  CountingSource counting(*source);
  RenderScene counted(device(), counting, someTransfer(), {.block_vox = 8});
  counting.reset();
  counted.frame(smallView());
  const int64_t last = counting.counts().calls - 1;
  ASSERT_GT(last, 10);
  for (const int64_t pages : {8, 1 << 15})
    for (const int64_t first : {int64_t{0}, int64_t{1}, int64_t{3}, int64_t{7}, last}) {
      SCOPED_TRACE(fmt::format("{} pages, read {}", pages, first));
      RenderScene whole(device(), *source, someTransfer(), {.block_vox = 8, .pages = pages});
      const FloatPicture expected = whole.draw(smallView());

      FailingSource failing(*source, FailingSource::Failure::kError, first);
      const uint64_t before = device().uploadedBytes();
      const auto session = whole.sessionOver(failing);
      session->setOptions(smallView());
      EXPECT_THROW(session->frame(), Error);
      EXPECT_EQ(session->volumeBufferCounters().brokenIdentity(), "");
      EXPECT_EQ(session->textureBufferCounters().brokenIdentity(), "");
      EXPECT_EQ(session->textureCache().counters().brokenIdentity(), "");
      EXPECT_GT(session->volumeBufferCounters().failures, 0U);
      const Frame frame = session->frame();
      EXPECT_EQ(compare(frame.picture.rgba, expected.rgba, expected.width).max_255, 0);
      EXPECT_EQ(session->textureCache().counters().brokenIdentity(), "");
      EXPECT_EQ(copied(session->textureCache().counters().uploaded_bytes),
                device().uploadedBytes() - before);
    }
}

TEST_F(SessionTest, foreignExceptionsSurfaceToo) {
  const auto source = blobs();
  RenderScene whole(device(), *source, someTransfer(), {.block_vox = 8});
  FailingSource failing(*source, FailingSource::Failure::kException, 2);
  const auto session = whole.sessionOver(failing);
  session->setOptions(smallView());
  EXPECT_THROW(session->frame(), std::exception);
  EXPECT_EQ(compare(session->frame().picture.rgba, whole.draw(smallView()).rgba, 48).max_255, 0);
}

TEST_F(SessionTest, wrongOptionsFailAndTheNextFrameIsRight) {
  const auto source = blobs();
  RenderScene scene(device(), *source, someTransfer());
  FrameOptions bad = smallView();
  bad.camera.zoom = 0;
  EXPECT_THROW(scene.frame(bad), Error);
  bad = smallView();
  bad.size = {0, 5};
  EXPECT_THROW(scene.frame(bad), Error);
  bad.size = {1 << 20, 1 << 20};
  EXPECT_THROW(scene.frame(bad), Error) << "beyond what the device can draw";
  EXPECT_TRUE(within(2, scene.draw(smallView()), scene.reference(smallView())));
}

TEST_F(SessionTest, deviceIsLeftEmptyForTheNextSession) {
  const auto source = blobs();
  const auto other = blobs({30, 50, 20});
  for (int i = 0; i < 3; ++i) {
    RenderScene scene(device(), i == 1 ? *other : *source, someTransfer(), {.block_vox = 8});
    EXPECT_TRUE(within(2, scene.draw(smallView()), scene.reference(smallView()))) << i;
  }
}

TEST_F(SessionTest, timeStepsAreSessionsOfTheirOwn) {
  BlobOptions blob_options;
  blob_options.time_steps = 3;
  blob_options.drift_vox = 6;
  const auto source = makeSparseBlobs(blob_options);
  std::vector<FloatPicture> pictures;
  for (int64_t time = 0; time < 3; ++time) {
    RenderScene scene(device(), *source, someTransfer(), {.time = time});
    pictures.push_back(scene.draw(smallView()));
    EXPECT_TRUE(within(2, pictures.back(), scene.reference(smallView()))) << time;
  }
  EXPECT_FALSE(within(10, pictures[0], pictures[2])) << "nothing moved";
}

}  // namespace
}  // namespace sluice
