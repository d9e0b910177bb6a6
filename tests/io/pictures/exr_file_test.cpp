#include "io/pictures/exr_file.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "tests/io/image_test_support.h"

namespace sluice {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::HasSubstr;
using testing::Pair;

// Smooth in part, noisy in part, of values that halves do not all have.
Picture makePicture(int width, int height) {
  std::mt19937 random(4);
  Picture picture{width, height, {}, {}};
  for (int i = 0; i < width * height; ++i) {
    for (int c = 0; c < 4; ++c)
      picture.rgba.push_back(i % 3 == 0 ? static_cast<float>(random() % 1000) / 999.0F : 0.25F);
    picture.depth.push_back(static_cast<float>(i) * 0.37F + 1000.0F);
  }
  return picture;
}

const ExrAttributes kAttributes{{"sluice.camera", "azimuth 30"},
                                {"sluice.transfer", "{\"points\": [1]}"},
                                {"sluice.version", "1"}};

TEST(ExrFile, floatsComeBackAsWritten) {
  const TempFolder folder;
  const Picture picture = makePicture(37, 45);
  writeExr(folder / "a.exr", {picture, kAttributes}, ExrPrecision::kFloat);
  const ExrContents read = readExr(folder / "a.exr");
  EXPECT_EQ(read.picture.width, 37);
  EXPECT_EQ(read.picture.height, 45);
  EXPECT_EQ(read.picture.rgba, picture.rgba);
  EXPECT_EQ(read.picture.depth, picture.depth);
  for (const auto& [name, text] : kAttributes)
    EXPECT_THAT(read.attributes, Contains(Pair(name, text)));
}

TEST(ExrFile, isTheSameHoweverItsRowsCome) {
  const TempFolder folder;
  constexpr int kWidth = 37, kHeight = 45;
  const Picture picture = makePicture(kWidth, kHeight);
  const auto rows = [&](int first, int count) {
    Picture part{kWidth, count, {}, {}};
    const int64_t from = first * kWidth, to = (first + count) * kWidth;
    part.rgba.assign(picture.rgba.begin() + 4 * from, picture.rgba.begin() + 4 * to);
    part.depth.assign(picture.depth.begin() + from, picture.depth.begin() + to);
    return ExrContents{part, kAttributes, {}, {{"opacity", part.depth}}};
  };
  for (const ExrPrecision precision : {ExrPrecision::kHalf, ExrPrecision::kFloat}) {
    writeExr(folder / "whole.exr", rows(0, kHeight), precision);
    for (const int step : {1, 7, 32}) {
      ExrFile file(folder / "rows.exr", rows(0, step), kHeight, precision);
      for (int y = 0; y < kHeight; y += step) file.add(rows(y, std::min(step, kHeight - y)));
      file.commit();
      EXPECT_EQ(readFile(folder / "rows.exr"), readFile(folder / "whole.exr")) << step;
    }
  }
  { ExrFile file(folder / "left.exr", rows(0, 3), kHeight); }
  EXPECT_FALSE(std::filesystem::exists(folder / "left.exr"));
}

TEST(ExrFile, halvesAreTheNearest) {
  const TempFolder folder;
  Picture picture = makePicture(37, 45);
  picture.depth.clear();
  writeExr(folder / "a.exr", {picture});
  const Picture read = readExr(folder / "a.exr").picture;
  EXPECT_TRUE(read.depth.empty());
  for (size_t i = 0; i < picture.rgba.size(); ++i)
    ASSERT_LE(std::abs(read.rgba[i] - picture.rgba[i]), picture.rgba[i] / 2048) << i;
}

TEST(ExrFile, isUnderstoodByExrheader) {
  if (!haveProgram("exrheader")) GTEST_SKIP() << "exrheader is missing";
  const TempFolder folder;
  writeExr(folder / "a.exr", {makePicture(37, 45), kAttributes});
  const auto run = runCommand("exrheader " + (folder / "a.exr").string());
  EXPECT_EQ(run.status, 0);
  EXPECT_THAT(run.output,
              AllOf(HasSubstr("A, 16-bit floating-point"), HasSubstr("R, 16-bit floating-point"),
                    HasSubstr("Z, 32-bit floating-point"), HasSubstr("(0 0) - (36 44)"),
                    HasSubstr("sluice.camera (type string): \"azimuth 30\"")));
}

TEST(ExrFile, hasThePixelsThatTheFormatDescribes) {
  if (!hasPythonModules("numpy")) GTEST_SKIP() << "python3 with numpy is missing";
  const TempFolder folder;
  const Picture picture = makePicture(37, 45);
  writeExr(folder / "a.exr", {picture, kAttributes}, ExrPrecision::kFloat);
  const auto run = runCommand("/usr/bin/python3 " SLUICE_TEST_DIR "/read_exr.py " +
                              (folder / "a.exr").string() + " " + (folder / "a.bin").string());
  ASSERT_EQ(run.status, 0) << run.output;
  EXPECT_THAT(run.output,
              AllOf(HasSubstr("channel A float"), HasSubstr("attribute sluice.version 1")));
  std::vector<float> expected;  // by channel, in the order of their names
  for (const size_t c : {3, 2, 1, 0})
    for (size_t i = c; i < picture.rgba.size(); i += 4) expected.push_back(picture.rgba[i]);
  expected.insert(expected.end(), picture.depth.begin(), picture.depth.end());
  const std::string bytes = readFile(folder / "a.bin");
  std::vector<float> read(bytes.size() / sizeof(float));
  std::memcpy(read.data(), bytes.data(), bytes.size());
  EXPECT_EQ(read, expected);
}

const std::array<float, 16> kMatrix{1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16.5F};

ExrContents withAll() {
  ExrContents contents{makePicture(37, 45), kAttributes, {{"worldToCamera", kMatrix}}};
  contents.channels.push_back({"opacity", std::vector<float>(37 * 45, 0.75F)});
  contents.screen_window_width = 1.25F;
  return contents;
}

TEST(ExrFile, furtherChannelsAndMatricesComeBack) {
  const TempFolder folder;
  const ExrContents contents = withAll();
  writeExr(folder / "a.exr", contents, ExrPrecision::kFloat);
  const ExrContents read = readExr(folder / "a.exr");
  EXPECT_EQ(read.picture.rgba, contents.picture.rgba);
  EXPECT_EQ(read.matrices, contents.matrices);
  ASSERT_EQ(read.channels.size(), 1U);
  EXPECT_EQ(read.channels[0].name, "opacity");
  EXPECT_EQ(read.channels[0].values, contents.channels[0].values);
  EXPECT_EQ(read.screen_window_width, 1.25F);
}

TEST(ExrFile, isUnderstoodByOpenImageIo) {
  if (!hasPythonModules("numpy, OpenImageIO"))
    GTEST_SKIP() << "python3 with numpy and OpenImageIO is missing";
  const TempFolder folder;
  writeExr(folder / "a.exr", withAll(), ExrPrecision::kFloat);
  const auto run = runCommand("/usr/bin/python3 " SLUICE_TEST_DIR "/read_exr_oiio.py " +
                              (folder / "a.exr").string());
  ASSERT_EQ(run.status, 0) << run.output;
  EXPECT_THAT(run.output, HasSubstr("channels R G B A Z opacity"));
  EXPECT_THAT(run.output, HasSubstr("display 0 0 37 45\ndata 0 0 37 45\n"));
  EXPECT_THAT(run.output, HasSubstr("attribute PixelAspectRatio float 1"));
  EXPECT_THAT(run.output,
              HasSubstr("attribute worldToCamera matrix 1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16.5"));
}

TEST(ExrFile, namesOfThePicturesChannelsAreRefused) {
  const TempFolder folder;
  for (const char* name : {"R", "A", "Z", ""}) {
    ExrContents contents{makePicture(2, 2)};
    contents.channels.push_back({name, std::vector<float>(4)});
    EXPECT_THAT(errorOf([&] { writeExr(folder / "a.exr", contents); }),
                HasSubstr("cannot name a further channel"));
  }
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

TEST(ExrFile, refusesNamesThatOpenExrUses) {
  const TempFolder folder;
  for (const char* name : {"compression", "dataWindow", ""}) {
    EXPECT_THAT(errorOf([&] {
                  writeExr(folder / "a.exr", {makePicture(2, 2), {{name, "x"}}});
                }),
                HasSubstr("cannot name an attribute"));
  }
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

TEST(ExrFile, thatCannotBeWrittenIsAnError) {
  const TempFolder folder;
  EXPECT_THAT(errorOf([&] { writeExr(folder / "no" / "a.exr", {makePicture(2, 2)}); }),
              HasSubstr("a.exr"));
}

TEST(ExrFile, rejectsDamage) {
  const TempFolder folder;
  writeExr(folder / "a.exr", {makePicture(37, 45), kAttributes});
  EXPECT_THAT(errorOf([&] { readExr(folder / "none.exr"); }), HasSubstr("none.exr"));
  EXPECT_EQ(surviveDamage(folder / "a.exr", folder / "bad.exr", 100, 400,
                          [](const auto& path) { readExr(path); }),
            0);
}

}  // namespace
}  // namespace sluice
