// The drawing thread beside its pictures: probes, slices, states, key frames, saves, series and
// reports.
#include "src/view/drawing/drawing_thread.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <fstream>
#include <thread>

#include "src/base/files/file_kind.h"
#include "src/base/threads/threads.h"
#include "src/options/option_rules.h"
#include "src/view/state/editing/transfer_edit.h"
#include "tests/support/temp_folder.h"
#include "tests/support/wrong_states.h"
#include "tests/view/seen_news.h"

namespace sluice {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

TEST(DrawingThread, answersProbesWithTheVoxelsOwnValue) {
  DrawingThread desk(drawingOptions());
  Seen seen(desk);
  ASSERT_TRUE(seen.open(kVolume));
  ASSERT_TRUE(seen.whole(desk.wish(seen.wish())));
  const uint64_t middle = desk.probe(0.5, 0.5);
  ASSERT_TRUE(seen.until([&] { return seen.probe && seen.probe->number == middle; }));
  ASSERT_TRUE(seen.probe->found);
  const auto& found = *seen.probe->found;
  for (size_t a = 0; a < 3; ++a) {
    EXPECT_GE(found.voxel[a], -0.5);
    EXPECT_LE(found.voxel[a], static_cast<double>(seen.opened->info.dims[a]));
  }
  // The slice through it holds values around it.
  const Volume volume(kVolume);
  Renderer renderer(volume, {}, drawingOptions().renderer);
  const auto at = static_cast<int64_t>(found.voxel[2]);
  double least = 1e300, most = -1e300;
  for (const int64_t plane : {at, std::min(at + 1, seen.opened->info.dims[2] - 1)}) {
    const SliceValues slice = renderer.slice({.axis = 2, .at = plane});
    for (int dy = 0; dy < 2; ++dy)
      for (int dx = 0; dx < 2; ++dx) {
        const int x = std::min(static_cast<int>(found.voxel[0]) + dx, slice.width - 1);
        const int y = std::min(static_cast<int>(found.voxel[1]) + dy, slice.height - 1);
        const auto value = static_cast<double>(
            slice.values[static_cast<size_t>(y) * static_cast<size_t>(slice.width) +
                         static_cast<size_t>(x)]);
        least = std::min(least, value);
        most = std::max(most, value);
      }
  }
  EXPECT_GE(found.value, least - 1e-3);
  EXPECT_LE(found.value, most + 1e-3);
  const uint64_t corner = desk.probe(0.001, 0.001);
  ASSERT_TRUE(seen.until([&] { return seen.probe->number == corner; }));
  EXPECT_FALSE(seen.probe->found);
}

TEST(DrawingThread, aModeLeavesOutWhatItDoesNotShow) {
  const TempFolder folder;
  DrawingThread desk(drawingOptions());
  Seen seen(desk);
  ASSERT_TRUE(seen.open(kVolume));
  Wish wish = seen.wish(96, 80);
  wish.state.look.mode = LookOptions::Mode::kMaximum;
  const Volume volume(kVolume);
  Renderer renderer(volume, wish.state.look, drawingOptions().renderer);
  const auto expected =
      renderer.draw(pictureOf(wish.state, 96, 80)).toRgba8(std::array{0.0F, 0.0F, 0.0F});
  wish.state.look.surfaces = {{.value = 90}};
  wish.state.lighting.shadows = 0.5;
  wish.state.jitter = 1;
  ASSERT_TRUE(seen.whole(desk.wish(wish)));
  EXPECT_THAT(seen.failures, testing::IsEmpty());
  EXPECT_EQ(seen.picture->rgba, expected);
  // The printed command draws the same.
  desk.savePicture((folder / "a.png").string(), wish);
  ASSERT_TRUE(seen.until([&] { return !seen.saved.empty(); }));
  EXPECT_THAT(seen.saved.front().command, testing::Not(HasSubstr("--iso")));
}

TEST(DrawingThread, slicesFollowTheCrossHair) {
  DrawingThread desk(drawingOptions());
  Seen seen(desk);
  ASSERT_TRUE(seen.open(kVolume));
  Wish wish = seen.wish();
  wish.state.shows_slices = true;
  wish.state.cross = {3, 4, 5};
  desk.wish(wish);
  ASSERT_TRUE(seen.until([&] { return seen.slices.size() >= 3; }));
  for (const ShownSlice& slice : seen.slices)
    EXPECT_EQ(slice.at, wish.state.cross[static_cast<size_t>(slice.axis)]);
  wish.state.cross[1] = 20;
  seen.slices.clear();
  desk.wish(wish);
  ASSERT_TRUE(seen.until([&] { return !seen.slices.empty(); }));
  EXPECT_THAT(seen.slices, SizeIs(1));
  EXPECT_EQ(seen.slices[0].at, 20);
}

TEST(DrawingThread, aPlacedViewIsTheNamedOne) {
  DrawingThread desk(drawingOptions());
  Seen seen(desk);
  ASSERT_TRUE(seen.open(kVolume));
  ViewState state = seen.opened->state;
  state.view = ViewOptions{};
  state.view.from = ViewOptions::From::kTop;
  const uint64_t number = desk.place(state, 64, 64);
  ASSERT_TRUE(seen.until([&] { return seen.placed.has_value(); }));
  EXPECT_EQ(seen.placed->number, number);
  ASSERT_TRUE(seen.placed->view && seen.placed->view->look_at);
  ViewState placed_state = state;
  placed_state.view = *seen.placed->view;
  const Volume volume(kVolume);
  Renderer renderer(volume, {}, drawingOptions().renderer);
  const auto named = renderer.draw(pictureOf(state, 64, 64)).toRgba8();
  const auto placed = renderer.draw(pictureOf(placed_state, 64, 64)).toRgba8();
  int largest = 0;
  for (size_t i = 0; i < named.size(); ++i)
    largest = std::max(largest, std::abs(named[i] - placed[i]));
  EXPECT_LE(largest, 1);
}

TEST(DrawingThread, saysInTheWindowsWordsThatShadowsDoNotFollowGradients) {
  DrawingThread desk(drawingOptions());
  Seen seen(desk);
  ASSERT_TRUE(seen.open(kVolume));
  Wish wish = seen.wish();
  wish.state.look.full_gradient = 0.1;
  wish.state.look.light = LookOptions::Light::kOn;
  wish.state.lighting.shadows = 1;
  ASSERT_TRUE(seen.whole(desk.wish(wish)));
  ASSERT_TRUE(seen.until([&] { return !seen.failures.empty(); }));
  EXPECT_THAT(seen.failures.front(),
              testing::AllOf(HasSubstr("leave out \"by gradient\""), HasSubstr("\"shadows\""),
                             testing::Not(HasSubstr("--"))));
}

// Loads a state's file on the open volume; returns a failure's line, or empty if it was shown.
std::string loaded(Seen& seen, const std::filesystem::path& file, const std::string& json) {
  std::ofstream(file) << json;
  seen.state.reset();
  seen.opened.reset();
  seen.failures.clear();
  seen.desk.loadState(file.string());
  EXPECT_TRUE(seen.until([&] { return seen.state || seen.opened || !seen.failures.empty(); }));
  return seen.failures.empty() ? "" : seen.failures.front();
}

TEST(DrawingThread, refusesEachWrongStateAndDrawsOn) {
  const TempFolder folder;
  DrawingThread desk(drawingOptions());
  Seen seen(desk);
  ASSERT_TRUE(seen.open(kStateVolume));
  Wish wish = seen.wish(40, 32);
  EXPECT_EQ(loaded(seen, folder / "right.json", rightState()), "");
  for (const WrongState& state : wrongStates())
    EXPECT_THAT(loaded(seen, folder / "wrong.json", state.json), HasSubstr("wrong.json: expected"))
        << state.json;
  // The state is opened with its volume too, in place of the open one.
  std::string named = rightState();
  named.replace(named.find("\"time\":0"), 8, "\"time\":5");
  named.insert(1, std::string("\"volume\":{\"paths\":[\"") + kStateVolume + "\"]},");
  EXPECT_THAT(loaded(seen, folder / "named.json", named), HasSubstr("named.json: expected"));
  EXPECT_TRUE(seen.whole(desk.wish(wish)));
  EXPECT_TRUE(seen.picture->is_complete);
  // The library itself names a step that is not there.
  for (const int64_t time : {int64_t{-1}, int64_t{5}}) {
    seen.failures.clear();
    wish.state.time = time;
    const uint64_t number = desk.wish(wish);
    ASSERT_TRUE(seen.whole(number));
    EXPECT_EQ(desk.status().failed, number);
    seen.placed.reset();
    desk.place(wish.state, 40, 32);
    ASSERT_TRUE(seen.until([&] { return seen.failures.size() == 2; }));
    EXPECT_TRUE(seen.placed && !seen.placed->view) << "nothing waits for it any longer";
    for (const std::string& line : seen.failures) EXPECT_THAT(line, HasSubstr("1 time step"));
  }
}

TEST(DrawingThread, whenNeitherVolumeCanBeDrawnTheNextWishBringsTheLastOneBack) {
  const TempFolder folder;
  const std::string colors = (folder / "colors.json").string();
  std::ofstream(colors) << R"({"sluice_transfer_function": 1, "colors": [[0, "#00ff00"]],
                               "opacities": [[0, 0], [100, 0.5]]})";
  DrawingThread desk(drawingOptions());
  Seen seen(desk);
  ASSERT_TRUE(seen.open(kVolume));
  Wish wish = seen.wish();
  wish.state.look.transfer_file = colors;
  ASSERT_TRUE(seen.whole(desk.wish(wish)));
  std::filesystem::remove(colors);  // the look of the volume that is open cannot be made again
  ViewedVolume other;
  other.paths = {kStateVolume};
  ViewState state;
  state.look.transfer_file = colors;
  desk.open(other, state);
  ASSERT_TRUE(seen.until([&] { return seen.failures.size() == 1; }));
  desk.wantReport(false);
  ASSERT_TRUE(seen.whole(desk.wish(wish)));
  EXPECT_THAT(seen.failures.back(), HasSubstr("colors.json"));
  wish.state.look.transfer_file.clear();
  seen.picture.reset();
  ASSERT_TRUE(seen.whole(desk.wish(wish)));
  EXPECT_TRUE(seen.picture != nullptr && seen.picture->is_complete);
}

