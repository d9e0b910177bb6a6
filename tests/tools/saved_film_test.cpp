// Frames of a saved path: as many as the user asks for, options without effect, and conflicts of
// the user's options with the file's.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/tools/program.h"

namespace sluice::saved_film_test {

using testing::HasSubstr;
using testing::Not;

constexpr const char* kVolume = "synth:shells,dims=24x20x16";

// Half a second from one eye to another: 6 frames of 10 a second.
std::string filmOf(const std::string& look) {
  return R"({"sluice": "view", "look": {)" + look +
         R"(}, "path": {"kind": "keys", "rate": 10, "keys": [
    {"seconds": 0.5, "camera": {"eye": [12, 10, 100], "target": [12, 10, 8]}, "look": {)" +
         look + R"(}},
    {"camera": {"eye": [100, 10, 8], "target": [12, 10, 8]}, "look": {)" +
         look + "}}]}}";
}

class SavedFilm : public testing::Test {
 protected:
  void write(const std::string& name, const std::string& text) const {
    writeFile(program_.folder / name, text);
  }
  CommandResult render(const std::string& options) const {
    return program_.run(std::string("render ") + kVolume +
                        " --state film.json --size 32 --device cpu --force " + options);
  }
  std::string picture(const std::string& name) const { return readFile(program_.folder / name); }
  const Program program_;
};

TEST_F(SavedFilm, framesCountsPicturesAlongThePathAtEqualTimes) {
  write("film.json", filmOf(R"("threshold": 40)"));
  ASSERT_EQ(render("-o all_%d.png -q").output, "");
  EXPECT_TRUE(program_.exists("all_5.png"));
  EXPECT_FALSE(program_.exists("all_6.png"));
  // 11 pictures are twice as dense, and every second one is a frame of the path.
  ASSERT_EQ(render("-o more_%d.png --frames 11 -q").output, "");
  EXPECT_FALSE(program_.exists("more_11.png"));
  for (int i = 0; i < 6; ++i)
    EXPECT_EQ(picture(fmt::format("all_{}.png", i)), picture(fmt::format("more_{}.png", 2 * i)))
        << i;
  EXPECT_NE(picture("more_0.png"), picture("more_1.png"));
  ASSERT_EQ(render("-o one_%d.png --frames 1 -q").output, "");
  EXPECT_EQ(picture("one_0.png"), picture("all_0.png"));
  EXPECT_FALSE(program_.exists("one_1.png"));
  // A name without a number gets one.
  ASSERT_EQ(render("-o plain.png --frames 2 -q").status, 0);
  EXPECT_FALSE(program_.exists("plain.png"));
  // A turn gets as many.
  write("film.json", R"({"sluice": "view", "path": {"kind": "turn", "frames": 2}})");
  ASSERT_EQ(render("-o turn_%d.png --frames 3 -q").output, "");
  EXPECT_TRUE(program_.exists("turn_2.png"));
  EXPECT_FALSE(program_.exists("turn_3.png"));
}

TEST_F(SavedFilm, framesOfOneKeyFrameAreRefused) {
  write("film.json", R"({"sluice": "view", "path": {"kind": "keys", "keys": [
      {"camera": {"eye": [12, 10, 100], "target": [12, 10, 8]}}]}})");
  const CommandResult refused = render("-o f_%d.png --frames 3");
  EXPECT_EQ(refused.status, 1);
  EXPECT_THAT(refused.output, HasSubstr("film.json: the saved path has one key frame"));
  EXPECT_EQ(render("-o f_%d.png -q").output, "");
}

TEST_F(SavedFilm, optionsThatChangeNothingAreNamed) {
  write("film.json", filmOf(R"("surfaces": ["40:0.5"])"));
  for (const char* option : {"--attenuation 1", "--combine blend", "--quality high"}) {
    const std::string name = std::string(option).substr(0, std::string(option).find(' '));
    EXPECT_THAT(render(std::string("-o f_%d.png ") + option).output,
                HasSubstr("warning: " + std::string(kVolume) + ": " + name + " changes nothing"));
    EXPECT_EQ(render(std::string("-o f_%d.png -q ") + option).output, "");
  }
  EXPECT_THAT(render("-o f_%d.png --shade").output, Not(HasSubstr("changes nothing")));
  write("film.json", R"({"sluice": "view", "path": {"kind": "turn", "frames": 2}})");
  EXPECT_THAT(render("-o f_%d.png --attenuation 1").output,
              HasSubstr("--attenuation changes nothing"));
}

// Advice that helps: what is named is what the user gave.
TEST_F(SavedFilm, refusalsNameWhatTheUserGave) {
  write("film.json", filmOf(R"("threshold": 40)"));
  EXPECT_THAT(render("-o a.png --frames 2 --verify").output,
              HasSubstr("do not take it; leave out --frames for one picture"));
  EXPECT_THAT(render("-o f_%d.png --verify").output,
              HasSubstr("give -o a name without a number for one picture"));
  EXPECT_THAT(render("-o f_%d.png --memory 64K").output,
              testing::AllOf(HasSubstr("give --memory "), Not(HasSubstr("memory_bytes")),
                             Not(HasSubstr("pipeline"))));
  ASSERT_EQ(render("-o g_%d.png --frames 1 -q").status, 0);
  const std::string kept = render("-o g_%d.png --frames 2 --continue").output;
  EXPECT_THAT(kept, HasSubstr("1 of 2 pictures is there"));
  EXPECT_THAT(kept, Not(HasSubstr("--report"))) << "which frames of a path refuse";
  write(
      "path.json",
      R"({"keys": [{"at": 0, "azimuth": 0, "elevation": 0}, {"at": 1, "azimuth": 90, "elevation": 0}]})");
  EXPECT_THAT(render("-o f_%d.png --frames 2 --path path.json").output,
              HasSubstr("the saved path is left out: --path takes its place"));
}

TEST_F(SavedFilm, conflictsNameTheOptionAndThePlaceInTheFile) {
  write("film.json", filmOf(R"("surfaces": ["40:0.5"])"));
  for (const char* output : {"f_%d.png", "f.png"})
    for (const std::string option : {"--label 3=red", "--labels"}) {
      const CommandResult refused = render(std::string("-o ") + output + " " + option);
      EXPECT_EQ(refused.status, 1);
      EXPECT_EQ(refused.output,
                "sluice: film.json: /look/surfaces draws surfaces between values, which labels do "
                "not have; leave out " +
                    option.substr(0, option.find(' ')) + "\n");
    }
  write("film.json", filmOf(R"("labels": true)"));
  EXPECT_EQ(render("-o f.png --iso 40").output,
            "sluice: film.json: --iso draws surfaces between values, which labels do not have; "
            "leave out /look/labels\n");
}

}  // namespace sluice::saved_film_test
