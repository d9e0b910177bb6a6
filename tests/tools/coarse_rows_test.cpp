// Rows of pictures that get better, of a store whose level 0 has no index.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include "tests/tools/coarse_store.h"

namespace sluice {
namespace {

using nlohmann::json;
using testing::AllOf;
using testing::HasSubstr;

std::vector<int> finestLevels(const json& pictures) {
  std::vector<int> levels;
  for (const json& picture : pictures)
    levels.push_back(picture["cut"]["levels"][0]["level"].get<int>());
  return levels;
}

TEST_F(CoarseFirst, atTheTimeLimitTheLastWholePictureIsWritten) {
  spoilLevelZero();
  const json report = render("--time-limit 0ms");
  EXPECT_EQ(finestLevels(report["frames"][0]["pictures"]), std::vector<int>{3});
  EXPECT_EQ(report["cut"]["final"], false);
  EXPECT_EQ(report["cut"]["coarse_share"], 1.0);
  EXPECT_EQ(report["frames"][0]["missing_share"], 0.0) << "no fragment";
  const auto limited = picture().rgba;
  render("--level 3");
  EXPECT_EQ(limited, picture().rgba);
  EXPECT_THAT(run(std::string("render v.zarr -o x.png ") + kCoarseLook + " --time-limit 0"),
              HasSubstr("level 3, will improve"));
}

TEST_F(CoarseFirst, withEnoughTimeThePictureIsTheOneWithoutALimit) {
  const json report = render("--pixel-error 0.5 --time-limit 1000s");
  EXPECT_EQ(report["cut"]["final"], true);
  const auto limited = picture().rgba;
  const json other = render("--pixel-error 0.5");
  EXPECT_EQ(limited, picture().rgba);
  EXPECT_EQ(report["cut"], other["cut"]);
}

TEST_F(CoarseFirst, eachPictureOfARowIsFinerAndWhole) {
  const json report = program_.json(std::string("render v.zarr -o 'p_##.png' ") + kCoarseLook +
                                    " --pixel-error 0.5 --progressive");
  const json& pictures = report["frames"][0]["pictures"];
  const std::vector<int> levels = finestLevels(pictures);
  EXPECT_EQ(levels, (std::vector<int>{3, 2, 1}));
  for (size_t i = 0; i < pictures.size(); ++i) {
    EXPECT_EQ(pictures[i]["cut"]["final"], i + 1 == pictures.size()) << i;
    const std::string name = "p_0" + std::to_string(i) + ".png";
    ASSERT_TRUE(program_.exists(name));
    EXPECT_EQ(readPng(program_.folder / name).width, 64) << "each is a whole file";
  }
  EXPECT_FALSE(program_.exists("p_0" + std::to_string(pictures.size()) + ".png"));
  EXPECT_EQ(report["output"], "p_0" + std::to_string(pictures.size() - 1) + ".png");
  const std::string last = report["output"].get<std::string>();
  render("--pixel-error 0.5");
  EXPECT_EQ(readPng(program_.folder / last).rgba, picture().rgba);
}

// The labels have a level less than the scan, or none.
TEST_F(CoarseFirst, volumesOfARowGetBetterTogether) {
  run("pack synth:parts,dims=160x150x140 -o parts.zarr --chunk 16 --levels 2 --downsample mode");
  run("synth parts --dims 160,150,140 -o parts_160x150x140_uint8.raw");
  for (const char* over : {"parts.zarr", "parts_160x150x140_uint8.raw"})
    for (const char* options : {"--pixel-error 0.5", "--level 1", "--time-limit 1000s"}) {
      SCOPED_TRACE(std::string(over) + " " + options);
      const std::string command =
          std::string(kCoarseLook) + " --combine add --over " + over + " " + options;
      const json report = program_.json("render v.zarr -o 'p_##.png' --progressive " + command);
      const json& pictures = report["frames"][0]["pictures"];
      const std::vector<int> levels = finestLevels(pictures);
      ASSERT_GE(levels.size(), 2);
      EXPECT_EQ(levels.front(), 3) << "the coarsest one comes first";
      EXPECT_EQ(pictures.back()["cut"]["final"], true);
      EXPECT_EQ(pictures.front()["cut"]["final"], false);
      ASSERT_EQ(report["frames"][0]["channels"].size(), 2);
      EXPECT_EQ(report["frames"][0]["channels"][0]["cut"], report["cut"]);
      EXPECT_EQ(report["frames"][0]["channels"][1]["empty"], false);
      run("render v.zarr -o x.png " + command);
      EXPECT_EQ(readPng(program_.folder / report["output"].get<std::string>()).rgba,
                picture().rgba);
    }
  EXPECT_THAT(
      run(std::string("render v.zarr --over parts.zarr -o x.png --time-limit 0 ") + kCoarseLook),
      HasSubstr("1 picture, the last after"));
}

TEST_F(CoarseFirst, levelsOfMeansDoNotStandForLabelsOverAScan) {
  run("pack synth:parts,dims=160x150x140 -o means.zarr --chunk 16 --levels 2 --downsample mean");
  for (const char* options : {"--progressive", "--pixel-error 4", "--level 3"})
    run(std::string("render v.zarr --over means.zarr -o x.png ") + kCoarseLook + " " + options);
}

TEST_F(CoarseFirst, aRowWithoutNumbersReplacesItsPicture) {
  const std::string said = run(std::string("render v.zarr -o x.png ") + kCoarseLook +
                               " --pixel-error 0.5 --progressive");
  EXPECT_THAT(said, HasSubstr("x.png: "));
  EXPECT_THAT(said, HasSubstr("level 3, will improve"));
  EXPECT_THAT(said, HasSubstr(", final"));
  const auto replaced = picture().rgba;
  render("--pixel-error 0.5");
  EXPECT_EQ(replaced, picture().rgba);
}

// Levels of a store that others wrote have no spreads: unasked, they are not drawn.
TEST_F(CoarseFirst, aRowEndsWithThePictureThatIsDrawnUnasked) {
  removeSpreads();
  render("--pixel-error 1");  // makes the index
  const auto without = [&](const char* more) {
    render(more);
    return picture().rgba;
  };
  for (const char* more : {"", "--quality high", "--zoom 0.3 --quality normal"}) {
    SCOPED_TRACE(more);
    const auto expected = without(more);
    const json report = render(std::string("--progressive ") + more);
    EXPECT_EQ(report["frames"][0]["pictures"].back()["cut"]["final"], true);
    const auto drawn = picture().rgba;
    ASSERT_EQ(drawn.size(), expected.size());
    int most = 0;
    for (size_t i = 0; i < drawn.size(); ++i)
      most = std::max(most, std::abs(drawn[i] - expected[i]));
    EXPECT_LE(most, 1);
  }
}

// The whole finest level could not be begun in part, as a cut can.
TEST_F(CoarseFirst, aRowWithATimeLimitEndsWithTheCut) {
  removeSpreads();
  render("--pixel-error 1");  // makes the index
  const auto expected = picture().rgba;
  for (const char* more : {"", "--progressive"}) {
    SCOPED_TRACE(more);
    const json report = render(std::string("--time-limit 1000s ") + more);
    EXPECT_EQ(finestLevels(report["frames"][0]["pictures"]), (std::vector<int>{3, 2}));
    EXPECT_EQ(report["cut"]["final"], true);
    EXPECT_EQ(picture().rgba, expected);
  }
}

TEST_F(CoarseFirst, aRowReachesLevelZeroWithoutWaitingForItsIndex) {
  const json report = render("--pixel-error 0.1 --progressive");
  EXPECT_EQ(finestLevels(report["frames"][0]["pictures"]), (std::vector<int>{3, 2, 1, 0}));
  EXPECT_EQ(report["volume"]["index"]["state"], "not made");
  const auto unknown = picture();
  EXPECT_EQ(render("--pixel-error 0.1")["volume"]["index"]["state"], "built");
  EXPECT_LT(meanDifference(unknown, picture()), 0.2) << "anything may show, but no more does";
}

TEST_F(CoarseFirst, whatLooksAtOnePictureRefusesARow) {
  for (const char* more : {"--progressive --verify", "--time-limit 1 --debug-view --occlusion map"})
    EXPECT_THAT(
        program_.run(std::string("render v.zarr -o y.png ") + kCoarseLook + " " + more).output,
        HasSubstr("looks at one picture"));
  EXPECT_EQ(program_.run("render v.zarr -o y.png --time-limit 1h").status, 2);
  EXPECT_THAT(program_.run("render v.zarr -o y.mp4 --frames 3 --progressive").output,
              HasSubstr("--progressive is for pictures"));
}

}  // namespace
}  // namespace sluice