TEST(DrawingThread, aStatesOwnLookIsWhatItsViewFits) {
  const TempFolder folder;
  DrawingThread desk(drawingOptions());
  Seen seen(desk);
  ASSERT_TRUE(seen.open(kVolume));
  const auto range = seen.opened->info.value_range;
  const double threshold = range[0] + 0.9 * (range[1] - range[0]);
  ASSERT_EQ(loaded(seen, folder / "a.json",
                   fmt::format(R"({{"sluice": "view", "look": {{"threshold": {}}}}})", threshold)),
            "");
  const Volume volume(kVolume);
  Renderer own(volume, {.threshold = threshold}, drawingOptions().renderer);
  Renderer chosen(volume, {}, drawingOptions().renderer);
  PictureOptions picture;
  picture.width = 800;
  picture.height = 600;
  EXPECT_NEAR(seen.state->view.zoom, own.placed(picture).zoom, 1e-9);
  EXPECT_GT(std::abs(chosen.placed(picture).zoom - own.placed(picture).zoom), 1e-3);
}

// The example of docs/view.md.
TEST(DrawingThread, keyFramesThatSayNoUpHaveTheVolumes) {
  const TempFolder folder;
  DrawingThread desk(drawingOptions());
  Seen seen(desk);
  ASSERT_TRUE(seen.open(kVolume));
  ASSERT_EQ(loaded(seen, folder / "a.json", R"({"sluice": "view", "path": {"kind": "keys", "keys": [
      {"seconds": 0.08, "camera": {"eye": [0, 0, 500], "target": [0, 0, 0]}},
      {"camera": {"eye": [500, 0, 0], "target": [0, 0, 0]}}]}})"),
            "");
  ASSERT_TRUE(seen.film);
  FilmWish film;
  film.name = (folder / "f_%d.png").string();
  film.path = *seen.film;
  film.now = *seen.state;
  film.width = film.height = 32;
  desk.writeFrames(film);
  ASSERT_TRUE(seen.until([&] { return !seen.saved.empty() || !seen.failures.empty(); }));
  EXPECT_THAT(seen.failures, IsEmpty());
  EXPECT_TRUE(std::filesystem::exists(folder / "f_2.png"));
}

