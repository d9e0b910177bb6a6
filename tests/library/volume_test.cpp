// Volume and Image: the properties of a volume, errors that name the file, wrong options.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <stdexcept>
#include <utility>

#include "tests/library/library_support.h"
#include "tests/support/error_of.h"

namespace sluice {
namespace {

using testing::AllOf;
using testing::HasSubstr;

TEST(Volume, saysWhatIsKnownOfIt) {
  const Volume volume(kShells);
  const VolumeInfo& info = volume.info();
  EXPECT_EQ(info.dims, (std::array<int64_t, 3>{48, 40, 36}));
  EXPECT_EQ(info.type, "u8");
  EXPECT_EQ(info.time_steps, 1);
  EXPECT_LT(info.value_range[0], info.value_range[1]);
  EXPECT_TRUE(info.warnings.empty()) << info.warnings.front();
}

TEST(Volume, errorsNameTheFile) {
  const TempFolder folder;
  const auto missing = (folder / "none.nrrd").string();
  EXPECT_THAT(errorOf([&] { Volume volume(missing); }), HasSubstr(missing));
  const auto unknown = folder.write("notes.txt", "words").string();
  EXPECT_THAT(errorOf([&] { Volume volume(unknown); }), HasSubstr(unknown));
  const auto cut = folder.write("a_8x8x8_uint8.raw", std::string(100, 'a')).string();
  EXPECT_THAT(errorOf([&] { Volume volume(cut); }), AllOf(HasSubstr(cut), HasSubstr("512")));
  const auto short_name = (folder / "a_8x8x8_uint8.raw/b").string();
  EXPECT_THAT(errorOf([&] { Volume volume(short_name); }), HasSubstr(short_name));
}

TEST(Volume, ofOneVoxelIsOpenedWithAWarning) {
  const TempFolder folder;
  const Volume voxel(folder.write("voxel_1x1x1_uint8.raw", "a").string());
  ASSERT_EQ(voxel.info().warnings.size(), 1U);
  EXPECT_THAT(voxel.info().warnings[0], HasSubstr("one voxel along x, y, z"));
}

TEST(Volume, optionsThatAreNoneThrow) {
  const TempFolder folder;
  const auto raw = folder.write("a_8x8x8_uint8.raw", std::string(512, 'a')).string();
  const std::vector<std::pair<VolumeOptions, std::string>> wrong = {
      {{.dims = {{0, 8, 8}}}, "a_8x8x8"},
      {{.dims = {{-8, 8, 8}}}, "a_8x8x8"},
      {{.dims = {{INT64_MAX, INT64_MAX, 8}}}, "a_8x8x8"},
      {{.dims = {{8, 8, 8}}, .skip_bytes = 1}, "a_8x8x8"},
      {{.dims = {{8, 8, 8}}, .time_steps = 0}, "a_8x8x8"},
      {{.dims = {{8, 8, 8}}, .time_steps = INT64_MAX}, "a_8x8x8"},
      {{.type = "u9"}, "u9"},
      {{.skip_bytes = -1}, "skip"},
      {{.spacing = {{1, 0, 1}}}, "spacing"},
      {{.spacing = {{1, kNan, 1}}}, "spacing"},
      {{.grid = "density"}, "density"},
      {{.channel = 3}, "channel"},
      {{.time_steps = 2}, "time_steps 2: describes a raw file together with dims"},
      {{.time = 1}, "time"},
      {{.time = -1}, "time"},
      {{.memory_bytes = 1}, "memory"},
      {{.threads = -1}, "threads"},
      {{.threads = 1 << 20}, "threads"}};
  for (const auto& [options, word] : wrong)
    EXPECT_THAT(errorOf([&, &given = options] { Volume volume(raw, given); }), HasSubstr(word));
  EXPECT_THROW(Volume(std::vector<std::string>{}), Error);
  EXPECT_THROW(Volume(""), Error);
  EXPECT_THROW(Volume(std::vector<std::string>{raw, raw + "none"}), Error);
  Volume good(raw);
  const Volume moved = std::move(good);
  EXPECT_THROW(good.info(), Error);              // NOLINT(bugprone-use-after-move): what is tested
  EXPECT_THROW(Renderer renderer(good), Error);  // NOLINT(bugprone-use-after-move)
  EXPECT_EQ(moved.info().dims[0], 8);
}

TEST(Volume, tellsProgressOfThePassAndKeepsTheIndexWhereAFolderIsNamed) {
  const TempFolder folder;
  const VolumeOptions options{.index_folder = folder / "index"};
  std::vector<Progress> told;
  const auto tell = [&](const Progress& so_far) { told.push_back(so_far); };
  Volume(kShells, options, tell);
  ASSERT_FALSE(told.empty());
  for (const Progress& so_far : told) EXPECT_EQ(so_far.stage, Progress::Stage::kIndexing);
  EXPECT_EQ(told.back().share(), 1);
  told.clear();
  Volume(kShells, options, tell);
  EXPECT_TRUE(told.empty()) << "the index is there";
  Volume(kShells, {}, tell);
  EXPECT_FALSE(told.empty()) << "no folder, no index";
}

TEST(Volume, unpackingTellsProgressAndCanBeCalledOff) {
  const TempFolder folder;
  if (!haveProgram("gzip")) GTEST_SKIP() << "gzip is not here";
  const auto raw = folder.write("a_128x128x128_uint8.raw", std::string(1 << 21, 'a')).string();
  ASSERT_EQ(runCommand("gzip -c " + shellQuoted(raw) + " > " + shellQuoted(raw + ".gz")).status, 0);
  bool unpacked = false;
  Volume(raw + ".gz", {.dims = {{128, 128, 128}}, .type = "u8"}, [&](const Progress& so_far) {
    unpacked = unpacked || so_far.stage == Progress::Stage::kDecoding;
  });
  EXPECT_TRUE(unpacked);
  std::stop_source stop;
  EXPECT_THROW(Volume(
                   raw + ".gz", {.dims = {{128, 128, 128}}, .type = "u8"},
                   [&](const Progress&) { stop.request_stop(); }, stop.get_token()),
               Cancelled);
}

TEST(Volume, anOpeningThatIsCalledOffIsCancelled) {
  std::stop_source before;
  before.request_stop();
  EXPECT_THROW(Volume(kShells, {}, {}, before.get_token()), Cancelled);
  std::stop_source during;
  EXPECT_THROW(Volume(
                   "synth:shells,dims=200x200x200", {},
                   [&](const Progress&) { during.request_stop(); }, during.get_token()),
               Cancelled);
  EXPECT_THROW(Volume(kShells, {}, [](const Progress&) { throw std::out_of_range("mine"); }),
               std::out_of_range);
}

TEST(Volume, anIndexThatCannotBeKeptIsAWarning) {
  const TempFolder folder;
  const auto in_the_way = folder.write("index", "a file").string();
  const Volume volume(kShells, {.index_folder = in_the_way});
  ASSERT_EQ(volume.info().warnings.size(), 1U);
  EXPECT_THAT(volume.info().warnings.front(), HasSubstr(in_the_way));
}

TEST(Volume, makesCoarserLevelsIfAskedTo) {
  using Levels = VolumeOptions::Levels;
  const TempFolder folder;
  const auto file = folder.write("a_96x96x96_uint8.raw", std::string(96 * 96 * 96, 'a')).string();
  const auto levelsFor = [&](Levels levels) {
    return Volume(file, {.index_folder = (folder / "index").string(), .levels = levels})
        .info()
        .levels;
  };
  EXPECT_EQ(levelsFor(Levels::kKept), 1);
  EXPECT_EQ(levelsFor(Levels::kAuto), 1) << "it is small";
  const int made = levelsFor(Levels::kAlways);
  EXPECT_GT(made, 1);
  EXPECT_EQ(levelsFor(Levels::kKept), made);
  EXPECT_EQ(levelsFor(Levels::kNone), 1);
  EXPECT_THAT(errorOf([&] { levelsFor(static_cast<Levels>(9)); }), HasSubstr("levels 9"));
}

TEST(Image, isWrittenOverABackgroundOrNot) {
  const TempFolder folder;
  const Image image{2, 1, {0.5F, 0, 0, 0.5F, 0, 0, 0, 0}, {}};
  EXPECT_EQ(image.toRgba8(), (std::vector<uint8_t>{255, 0, 0, 128, 0, 0, 0, 0}));
  const std::array<float, 3> blue{0, 0, 1};
  EXPECT_EQ(image.toRgba8(blue), (std::vector<uint8_t>{128, 0, 128, 255, 0, 0, 255, 255}));
  image.writePng(folder / "a.png", blue);
  EXPECT_EQ(readPng(folder / "a.png").rgba, image.toRgba8(blue));
  const std::string nowhere = folder / "none" / "a.png";
  EXPECT_THAT(errorOf([&] { image.writePng(nowhere); }), HasSubstr(nowhere));
  EXPECT_THROW((Image{2, 2, {0}, {}}.toRgba8()), Error);
  EXPECT_THROW(Image().toRgba8(), Error);
}

}  // namespace
}  // namespace sluice
