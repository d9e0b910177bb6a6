// Levels of resolution as a user asks for them: which are drawn, what is said of it, what is
// refused.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "io/pictures/png_file.h"
#include "tests/tools/program.h"

namespace sluice {
namespace {

using nlohmann::json;
using testing::HasSubstr;
using testing::Not;

constexpr const char* kVolume = "synth:shells,dims=160x140x120,levels=4";
constexpr const char* kLook =
    "--threshold 60 --opacity 0.1 --no-shade --block 32 --view plain --azimuth 30 --size 64";

class LevelsCommand : public testing::Test {
 protected:
  static std::string arguments(const std::string& more) {
    return std::string(kVolume) + " " + kLook + " " + more;
  }
  json render(const std::string& more) const {
    return program_.json("render " + arguments("-o x.png --force " + more));
  }
  const Program program_;
};

TEST_F(LevelsCommand, aPictureIsDrawnAtTheLevelItsPixelsAskForAndSaysSo) {
  // 64 pixels show some 240 voxels: a voxel of level 1 is half a pixel wide, one of level 2 a
  // pixel.
  const json cut = render("--pixel-error 1")["cut"];
  ASSERT_EQ(cut["levels"].size(), 1U);
  EXPECT_EQ(cut["levels"][0]["level"], 1);
  EXPECT_EQ(cut["coarse_share"], 1.0);
  EXPECT_EQ(cut["final"], true);
  EXPECT_GT(cut["levels"][0]["blocks"], 0);
  EXPECT_GT(cut["levels"][0]["cells"], 0);
  EXPECT_EQ(render("--pixel-error 8")["cut"]["levels"][0]["level"], 3);
  const CommandResult said =
      program_.run("render " + arguments("-o x.png --force --pixel-error 1"));
  EXPECT_THAT(said.output, HasSubstr("100.0 % of what shows is drawn coarser than it is stored"));
  EXPECT_THAT(said.output, HasSubstr("at level 1 ("));
  EXPECT_THAT(said.output, HasSubstr("--step 2"));
}

TEST_F(LevelsCommand, levelZeroIsThePictureOfTheVolumeWithoutLevels) {
  EXPECT_FALSE(render("").contains("cut"));
  EXPECT_FALSE(render("--level 0").contains("cut"));
  const auto read = [&](const char* name) { return readPng(program_.folder / name).rgba; };
  const auto leveled = read("x.png");
  ASSERT_EQ(program_.run(std::string("render synth:shells,dims=160x140x120 -o plain.png ") + kLook)
                .status,
            0);
  EXPECT_EQ(leveled, read("plain.png"));
  const CommandResult said = program_.run("render " + arguments("-o x.png --force --level 0"));
  EXPECT_THAT(said.output, Not(HasSubstr("coarser")));
}

TEST_F(LevelsCommand, theLevelsHaveNearlyTheSamePicture) {
  const auto drawn = [&](const std::string& more) {
    render(more);
    return readPng(program_.folder / "x.png");
  };
  const auto finest = drawn("--level 0");
  for (const char* more : {"--pixel-error 1", "--level 1"}) {
    const auto coarse = drawn(more);
    double sum = 0, opaque = 0;
    for (size_t i = 3; i < finest.rgba.size(); i += 4) {
      sum += std::abs(static_cast<double>(finest.rgba[i]) - static_cast<double>(coarse.rgba[i]));
      opaque += static_cast<double>(finest.rgba[i]);
    }
    EXPECT_GT(opaque, 0);
    EXPECT_LT(sum, 0.03 * opaque) << more;
  }
}

TEST_F(LevelsCommand, aBudgetOfBytesEndsTheRefinement) {
  const json cut = render("--pixel-error 0.1 --max-bytes 600K")["cut"];
  EXPECT_EQ(cut["final"], false);
  EXPECT_GT(cut["coarse_share"], 0.0);
  const CommandResult said =
      program_.run("render " + arguments("-o x.png --force --pixel-error 0.1 --max-bytes 600K"));
  EXPECT_THAT(said.output, HasSubstr("a budget ended the refinement"));
}

TEST_F(LevelsCommand, aPlanAndASimulationHaveTheSameCut) {
  const std::string options = "--pixel-error 0.5 --projection perspective --zoom 3";
  const json plan = program_.json("plan " + arguments(options));
  EXPECT_EQ(plan["cut"], render(options)["cut"]);
  EXPECT_GE(plan["cut"]["levels"].size(), 2U);
  const auto read = [&](const std::string& more) {
    return program_.json("plan " + arguments(more))["read"]["voxel_bytes"].get<uint64_t>();
  };
  EXPECT_LT(2 * read("--pixel-error 1"), read(""));
  const auto bytes = [&](const std::string& more) {
    const json rows =
        program_.json("simulate " + arguments("--frames 2 --policies lru " + more))["rows"];
    return rows[0]["bytes_needed"].get<uint64_t>();
  };
  EXPECT_LT(bytes("--pixel-error 1"), bytes(""));
}

TEST_F(LevelsCommand, verifyDrawsTheSameCutThePlainWay) {
  const json report = render("--projection perspective --zoom 3 --pixel-error 1 --verify");
  EXPECT_LE(report["verify"]["max_difference"], 1.0);
}

TEST_F(LevelsCommand, whatKnowsTheFinestLevelAloneRefusesOthersInOneLine) {
  const CommandResult culling =
      program_.run("render " + arguments("-o x.png --level 1 --culling toc"));
  EXPECT_EQ(culling.status, 1);
  EXPECT_THAT(culling.output, HasSubstr("--culling draws the finest level alone"));
  EXPECT_EQ(program_.run("render " + arguments("-o x.png --level 1 --pixel-error 2")).status, 2);
  const CommandResult missing = program_.run("render " + arguments("-o x.png --level 4"));
  EXPECT_EQ(missing.status, 1);
  EXPECT_THAT(missing.output, HasSubstr("--level 4: there are 4 levels, counted from 0"));
}

TEST_F(LevelsCommand, volumesOfOneLevelAreDrawnAsEver) {
  const json report = program_.json(std::string("render ") + kSmall + " --size 32 -o one.png");
  EXPECT_FALSE(report.contains("cut"));
  const CommandResult other =
      program_.run(std::string("render ") + kSmall + " --size 32 -o two.png --level 1");
  EXPECT_EQ(other.status, 1);
  EXPECT_THAT(other.output, HasSubstr("--level 1: there is 1 level, counted from 0"));
}

}  // namespace
}  // namespace sluice