TEST(DrawingThread, savesPicturesAndTexts) {
  const TempFolder folder;
  DrawingThread desk(drawingOptions());
  Seen seen(desk);
  ASSERT_TRUE(seen.open(kVolume));
  desk.savePicture((folder / "a.png").string(), seen.wish());
  desk.saveText((folder / "b.txt").string(), "text", FileKind::kView);
  desk.saveText("/nowhere/at/all.txt", "text", FileKind::kView);
  ASSERT_TRUE(seen.until([&] { return seen.saved.size() == 2 && seen.failures.size() == 1; }));
  for (const SavedNews& saved : seen.saved)
    if (saved.path.ends_with("a.png")) {
      EXPECT_THAT(saved.command, HasSubstr("sluice render synth:shells,dims=40x36x32 "));
    }
  EXPECT_TRUE(std::filesystem::exists(folder / "a.png"));
  EXPECT_TRUE(std::filesystem::exists(folder / "b.txt"));
}

TEST(DrawingThread, playsASeries) {
  DrawingThread desk(drawingOptions());
  Seen seen(desk);
  ASSERT_TRUE(seen.open(kSeries));
  Wish wish = seen.wish();
  for (int64_t time = 0; time < 8; ++time) {
    wish.state.time = time % 4;
    wish.next_time = (time + 1) % 4;
    ASSERT_TRUE(seen.whole(desk.wish(wish)));
    EXPECT_EQ(seen.picture->state.time, time % 4);
  }
  EXPECT_THAT(seen.failures, IsEmpty());
}

