// Files that the drawing thread writes: pictures by their names' ends, and films while other
// requests come in.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <map>
#include <thread>

#include "src/base/error.h"
#include "src/base/files/file_kind.h"
#include "src/base/threads/threads.h"
#include "src/view/drawing/drawing_thread.h"
#include "src/view/state/files/state_file.h"
#include "tests/support/temp_folder.h"

namespace sluice {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

namespace fs = std::filesystem;

// A desk with a small volume open, and its news.
class Writer {
 public:
  explicit Writer(DrawingOptions options = {}) : desk_(withCpu(std::move(options))) {
    ViewedVolume volume;
    volume.paths = {"synth:shells,dims=24x20x16"};
    desk_.open(volume, std::nullopt);
    EXPECT_TRUE(wait([&] { return opened != nullptr; }));
  }

  template <class Until>
  bool wait(const Until& done) {
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(60);
    while (!done() && std::chrono::steady_clock::now() < end) {
      News news = desk_.take();
      if (news.opened) opened = std::move(news.opened);
      if (news.look) ++looks;
      for (std::string& line : news.notes) notes.push_back(std::move(line));
      for (SavedNews& each : news.saved) saved.push_back(std::move(each));
      for (std::string& line : news.failures) failures.push_back(std::move(line));
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return done();
  }
  // A failure's line, or the file saved.
  std::string outcome() {
    saved.clear();
    failures.clear();
    EXPECT_TRUE(wait([&] { return !saved.empty() || !failures.empty(); }));
    return failures.empty() ? "saved " + saved.front().path : failures.front();
  }
  void openOther() {
    ViewedVolume other;
    other.paths = {"synth:shells,dims=16x16x16"};
    desk_.open(other, std::nullopt);
  }
  bool waitForOther() {
    return wait([&] { return opened->volume.paths.front().ends_with("16x16x16"); });
  }
  FilmWish film(const std::string& name, int64_t frames) const {
    FilmWish wish;
    wish.name = name;
    wish.path.turn_frames = frames;
    wish.now = opened->state;
    wish.width = 40;
    wish.height = 32;
    return wish;
  }
  Wish wish() const {
    Wish made;
    made.state = opened->state;
    made.width = 48;
    made.height = 40;
    return made;
  }
  DrawingThread& desk() { return desk_; }

  std::unique_ptr<OpenedVolumeNews> opened;
  std::vector<SavedNews> saved;
  std::vector<std::string> failures, notes;
  int looks = 0;

 private:
  static DrawingOptions withCpu(DrawingOptions options) {
    options.renderer.device = RendererOptions::Device::kCpu;
    options.renderer.threads = 2;
    options.renderer.memory_bytes = uint64_t{64} << 20;
    return options;
  }
  DrawingThread desk_;
};

size_t filesIn(const fs::path& folder) {
  return static_cast<size_t>(
      std::distance(fs::directory_iterator(folder), fs::directory_iterator()));
}

std::string startOf(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::string start(4, '\0');
  file.read(start.data(), 4);
  return start;
}

TEST(DrawingSaves, theNamesEndSaysTheKindOfPicture) {
  const TempFolder folder;
  Writer writer;
  const auto save = [&](const std::string& name) {
    writer.desk().savePicture((folder / name).string(), writer.wish());
    return writer.outcome();
  };
  EXPECT_THAT(save("a.PNG"), HasSubstr("saved"));
  EXPECT_EQ(startOf(folder / "a.PNG"), "\x89PNG");
  EXPECT_THAT(save("a b.exr"), HasSubstr("saved"));
  EXPECT_EQ(startOf(folder / "a b.exr"), "\x76\x2f\x31\x01");
  EXPECT_THAT(writer.saved.front().command, HasSubstr("a b.exr'"));
  EXPECT_THAT(save("a.jpg"), HasSubstr("a.jpg: pictures are written as .png or .exr"));
  EXPECT_THAT(save("no such/a.png"), HasSubstr("no such"));
  // A place for a number takes the time step's, as the command's does.
  EXPECT_THAT(save("t_%02d.png"), HasSubstr("t_00.png"));
  EXPECT_THAT(save("100%.png"), HasSubstr("one place for the number"));
  EXPECT_EQ(filesIn(folder.path()), 3U);
}

TEST(DrawingSaves, aTextNeedsNoVolumeAndIsWrittenAtTheEnd) {
  const TempFolder folder;
  {
    DrawingThread desk{DrawingOptions{}};
    for (int i = 0; i < 20; ++i)
      desk.saveText((folder / fmt::format("{}.json", i)).string(), fmt::format("text {}", i), {});
  }
  for (int i = 0; i < 20; ++i)
    EXPECT_EQ(readFile(folder / fmt::format("{}.json", i)), fmt::format("text {}", i));
}

TEST(DrawingSaves, aFilmIsItsFramesAndTheViewThatTheyAreMadeOf) {
  const TempFolder folder;
  Writer writer;
  writer.desk().writeFrames(writer.film((folder / "it's_%02d.png").string(), 5));
  EXPECT_THAT(writer.outcome(), HasSubstr("saved"));
  EXPECT_EQ(writer.saved.front().command, "sluice render --state='" + folder.path().string() +
                                              "/it'\\''s.json' --size 40x32 -o '" +
                                              folder.path().string() + "/it'\\''s_%02d.png'");
  EXPECT_EQ(filesIn(folder.path()), 6U);
  EXPECT_TRUE(fs::exists(folder / "it's_04.png"));
  const StateFile state = readState(folder / "it's.json");
  ASSERT_TRUE(state.path);
  EXPECT_EQ(state.path->turn_frames, 5);
  EXPECT_EQ(writer.desk().status().frames, 0);
}

TEST(DrawingSaves, framesOfOtherLooksAreNotShown) {
  const TempFolder folder;
  Writer writer;
  ASSERT_TRUE(writer.wait([&] { return writer.desk().status().completed == 0; }));
  FilmWish film = writer.film((folder / "f_%d.png").string(), 1);
  film.path.kind = ViewPath::Kind::kKeys;
  film.path.frames_per_second = 4;
  for (const double threshold : {10.0, 90.0}) {
    ViewState state = writer.opened->state;
    state.look.threshold = threshold;
    film.path.keys.push_back({state, 1});
  }
  const int looks = writer.looks;
  writer.desk().writeFrames(film);
  EXPECT_THAT(writer.outcome(), HasSubstr("saved"));
  EXPECT_EQ(filesIn(folder.path()), 6U);
  EXPECT_EQ(writer.looks, looks);
  EXPECT_NE(fs::file_size(folder / "f_0.png"), fs::file_size(folder / "f_4.png"));
}

TEST(DrawingSaves, aCancelledFilmLeavesWhatIsThereAndNoHalfFile) {
  const TempFolder folder;
  Writer writer;
  writer.desk().writeFrames(writer.film((folder / "f_%04d.png").string(), 10'000));
  ASSERT_TRUE(writer.wait([&] { return writer.desk().status().frames_written >= 3; }));
  writer.desk().cancelFrames();
  ASSERT_TRUE(
      writer.wait([&] { return writer.desk().status().doing == DeskStatus::Doing::kNothing; }));
  const size_t files = filesIn(folder.path());
  EXPECT_GE(files, 4U);
  EXPECT_LT(files, 10'000U);
  for (const fs::directory_entry& entry : fs::directory_iterator(folder.path()))
    EXPECT_NE(entry.path().extension(), ".tmp");
  std::this_thread::sleep_for(std::chrono::milliseconds(50));
  EXPECT_EQ(filesIn(folder.path()), files);
}

// Its pictures may be whole while the hand still moves: then only the rest tells when frames go on.
TEST(DrawingSaves, aFilmBeginsWhenAHandRestsWhosePreviewWasWhole) {
  const TempFolder folder;
  DrawingOptions options;
  options.budget_s = 60;  // previews are whole
  options.rest_s = 0.5;
  Writer writer(options);
  Wish wish = writer.wish();
  wish.moves = true;
  const uint64_t number = writer.desk().wish(wish);
  ASSERT_TRUE(writer.wait([&] { return writer.desk().status().completed == number; }));
  writer.desk().writeFrames(writer.film((folder / "f_%d.png").string(), 2));
  EXPECT_THAT(writer.outcome(), HasSubstr("saved"));
}

// Drives it like a window: moving wishes, other films and cancels, from two threads at once.
TEST(DrawingSaves, aFilmGoesOnBesideAHandThatMoves) {
  const TempFolder folder;
  Writer writer;
  const Wish first = writer.wish();
  writer.desk().writeFrames(writer.film((folder / "a_%04d.png").string(), 10'000));
  {
    std::vector<std::thread> hands;
    hands.push_back(startThread([&] {
      Wish wish = first;
      for (int i = 0; i < 60; ++i) {
        wish.state.view = turn(wish.state.view, 3);
        wish.moves = i % 10 != 9;
        writer.desk().wish(wish);
        std::this_thread::sleep_for(std::chrono::milliseconds(3));
      }
    }));
    hands.push_back(startThread([&] {
      for (int i = 0; i < 20; ++i) {
        std::this_thread::sleep_for(std::chrono::milliseconds(8));
        if (i % 7 == 3) writer.desk().cancelFrames();
        if (i % 7 == 5)
          writer.desk().writeFrames(writer.film((folder / "b_%02d.png").string(), 12));
      }
    }));
    for (std::thread& hand : hands) hand.join();
  }
  writer.desk().writeFrames(writer.film((folder / "c_%02d.png").string(), 6));
  ASSERT_TRUE(writer.wait(
      [&] { return !writer.saved.empty() && writer.saved.back().path.ends_with("c_%02d.png"); }));
  EXPECT_THAT(writer.failures, IsEmpty());
  for (int i = 0; i < 6; ++i)
    EXPECT_TRUE(fs::exists(folder / ("c_0" + std::to_string(i) + ".png"))) << i;
  const uint64_t number = writer.desk().wish(first);
  EXPECT_TRUE(writer.wait([&] { return writer.desk().status().completed >= number; }));
}

TEST(DrawingSaves, aTextReplacesAFileOfItsOwnKindAlone) {
  const TempFolder folder;
  Writer writer;
  const std::string view = stateText({}, {}), transfer = R"({"sluice_transfer_function": 1})";
  const std::map<std::string, std::string> others{
      {"notes.txt", "my notes"},
      {"package.json", R"({"name": "mine", "version": "1.0.0"})"},
      {"detached.nrrd", "NRRD0004\ntype: uchar\ndata file: voxels.raw\n\n"},
      {"window.log", "{\"opened\":\"a.nrrd\"}\n{\"end\":true}\n"}};
  const auto save = [&](const std::string& name, const std::string& text, FileKind kind) {
    writer.desk().saveText((folder / name).string(), text, kind);
    return writer.outcome();
  };
  for (const auto& [name, content] : others) {
    folder.write(name, content);
    EXPECT_THAT(save(name, view, FileKind::kView), HasSubstr(name + ": exists and is not a view"));
    EXPECT_THAT(save(name, transfer, FileKind::kTransferFunction),
                HasSubstr(name + ": exists and is not a transfer function"));
    EXPECT_EQ(readFile(folder / name), content);
  }
  for (int i = 0; i < 2; ++i) {
    EXPECT_THAT(save("view.json", view, FileKind::kView), HasSubstr("saved"));
    EXPECT_THAT(save("colors.json", transfer, FileKind::kTransferFunction), HasSubstr("saved"));
  }
  EXPECT_THAT(save("colors.json", view, FileKind::kView), HasSubstr("is not a view"));
  EXPECT_THAT(save("view.json", transfer, FileKind::kTransferFunction), HasSubstr("is not a tran"));
  // The view that a film is written with.
  folder.write("f.json", "{}");
  writer.desk().writeFrames(writer.film((folder / "f_%d.png").string(), 2));
  EXPECT_THAT(writer.outcome(), HasSubstr("f.json: exists and is not a view"));
  EXPECT_FALSE(fs::exists(folder / "f_0.png"));
}

TEST(DrawingSaves, whatMustNotBeWrittenIsNot) {
  const TempFolder folder;
  DrawingOptions options;
  std::vector<std::string> asked;
  options.check_outputs = [&](const std::vector<std::string>& reads,
                              const std::vector<std::string>& writes) {
    asked = writes;
    EXPECT_EQ(reads.front(), "synth:shells,dims=24x20x16");
    fail("not there");
  };
  Writer writer(options);
  writer.desk().savePicture((folder / "a.png").string(), writer.wish());
  EXPECT_THAT(writer.outcome(), HasSubstr("not there"));
  writer.desk().saveText((folder / "a.json").string(), "{}", FileKind::kView);
  EXPECT_THAT(writer.outcome(), HasSubstr("not there"));
  writer.desk().writeFrames(writer.film((folder / "a_%d.png").string(), 3));
  EXPECT_THAT(writer.outcome(), HasSubstr("not there"));
  EXPECT_EQ(asked.size(), 4U);  // three frames, and the view
  EXPECT_EQ(filesIn(folder.path()), 0U);
  // A film that cannot be is refused before anything is asked.
  writer.desk().writeFrames(writer.film((folder / "a.png").string(), 3));
  EXPECT_THAT(writer.outcome(), HasSubstr("a place for their numbers"));
  FilmWish empty = writer.film((folder / "a_%d.png").string(), 3);
  empty.path.kind = ViewPath::Kind::kKeys;
  writer.desk().writeFrames(empty);
  EXPECT_THAT(writer.outcome(), HasSubstr("add a view first"));
}

TEST(DrawingSaves, picturesAreOfTheVolumeThatTheyWereAskedFor) {
  const TempFolder folder;
  Writer writer;
  constexpr size_t kPictures = 12;
  // The window takes no news meanwhile, so that all of them show the first volume there.
  for (size_t i = 0; i < kPictures; ++i) {
    if (i == 2) writer.openOther();
    if (i > 3) std::this_thread::sleep_for(std::chrono::milliseconds(3));
    writer.desk().savePicture((folder / fmt::format("{}.png", i)).string(), writer.wish());
  }
  ASSERT_TRUE(
      writer.wait([&] { return writer.saved.size() + writer.failures.size() == kPictures; }));
  ASSERT_TRUE(writer.waitForOther());
  EXPECT_GE(writer.saved.size(), 2U);
  for (const SavedNews& saved : writer.saved)
    EXPECT_THAT(saved.command, HasSubstr("dims=24x20x16")) << saved.path;
  for (const std::string& line : writer.failures)
    EXPECT_THAT(line, HasSubstr(".png is not saved: another volume was opened first"));
  EXPECT_EQ(filesIn(folder.path()), writer.saved.size());
  writer.desk().savePicture((folder / "new.png").string(), writer.wish());
  EXPECT_THAT(writer.outcome(), HasSubstr("new.png"));
  EXPECT_THAT(writer.saved.front().command, HasSubstr("dims=16x16x16"));
}

TEST(DrawingSaves, aFilmThatAnotherVolumeEndsIsNamed) {
  const TempFolder folder;
  Writer writer;
  const FilmWish film = writer.film((folder / "f_%04d.png").string(), 10'000);
  writer.desk().writeFrames(film);
  ASSERT_TRUE(writer.wait([&] { return writer.desk().status().frames_written >= 3; }));
  writer.openOther();
  ASSERT_TRUE(writer.wait([&] { return !writer.failures.empty(); }));
  EXPECT_THAT(writer.failures.front(), HasSubstr("f_%04d.png: "));
  EXPECT_THAT(writer.failures.front(),
              HasSubstr(" of 10000 frames are written; another volume was opened"));
}

TEST(DrawingSaves, theEndNamesWhatIsNotWritten) {
  const TempFolder folder;
  Writer writer;
  Wish large = writer.wish();
  large.width = large.height = 4000;
  for (const char* name : {"a.png", "b.png"})
    writer.desk().savePicture((folder / name).string(), large);
  writer.desk().saveText((folder / "no such" / "t.json").string(), "{}", FileKind::kView);
  EXPECT_THAT(writer.desk().end(),
              testing::ElementsAre(HasSubstr("no such"),
                                   HasSubstr("a.png is not saved: the window ended first"),
                                   HasSubstr("b.png is not saved: the window ended first")));
}

TEST(DrawingSaves, aTraceEndsWithItsVolumeAndALine) {
  const TempFolder folder;
  DrawingOptions options;
  options.trace_file = (folder / "t.txt").string();
  Writer writer(options);
  const uint64_t number = writer.desk().wish(writer.wish());
  ASSERT_TRUE(writer.wait([&] { return writer.desk().status().completed >= number; }));
  EXPECT_FALSE(fs::exists(options.trace_file));
  writer.openOther();
  ASSERT_TRUE(writer.waitForOther());
  EXPECT_THAT(writer.notes, testing::ElementsAre(HasSubstr("t.txt: the trace ends")));
  EXPECT_TRUE(fs::exists(options.trace_file));
  EXPECT_THAT(writer.desk().end(), IsEmpty());
}

TEST(DrawingSaves, aTraceThatCannotBeWrittenIsNamedAtTheEnd) {
  const TempFolder folder;
  DrawingOptions options;
  fs::create_directory(folder / "gone");
  options.trace_file = (folder / "gone" / "t.txt").string();
  Writer writer(options);
  const uint64_t number = writer.desk().wish(writer.wish());
  ASSERT_TRUE(writer.wait([&] { return writer.desk().status().completed >= number; }));
  fs::remove_all(folder / "gone");
  EXPECT_THAT(writer.desk().end(), testing::ElementsAre(HasSubstr("t.txt")));
}

}  // namespace
}  // namespace sluice
