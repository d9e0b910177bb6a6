// Which frames may be drawn together with others at their end (added_frames.h).
#include <gtest/gtest.h>

#include <functional>

#include "tests/render/blob_scene.h"
#include "tests/render/level_scene.h"

namespace sluice {
namespace {

class DrawAtEndTest : public LevelCutTest {
 protected:
  static bool canDrawAtEnd(Session& session, const FrameOptions& options) {
    session.setOptions(options);
    return session.canDrawAtEnd();
  }
};

TEST_F(DrawAtEndTest, takesAllDataInMemory) {
  const auto source = blobs();
  RenderScene scene(device(), *source, someTransfer(), {.block_vox = 8});
  EXPECT_FALSE(canDrawAtEnd(scene.session(), smallView())) << "nothing is read";
  scene.frame(smallView());
  EXPECT_TRUE(canDrawAtEnd(scene.session(), smallView()));
  EXPECT_TRUE(canDrawAtEnd(scene.session(), smallView(200)));
  scene.setTransfer(someTransfer(10));
  EXPECT_FALSE(canDrawAtEnd(scene.session(), smallView())) << "more shows";
}

TEST_F(DrawAtEndTest, isRefusedAfterAnEviction) {
  const auto source = blobs();
  // A frame that takes turns in few pages has lost its first chunks at its end.
  const Vec3i page{8, 8, 8};
  RenderScene all(device(), *source, someTransfer(), {.block_vox = 8, .page_vox = page});
  const int64_t pages = all.frame(smallView()).report.pages;
  ASSERT_GT(pages, 20);
  for (const int64_t fewer : {int64_t{1}, pages / 2}) {
    RenderScene scene(device(), *source, someTransfer(),
                      {.block_vox = 8, .page_vox = page, .pages = pages - fewer});
    scene.frame(smallView());
    EXPECT_FALSE(canDrawAtEnd(scene.session(), smallView())) << fewer;
  }
}

TEST_F(DrawAtEndTest, isRefusedIfMoreIsAskedOfTheFrame) {
  const auto source = blobs();
  RenderScene scene(device(), *source, someTransfer(),
                    {.block_vox = 8, .ghost = true, .partition = Partition::kBoxes});
  Session& session = scene.session();
  FrameOptions plain = smallView();
  plain.partition = Partition::kBlocks;
  plain.integrates = false;
  scene.frame(plain);
  ASSERT_TRUE(canDrawAtEnd(session, plain));
  using Change = std::function<void(FrameOptions&)>;
  const std::pair<const char*, Change> changes[] = {
      {"a time limit", [](FrameOptions& o) { o.time_limit_s = 10; }},
      {"counted samples", [](FrameOptions& o) { o.count_samples = true; }},
      {"depth", [](FrameOptions& o) { o.with_depth = true; }},
      {"a mode", [](FrameOptions& o) { o.mode = Mode::kMip; }},
      {"occlusion", [](FrameOptions& o) { o.occlusion = Occlusion::kCull; }},
      {"growing boxes", [](FrameOptions& o) { o.partition = Partition::kBoxes; }},
      {"shadows", [](FrameOptions& o) { o.lighting.shadows = 1; }},
      {"light that looks around", [](FrameOptions& o) { o.lighting.occlusion = 1; }}};
  for (const auto& [what, change] : changes) {
    FrameOptions options = plain;
    change(options);
    EXPECT_FALSE(canDrawAtEnd(session, options)) << what;
    EXPECT_TRUE(canDrawAtEnd(session, plain)) << "after " << what;
  }
  session.expectAfterwards(scene.step());
  EXPECT_FALSE(canDrawAtEnd(session, plain)) << "data is read for the next frame";
}

TEST_F(DrawAtEndTest, isRefusedForSurfacesSegmentsAndLevels) {
  const auto source = blobs();
  const ValueRange range = valueRangeOf(*source);
  TransferFunction with_surface = someTransfer();
  with_surface.surfaces = {{(range.lo + range.hi) / 2, 0.5}};
  RenderScene surfaces(device(), *source, with_surface, {.block_vox = 8, .ghost = true});
  surfaces.frame(smallView());
  EXPECT_FALSE(canDrawAtEnd(surfaces.session(), smallView()));
  RenderScene segments(device(), *source, someTransfer(), {.block_vox = 8, .ghost = true});
  FrameOptions integrated = smallView();
  integrated.integrates = true;
  segments.frame(integrated);
  EXPECT_FALSE(canDrawAtEnd(segments.session(), integrated));
  Pyramid pyramid(*source, 2);
  const auto leveled = sessionOf(pyramid, someTransfer());
  FrameOptions cut = smallView();
  cut.cut = CutOptions{.level = 1};
  leveled->setOptions(cut);
  leveled->frame();
  EXPECT_FALSE(canDrawAtEnd(*leveled, cut));
}

}  // namespace
}  // namespace sluice