TEST(DrawingThread, reportsLevelsWithMaps) {
  DrawingThread desk(drawingOptions());
  Seen seen(desk);
  ASSERT_TRUE(seen.open(kVolume));
  ASSERT_TRUE(seen.whole(desk.wish(seen.wish())));
  desk.wantReport(true);
  ASSERT_TRUE(seen.until([&] { return seen.report != nullptr; }));
  const RenderReport& report = *seen.report;
  EXPECT_EQ(report.page_chunks.size(), report.pages);
  EXPECT_EQ(report.volume_buffer.requests, report.volume_buffer.hits + report.volume_buffer.misses);
  EXPECT_LE(report.texture_cache.current_bytes, report.texture_cache.budget_bytes);
  uint64_t used = 0;
  for (const uint32_t chunk : report.page_chunks) used += chunk > 0 ? 1 : 0;
  EXPECT_EQ(used * report.page_bytes, report.texture_cache.current_bytes);
  int64_t shown = 0;
  for (const uint8_t kind : report.block_classes) shown += kind > 0 ? 1 : 0;
  EXPECT_EQ(shown, report.grey + report.black);
}

// A test for ThreadSanitizer: wishes of windows from several threads at once, and an end in the
// middle.
TEST(DrawingThread, standsWishesFromSeveralThreads) {
  std::atomic<int> told{0};
  DrawingOptions made = drawingOptions();
  made.on_news = [&told] { ++told; };
  {
    DrawingThread desk(made);
    Seen seen(desk);
    ASSERT_TRUE(seen.open(kVolume));
    const Wish first = seen.wish(48, 40);
    const auto range = seen.opened->info.value_range;
    std::atomic<int> turns{0};
    const auto drive = [&] {
      for (int i = 0; i < 80; ++i) {
        const int turn = turns++;
        Wish wish = first;
        wish.moves = turn % 3 != 0;
        wish.state.view = orbit(wish.state.view, turn, 0, {48, 40});
        wish.state.shows_slices = turn % 5 == 0;
        if (turn % 2 == 0)
          wish.state.look = withThreshold({}, range[0] + (range[1] - range[0]) * (turn % 50) / 60);
        desk.wish(wish);
        if (turn % 7 == 0) desk.probe(0.5, 0.5);
        if (turn % 11 == 0) desk.wantReport(turn % 2 == 0);
        if (turn % 40 == 13) desk.place(first.state, 40, 40);
        desk.take();
        desk.status();
      }
    };
    std::vector<std::thread> threads = startThreads(3, drive);
    for (std::thread& thread : threads) thread.join();
    ViewedVolume other;
    other.paths = {kVolume};
    desk.open(other, std::nullopt);
  }
  EXPECT_GT(told, 0);
}

}  // namespace
}  // namespace sluice
