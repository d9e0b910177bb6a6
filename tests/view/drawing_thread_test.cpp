// The drawing thread, driven as a window drives it: from other threads, faster than it draws.
#include "src/view/drawing/drawing_thread.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <thread>

#include "src/base/threads/threads.h"
#include "src/options/option_rules.h"
#include "src/view/state/editing/transfer_edit.h"
#include "tests/support/ball_pyramid.h"
#include "tests/support/temp_folder.h"
#include "tests/view/seen_news.h"

namespace sluice {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

TEST(DrawingThread, endsWithTheWholePictureThatTheLibraryDraws) {
  DrawingThread desk(drawingOptions());
  Seen seen(desk);
  ASSERT_TRUE(seen.open(kVolume));
  Wish wish = seen.wish();
  wish.state.background = std::array{0.0F, 0.0F, 0.0F};
  ASSERT_TRUE(seen.whole(desk.wish(wish)));
  ASSERT_TRUE(seen.picture != nullptr && seen.picture->is_complete);
  const Volume volume(kVolume);
  Renderer renderer(volume, wish.state.look, drawingOptions().renderer);
  // The picture options if no window had placed the view.
  PictureOptions plain;
  plain.width = 800;
  plain.height = 600;
  PictureOptions placed = pictureOf(wish.state, 800, 600);
  const auto a = renderer.draw(plain).toRgba8(std::array{0.0F, 0.0F, 0.0F});
  const auto b = renderer.draw(placed).toRgba8(std::array{0.0F, 0.0F, 0.0F});
  int largest = 0;
  size_t lit = 0;
  for (size_t i = 0; i < a.size(); ++i) {
    largest = std::max(largest, std::abs(a[i] - b[i]));
    lit += i % 4 != 3 && a[i] > 0 ? 1 : 0;
  }
  EXPECT_LE(largest, 1) << "a placed view is the view that was placed";
  EXPECT_GT(lit, 1000U);
  EXPECT_EQ(seen.picture->rgba,
            renderer.draw(pictureOf(wish.state, 96, 80)).toRgba8(std::array{0.0F, 0.0F, 0.0F}));
}

// The window's thread comes first. Other programs must not: they would keep previews waiting.
TEST(DrawingThread, drawsOneStepBelowTheWindow) {
  std::atomic<int> drawing = 0;
  std::atomic<bool> has_told = false;
  DrawingOptions options = drawingOptions();
  options.on_news = [&] {
    drawing = getpriority(PRIO_PROCESS, static_cast<id_t>(gettid()));
    has_told = true;
  };
  DrawingThread desk(options);
  Seen seen(desk);
  const int window = getpriority(PRIO_PROCESS, static_cast<id_t>(gettid()));
  ASSERT_TRUE(seen.open(kVolume));
  // The news can be seen before its thread tells of it.
  ASSERT_TRUE(seen.until([&] { return has_told.load(); }));
  EXPECT_EQ(drawing, std::min(window + 1, 19));
}

// A pyramid of another program without an index: the window shows its coarser levels at once.
TEST(DrawingThread, aLargePyramidIsShownWithoutReadingItsFinestLevel) {
  const TempFolder folder;
  BallPyramid().write(folder / "ball.zarr");
  spoilLevel(folder / "ball.zarr", 0);
  DrawingThread desk(drawingOptions());
  Seen seen(desk);
  ASSERT_TRUE(seen.open((folder / "ball.zarr").string())) << testing::PrintToString(seen.failures);
  EXPECT_THAT(seen.opened->info.warnings, testing::Contains(HasSubstr("level 0 has no index yet")));
  EXPECT_FALSE(seen.opened->volume.options.opens_soon) << "a saved view has no such option";
  const Wish wish = seen.wish();
  ASSERT_TRUE(seen.whole(desk.wish(wish)));
  EXPECT_THAT(seen.failures, IsEmpty());
  ASSERT_NE(seen.picture, nullptr);
  EXPECT_TRUE(seen.picture->is_complete);
  EXPECT_THAT(seen.picture->levels, testing::Each(testing::Gt(0)));
  EXPECT_THAT(seen.picture->levels, testing::Not(IsEmpty()));
}

TEST(DrawingThread, levelsOfResolutionAreWholeFromTheFirstPictureOn) {
  constexpr const char* kLevels = "synth:shells,dims=120x110x100,levels=4";
  DrawingThread desk(drawingOptions());
  Seen seen(desk);
  ASSERT_TRUE(seen.open(kLevels));
  EXPECT_EQ(seen.opened->info.levels, 4);
  Wish wish = seen.wish();
  wish.state.background = std::array{0.0F, 0.0F, 0.0F};
  wish.moves = true;
  const auto litPixels = [](const std::vector<uint8_t>& rgba) {
    double lit = 0;
    for (size_t i = 0; i < rgba.size(); i += 4)
      lit += rgba[i] + rgba[i + 1] + rgba[i + 2] > 0 ? 1 : 0;
    return lit * 4 / static_cast<double>(rgba.size());
  };
  uint64_t last = 0;
  for (int i = 0; i < 20; ++i) {
    wish.state.view = orbit(wish.state.view, 3, 1, {96, 80});
    last = desk.wish(wish);
    ASSERT_TRUE(seen.until([&] { return seen.picture != nullptr && seen.picture->wish >= last; }));
    EXPECT_EQ(seen.picture->missing_share, 0.0);
    EXPECT_FALSE(seen.picture->levels.empty());
    EXPECT_GT(litPixels(seen.picture->rgba), 0.1);
  }
  wish.moves = false;
  ASSERT_TRUE(seen.whole(desk.wish(wish)));
  ASSERT_TRUE(seen.picture->is_complete);
  EXPECT_FALSE(seen.picture->will_improve);
  EXPECT_TRUE(seen.picture->is_refined);
  const Volume volume(kLevels);
  Renderer renderer(volume, wish.state.look, drawingOptions().renderer);
  EXPECT_EQ(seen.picture->rgba,
            renderer.draw(pictureOf(wish.state, 96, 80)).toRgba8(std::array{0.0F, 0.0F, 0.0F}));
  EXPECT_EQ(seen.picture->levels, renderer.report().levels);
}

TEST(DrawingThread, anEmptyPictureSaysWhy) {
  DrawingThread desk(drawingOptions());
  Seen seen(desk);
  ASSERT_TRUE(seen.open(kVolume));
  Wish wish = seen.wish();
  ASSERT_TRUE(seen.whole(desk.wish(wish)));
  ASSERT_TRUE(seen.picture != nullptr);
  EXPECT_EQ(seen.picture->why_empty, "");
  wish.state.look.opacities = {{0, 0}, {255, 0}};
  ASSERT_TRUE(seen.whole(desk.wish(wish)));
  EXPECT_THAT(seen.picture->why_empty, HasSubstr("transfer function"));
}

TEST(DrawingThread, aPictureOfTwoVolumesThatAreAddedSaysWhy) {
  DrawingThread desk(drawingOptions());
  Seen seen(desk);
  ASSERT_TRUE(seen.open(kVolume, kVolume));
  Wish wish = seen.wish();
  wish.state.look.threshold = 90;
  wish.state.look.light = LookOptions::Light::kOn;
  ASSERT_TRUE(seen.whole(desk.wish(wish)));
  ASSERT_TRUE(seen.picture != nullptr);
  EXPECT_EQ(seen.picture->why_added, "");
  wish.state.lighting.shadows = 1;
  ASSERT_TRUE(seen.whole(desk.wish(wish)));
  EXPECT_THAT(seen.picture->why_added, HasSubstr("leave out \"shadows\" and \"occlusion\""));
}

TEST(DrawingThread, theNewestWishIsTheOneThatIsShown) {
  DrawingThread desk(drawingOptions());
  Seen seen(desk);
  ASSERT_TRUE(seen.open(kVolume));
  Wish wish = seen.wish();
  uint64_t last = 0;
  const auto range = seen.opened->info.value_range;
  for (int i = 0; i < 60; ++i) {
    wish.moves = i < 59;
    wish.state.look = withThreshold(wish.state.look, range[0] + (range[1] - range[0]) * i / 80);
    wish.state.view = orbit(wish.state.view, 2, 1, {96, 80});
    const uint64_t number = desk.wish(wish);
    EXPECT_GT(number, last);
    last = number;
    std::this_thread::sleep_for(std::chrono::milliseconds(i % 7));
  }
  ASSERT_TRUE(seen.whole(last));
  EXPECT_EQ(seen.picture->wish, last);
  EXPECT_TRUE(seen.picture->is_complete);
  const DeskTimes times = desk.times();
  EXPECT_EQ(times.wishes, 60U);
  EXPECT_THAT(times.answer_s, SizeIs(60)) << "every wish had a picture that was no older";
  EXPECT_THAT(seen.failures, IsEmpty());
}

TEST(DrawingThread, aHandThatRestsGetsTheWholePicture) {
  DrawingOptions made = drawingOptions();
  made.budget_s = 0;  // previews are of the least quality
  DrawingThread desk(made);
  Seen seen(desk);
  ASSERT_TRUE(seen.open(kVolume));
  Wish wish = seen.wish();
  wish.moves = true;
  ASSERT_TRUE(seen.whole(desk.wish(wish)));
  EXPECT_EQ(seen.picture->width, 96);
  EXPECT_GE(desk.times().previews, 1U);
}

TEST(DrawingThread, aBadFileIsALineAndTheOldVolumeStays) {
  DrawingThread desk(drawingOptions());
  Seen seen(desk);
  EXPECT_FALSE(seen.open("/nowhere/at-all.nrrd"));
  ASSERT_THAT(seen.failures, SizeIs(1));
  EXPECT_THAT(seen.failures.front(), HasSubstr("/nowhere/at-all.nrrd"));
  ASSERT_TRUE(seen.open(kVolume));
  const Wish wish = seen.wish();
  EXPECT_TRUE(seen.whole(desk.wish(wish)));
  const auto kept = std::move(seen.opened);
  EXPECT_FALSE(seen.open("/nowhere/at-all.nrrd"));
  seen.picture.reset();
  EXPECT_TRUE(seen.whole(desk.wish(wish)));
  EXPECT_NE(seen.picture, nullptr);
}

TEST(DrawingThread, aWishThatCannotBeIsSaidOnce) {
  DrawingThread desk(drawingOptions());
  Seen seen(desk);
  ASSERT_TRUE(seen.open(kVolume));
  Wish wish = seen.wish();
  wish.state.look.transfer_file = "/nowhere/map.json";
  ASSERT_TRUE(seen.whole(desk.wish(wish)));
  EXPECT_THAT(seen.failures, SizeIs(1));
  EXPECT_THAT(seen.failures.front(), HasSubstr("/nowhere/map.json"));
  wish.state.look.transfer_file.clear();
  EXPECT_TRUE(seen.whole(desk.wish(wish)));
  EXPECT_TRUE(seen.picture->is_complete);
}

}  // namespace
}  // namespace sluice
