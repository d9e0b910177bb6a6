// Frames on a device in plain loops: a device's free choices make no difference, and a frame may
// end at any step.
#include <gtest/gtest.h>

#include "src/base/error.h"
#include "tests/render/blob_scene.h"
#include "tests/support/function_source.h"
#include "tests/support/plain_device.h"

namespace sluice {
namespace {

// Through a cache of few pages, so that chunks come and go within a frame.
SceneOptions tight() {
  return {.block_vox = 8, .pages = 12};
}

TEST(FrameTest, theReferenceIsMet) {
  const auto source = blobs();
  for (const bool lit : {false, true})
    for (const Projection projection : kProjections) {
      PlainDevice device;
      RenderScene scene(device, *source, someTransfer(), {.block_vox = 8, .lit = lit});
      const FrameOptions options = obliqueView(projection, {48, 44});
      EXPECT_TRUE(within(1, scene.draw(options), scene.reference(options)));
    }
}

TEST(FrameTest, otherModesAndDepthAndPlanesMeetItToo) {
  const auto source = spacedBlobs(VoxelType::kU16);
  PlainDevice device;
  const TransferFunction transfer = thresholdTransfer(9000, {0, 51400}, 0.2, "viridis");
  RenderScene scene(device, *source, transfer, {.block_vox = 16});
  for (const Mode mode : {Mode::kComposite, Mode::kMip, Mode::kMinip, Mode::kAverage,
                          Mode::kAttenuatedMip, Mode::kDepthMip}) {
    FrameOptions options = smallView();
    options.mode = mode;
    options.clip_planes = {{{1, 0.2, 0.1}, 30}};
    EXPECT_TRUE(within(2, scene.draw(options), scene.reference(options))) << static_cast<int>(mode);
  }
  FrameOptions options = smallView();
  options.with_depth = true;
  EXPECT_TRUE(depthsWithin(0.01, scene.draw(options), scene.reference(options)));
}

// A device may hold the texels that it is given, and draw as late as it likes.
TEST(FrameTest, borrowedTexelsAndLateDrawingGiveTheSamePicture) {
  const auto source = blobs();
  for (const Algorithm algorithm : kAlgorithms)
    for (const bool borrows : {false, true}) {
      PlainDevice eager, late({.borrows = borrows, .puts_off = true});
      RenderScene plain(eager, *source, someTransfer(), tight());
      RenderScene scene(late, *source, someTransfer(), tight());
      for (const double azimuth : {0.0, 40.0, 200.0}) {
        FrameOptions options = smallView(azimuth);
        options.algorithm = algorithm;
        const Frame expected = plain.frame(options), frame = scene.frame(options);
        EXPECT_EQ(frame.picture.rgba, expected.picture.rgba);
        EXPECT_EQ(frame.report.binds, expected.report.binds);
        EXPECT_EQ(frame.report.pages_loaded, expected.report.pages_loaded);
        EXPECT_GT(frame.report.pages_loaded, 0U);
        EXPECT_EQ(frame.report.uploaded_bytes, borrows ? 0 : expected.report.uploaded_bytes);
      }
      EXPECT_EQ(late.uploadedBytes(), borrows ? 0 : eager.uploadedBytes());
    }
}

// Borrowed bytes belong to level 3 and are counted once: both levels together stay within the
// memory.
TEST(FrameTest, borrowedBytesAreCountedOnce) {
  const auto source = blobs();
  const PageGeometry page{{8, 8, 8}, 1, 64};
  const uint64_t least =
      textureMemoryBytes(page, TexelPlace::kBorrowed) + leastBufferBytes(page, {.block_vox = 8});
  PlainDevice device({.borrows = true, .puts_off = true});
  RenderScene scene(device, *source, someTransfer(),
                    {.block_vox = 8, .pages = page.pages, .memory_bytes = least});
  uint64_t most = 0;
  device.on_draw = [&](std::span<const BoxDraw>) {
    const CacheCounters chunks = scene.session().textureBufferCounters();
    EXPECT_LE(device.residentBytes(), chunks.current_bytes);
    EXPECT_LE(device.residentBytes(), static_cast<uint64_t>(page.cacheBytes()));
    most = std::max(most, device.residentBytes());
  };
  for (const double azimuth : {0.0, 90.0, 180.0}) scene.frame(smallView(azimuth));
  EXPECT_GT(most, static_cast<uint64_t>(page.cacheBytes()) / 2);
  EXPECT_LE(scene.session().volumeBufferCounters().peak_bytes +
                scene.session().textureBufferCounters().peak_bytes,
            least);
}

TEST(FrameTest, aDeviceIsLeftEmpty) {
  const auto source = blobs();
  PlainDevice device({.borrows = true});
  {
    RenderScene scene(device, *source, someTransfer(), tight());
    scene.frame(smallView());
    EXPECT_GT(device.residentBytes(), 0U);
  }
  EXPECT_EQ(device.residentBytes(), 0U);
}

void expectRightCounters(const Session& session) {
  EXPECT_EQ(session.volumeBufferCounters().brokenIdentity(), "");
  EXPECT_EQ(session.textureBufferCounters().brokenIdentity(), "");
  EXPECT_EQ(session.textureCache().counters().brokenIdentity(), "");
}

// The frame is stopped at each list that the device is handed; the next frame is as if it had not
// been.
TEST(FrameTest, aFrameStoppedWhileDrawingLeavesAllLevelsRight) {
  const auto source = blobs();
  PlainDevice whole_device;
  RenderScene whole(whole_device, *source, someTransfer(), tight());
  const Frame expected = whole.frame(smallView());
  for (const PlainDeviceOptions how : {PlainDeviceOptions{}, {.borrows = true, .puts_off = true}})
    for (int stopped_at = 0; stopped_at < 12; stopped_at += 3) {
      PlainDevice device(how);
      RenderScene scene(device, *source, someTransfer(), tight());
      StopSource stop;
      int lists = 0;
      device.on_draw = [&](std::span<const BoxDraw>) {
        if (lists++ == stopped_at) stop.requestStop();
      };
      FrameOptions options = smallView();
      options.stop = stop.token();
      scene.session().setOptions(options);
      EXPECT_THROW(scene.session().frame(), Interrupted) << "at list " << stopped_at;
      EXPECT_EQ(lists, stopped_at + 1) << "no further list is handed over";
      expectRightCounters(scene.session());
      EXPECT_EQ(scene.frame(smallView()).picture.rgba, expected.picture.rgba);
    }
}

// A device that has put boxes of the chunk off draws them first, and that may be stopped.
TEST(FrameTest, aFrameStoppedWhileEvictingLeavesModelAndDeviceAlike) {
  const auto source = blobs();
  PlainDevice whole_device;
  RenderScene whole(whole_device, *source, someTransfer(), tight());
  const Frame expected = whole.frame(smallView());
  int stopped = 0;
  for (int stopped_at = 0; stopped_at < 12; ++stopped_at) {
    StopSource stop;
    int evictions = 0;
    PlainDevice device({.borrows = true, .puts_off = true});
    RenderScene scene(device, *source, someTransfer(), tight());
    device.on_evict = [&] {
      if (evictions++ == stopped_at) stop.requestStop();
    };
    FrameOptions options = smallView();
    options.stop = stop.token();
    scene.session().setOptions(options);
    try {
      scene.session().frame();
    } catch (const Interrupted&) {
      ++stopped;
    }
    expectRightCounters(scene.session());
    for (int i = 0; i < 2; ++i)
      EXPECT_EQ(scene.frame(smallView()).picture.rgba, expected.picture.rgba) << stopped_at;
  }
  EXPECT_GT(stopped, 5);
}

TEST(FrameTest, aFrameStoppedWhileReadingEndsWithoutTheRest) {
  const auto source = blobs();
  PlainDevice whole_device, device;
  RenderScene whole(whole_device, *source, someTransfer(), tight());
  const Frame expected = whole.frame(smallView());
  StopSource stop;
  FunctionSource stopping(source->layout(), [&](int64_t, Vec3i v) {
    stop.requestStop();
    const Vec3i dims = source->layout().dims;
    return static_cast<double>(
        source->bytes()[static_cast<size_t>((v.z * dims.y + v.y) * dims.x + v.x)]);
  });
  RenderScene scene(device, *source, someTransfer(), tight());
  const auto session = scene.sessionOver(stopping);
  FrameOptions options = smallView();
  options.stop = stop.token();
  session->setOptions(options);
  EXPECT_THROW(session->frame(), Interrupted);
  EXPECT_EQ(device.binds(), 0U);
  expectRightCounters(*session);
  session->setOptions(smallView());
  EXPECT_EQ(session->frame().picture.rgba, expected.picture.rgba);
}

TEST(FrameTest, aFrameStoppedBeforeItBeginsDrawsNothing) {
  const auto source = blobs();
  PlainDevice device;
  RenderScene scene(device, *source, someTransfer(), tight());
  StopSource stop;
  stop.requestStop();
  FrameOptions options = smallView();
  options.stop = stop.token();
  scene.session().setOptions(options);
  EXPECT_THROW(scene.session().frame(), Interrupted);
  EXPECT_EQ(device.binds(), 0U);
}

TEST(FrameTest, whoeverWatchesIsToldOfEachClusterAndMayStopThere) {
  const auto source = blobs();
  PlainDevice device;
  RenderScene scene(device, *source, someTransfer(), tight());
  std::vector<uint64_t> told, totals;
  FrameOptions options = smallView();
  options.watch = [&](uint64_t done, uint64_t total) {
    told.push_back(done);
    totals.push_back(total);
  };
  const Frame expected = scene.frame(options);
  const auto clusters = static_cast<uint64_t>(expected.report.clusters);
  ASSERT_GT(clusters, 2U);
  ASSERT_EQ(told.size(), clusters + 1);
  for (uint64_t i = 0; i <= clusters; ++i) EXPECT_EQ(told[i], i);
  EXPECT_EQ(totals, std::vector<uint64_t>(clusters + 1, clusters));
  for (uint64_t stopped_at = 0; stopped_at <= clusters; ++stopped_at) {
    StopSource stop;
    options.stop = stop.token();
    options.watch = [&](uint64_t done, uint64_t) {
      EXPECT_LE(done, stopped_at) << "nothing is drawn any more";
      if (done == stopped_at) stop.requestStop();
    };
    scene.session().setOptions(options);
    EXPECT_THROW(scene.session().frame(), Interrupted) << stopped_at;
    expectRightCounters(scene.session());
    EXPECT_EQ(scene.frame(smallView()).picture.rgba, expected.picture.rgba);
  }
}

TEST(FrameTest, aLitSessionDrawsAFrameWithoutShadeAsAnUnlitOneDoes) {
  const auto source = blobs();
  PlainDevice device;
  RenderScene lit(device, *source, someTransfer(), {.block_vox = 8, .lit = true});
  RenderScene unlit(device, *source, someTransfer(), {.block_vox = 8, .lit = false});
  FrameOptions options = smallView();
  EXPECT_FALSE(within(1, lit.draw(options), unlit.draw(options)));
  options.shades = false;
  EXPECT_TRUE(within(0.01, lit.draw(options), unlit.draw(options)));
}

}  // namespace
}  // namespace sluice
