// Levels of resolution as a user asks for them: which are drawn, reported and refused.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "io/pictures/png_file.h"
#include "tests/tools/program.h"

namespace sluice {
namespace {

using nlohmann::json;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

constexpr const char* kVolume = "synth:shells,dims=160x140x120,levels=4";
constexpr const char* kLevelsLook =
    "--threshold 60 --opacity 0.1 --no-shade --block 32 --view plain --azimuth 30 --size 64";

class LevelsCommand : public testing::Test {
 protected:
  static std::string arguments(const std::string& more) {
    return std::string(kVolume) + " " + kLevelsLook + " " + more;
  }
  json render(const std::string& more) const {
    return program_.json("render " + arguments("-o x.png --force " + more));
  }
  // A plan reads no voxel.
  static json withoutSpread(json cut) {
    cut.erase("spread");
    return cut;
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

TEST_F(LevelsCommand, aPictureFromLevelsSaysThatQualityChangesNothing) {
  const auto said = [&](const std::string& more) {
    return program_.run("render " + arguments("-o x.png --force --quality normal " + more)).output;
  };
  EXPECT_THAT(said("--pixel-error 1"),
              AllOf(HasSubstr("--quality changes nothing in a picture from levels of resolution"),
                    Not(HasSubstr("--step 2 --quality"))));
  EXPECT_THAT(said("--level 0 --mode mip"), HasSubstr("--quality changes nothing in this --mode"));
  EXPECT_THAT(said("--level 0"),
              AllOf(Not(HasSubstr("changes nothing")), HasSubstr(" --quality normal")));
}

TEST_F(LevelsCommand, levelZeroIsThePictureOfTheVolumeWithoutLevels) {
  EXPECT_FALSE(render("--level 0").contains("cut"));
  const auto read = [&](const char* name) { return readPng(program_.folder / name).rgba; };
  const auto leveled = read("x.png");
  ASSERT_EQ(
      program_.run(std::string("render synth:shells,dims=160x140x120 -o plain.png ") + kLevelsLook)
          .status,
      0);
  EXPECT_EQ(leveled, read("plain.png"));
  const CommandResult said = program_.run("render " + arguments("-o x.png --force --level 0"));
  EXPECT_THAT(said.output, Not(HasSubstr("coarser")));
}

TEST_F(LevelsCommand, meansAndSpreadsAreSaidAndLabelsAreNotDrawnFromThem) {
  const json cut = render("--pixel-error 1")["cut"];
  EXPECT_EQ(cut["spreads"], true);
  const json plan = program_.json("plan " + arguments("--pixel-error 1"));
  EXPECT_EQ(plan["cut"], withoutSpread(cut));
  EXPECT_GT(cut["spread"]["largest"], cut["spread"]["mean"]);
  EXPECT_GT(cut["spread"]["mean"], 0);
  EXPECT_EQ(plan["read"]["voxel_bytes"], render("--pixel-error 1")["frames"][0]["decoded_bytes"]);
}

TEST_F(LevelsCommand, aPictureWithoutOptionsHasVoxelsAsWideAsPixels) {
  const json cut = render("")["cut"];
  EXPECT_EQ(cut["levels"][0]["level"], 1);
  const auto drawn = readPng(program_.folder / "x.png").rgba;
  EXPECT_EQ(render("--pixel-error 1")["cut"], cut);
  EXPECT_EQ(readPng(program_.folder / "x.png").rgba, drawn);
  EXPECT_EQ(program_.json("plan " + arguments(""))["cut"], withoutSpread(cut));
  // Voxels smaller than pixels are not needed: fewer bytes than at level 0.
  const auto bytes = [&](const std::string& more) {
    return program_.json("plan " + arguments(more))["read"]["voxel_bytes"].get<uint64_t>();
  };
  EXPECT_LT(2 * bytes(""), bytes("--level 0"));
}

// Means are neither extremes nor labels.
TEST_F(LevelsCommand, modesThatMeansCannotShowAreDrawnAtLevelZero) {
  const auto drawn = [&](const std::string& more) {
    const json report = program_.json("render " + std::string(kVolume) +
                                      " --size 64 --block 32 -o x.png --force " + more);
    return std::pair(report.contains("cut"), readPng(program_.folder / "x.png").rgba);
  };
  for (const char* mode : {"--mode mip", "--mode minip", "--mode average", "--labels"}) {
    const auto [is_cut, picture] = drawn(mode);
    EXPECT_FALSE(is_cut) << mode;
    EXPECT_EQ(drawn(std::string(mode) + " --level 0").second, picture) << mode;
  }
  const auto refusal = [&](const std::string& more) {
    const CommandResult result =
        program_.run("render " + std::string(kVolume) + " --size 64 -o y.png " + more);
    EXPECT_EQ(result.status, 1) << more;
    return result.output;
  };
  EXPECT_THAT(refusal("--labels --level 1"), HasSubstr("hold means, which are no labels"));
  EXPECT_THAT(refusal("--mode mip --pixel-error 2"), HasSubstr("hold means, which are no maxima"));
  EXPECT_THAT(refusal("--mode minip --max-bytes 1M"), HasSubstr("which are no minima"));
  EXPECT_TRUE(render("--mode average --pixel-error 1").contains("cut"));
}

TEST_F(LevelsCommand, packedLevelsAreDrawnWithTheirSpreadsAndOthersWithout) {
  const auto run = [&](const std::string& command) {
    const CommandResult result = program_.run(command);
    EXPECT_EQ(result.status, 0) << result.output;
    return result.output;
  };
  run("pack synth:shells,dims=96x90x80 -o v.zarr --chunk 16 --levels 2");
  EXPECT_THAT(run("info v.zarr --levels"), HasSubstr("spread: u8"));
  const std::string picture =
      std::string("v.zarr ") + kLevelsLook + " -o v.png --force --pixel-error 2";
  const json shown = program_.json("render " + picture);
  EXPECT_EQ(shown["cut"]["spreads"], true);
  EXPECT_GT(shown["cut"]["coarse_share"], 0.0);
  EXPECT_THAT(run("render " + picture), HasSubstr("from means and spreads"));
  // As another program writes it.
  std::filesystem::remove_all(program_.folder / "v.zarr/spread");
  std::string attributes = readFile(program_.folder / "v.zarr/.zattrs");
  attributes.replace(attributes.find("spreads"), 7, "nothing");
  writeFile(program_.folder / "v.zarr/.zattrs", attributes);
  EXPECT_THAT(run("info v.zarr --levels"), HasSubstr("spread: none"));
  EXPECT_EQ(program_.json("render " + picture)["cut"]["spreads"], false);
  EXPECT_THAT(run("render " + picture), HasSubstr("without a spread"));
  // Such levels lose thin structures: they are drawn only if they are asked for.
  const std::string default_cut = std::string("v.zarr ") + kLevelsLook + " -o v.png --force";
  EXPECT_FALSE(program_.json("render " + default_cut).contains("cut"));
}

TEST_F(LevelsCommand, aLevelThatIsLeftOutIsListedWithTheReason) {
  ASSERT_EQ(
      program_.run("pack synth:noise,dims=64x64x64 -q -o v.zarr --levels 2 --chunk 16").status, 0);
  const std::filesystem::path attributes = program_.folder / "v.zarr/.zattrs";
  auto image = json::parse(readFile(attributes));
  image["multiscales"][0]["datasets"][1]["coordinateTransformations"][1]["translation"] = {9, 0.5,
                                                                                           0.5};
  writeFile(attributes, image.dump());
  const std::string reason =
      "along z its first voxel lies at 9 among those of level 0, expected 0 to 0.5";
  const std::string listed = program_.run("info v.zarr --levels").output;
  EXPECT_THAT(listed, HasSubstr("levels from 1 on are left out: " + reason));
  EXPECT_THAT(listed, HasSubstr("spread: u8; left out of pictures\n"));
  EXPECT_THAT(listed, HasSubstr("\n  level 1 is left out, with all above it: " + reason));
  const json levels = program_.json("info v.zarr --levels")["pyramid"];
  EXPECT_EQ(levels[0]["left_out"], "");
  EXPECT_EQ(levels[2]["left_out"], reason);
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
  EXPECT_THAT(said.output, HasSubstr("--time-limit ended the refinement"));
}

// In a row the next picture finds the blocks of the last one in memory.
TEST_F(LevelsCommand, aPictureAloneMayTakeMoreOfTheMemoryThanOneOfARow) {
  const std::string picture =
      "synth:phantom,dims=224x224x224,levels=3 --block 32 --page 16x16x16 --pages 64 --threshold "
      "60 "
      "--pixel-error 0.1 --size 64 --memory 18M --force ";
  EXPECT_EQ(program_.json("render " + picture + "-o one.png")["cut"]["final"], true);
  EXPECT_EQ(program_.json("render " + picture + "-o row_##.png --frames 2")["cut"]["final"], false);
}

TEST_F(LevelsCommand, aPlanAndASimulationHaveTheSameCut) {
  const std::string options = "--pixel-error 0.5 --projection perspective --zoom 3";
  const json plan = program_.json("plan " + arguments(options));
  EXPECT_EQ(plan["cut"], withoutSpread(render(options)["cut"]));
  EXPECT_GE(plan["cut"]["levels"].size(), 2U);
  const auto read = [&](const std::string& more) {
    return program_.json("plan " + arguments(more))["read"]["voxel_bytes"].get<uint64_t>();
  };
  EXPECT_LT(2 * read("--pixel-error 1"), read("--level 0"));
  const auto bytes = [&](const std::string& more) {
    const json rows =
        program_.json("simulate " + arguments("--frames 2 --policies lru " + more))["rows"];
    return rows[0]["bytes_needed"].get<uint64_t>();
  };
  EXPECT_LT(bytes("--pixel-error 1"), bytes("--level 0"));
}

// A level of a linear function has the values of the finest one. Shells thinner than a voxel of
// level 3 look another way there.
TEST_F(LevelsCommand, verifyComparesAnyCutWithThePlainPictureOfLevelZero) {
  const auto verified = [&](const std::string& picture) {
    const json report =
        program_.json("render " + picture + " -o v.png --force --no-shade --size 64 --verify");
    EXPECT_EQ(report["cut"]["coarse_share"], 1.0);
    return report["verify"]["max_difference"].get<double>();
  };
  std::string values;
  for (int z = 0; z < 60; ++z)
    for (int y = 0; y < 70; ++y)
      for (int x = 0; x < 80; ++x) {
        const auto value = static_cast<float>(x + 2 * y + z);
        values.append(reinterpret_cast<const char*>(&value), sizeof value);
      }
  writeFile(program_.folder / "ramp_80x70x60_float32.raw", values);
  const CommandResult packed =
      program_.run("pack ramp_80x70x60_float32.raw -o ramp.zarr --chunk 16 --levels 2");
  ASSERT_EQ(packed.status, 0) << packed.output;
  const std::string ramp = "ramp.zarr --opacities 0:0.01,280:0.03 --crop 6,6,6,72,62,52 --step 1 ";
  EXPECT_LE(verified(ramp + "--level 1"), 2);
  EXPECT_LE(verified(ramp + "--level 2"), 2);
  const std::string shells = std::string(kVolume) + " --threshold 60 --opacity 0.1 ";
  EXPECT_GT(verified(shells + "--level 3"), 20);
  const CommandResult said =
      program_.run("render " + ramp + "-o v.png --force --size 64 --level 1 --verify");
  EXPECT_THAT(said.output, HasSubstr("against the plain picture of level 0: largest"));
}

TEST_F(LevelsCommand, aSeriesIsDrawnFromTheLevelsOfEachStep) {
  const std::string series = "synth:mixing,dims=64x60x56,steps=3,levels=3 ";
  const std::string look = "--threshold 100 --no-shade --block 16 --size 24 --force ";
  const json report = program_.json("render " + series + look + "--time 0:2 -o s%d.png");
  EXPECT_EQ(report["cut"]["coarse_share"], 1.0);
  ASSERT_EQ(report["frames"].size(), 3U);
  // Each step alone, with the look of all of them.
  for (const char* step : {"1", "2"}) {
    const json alone = program_.json("render " + series + look + "-o one.png --time " + step);
    EXPECT_EQ(alone["cut"]["coarse_share"], 1.0);
    const auto one = readPng(program_.folder / "one.png").rgba;
    EXPECT_EQ(readPng(program_.folder / (std::string("s") + step + ".png")).rgba, one) << step;
  }
  EXPECT_NE(readPng(program_.folder / "s1.png").rgba, readPng(program_.folder / "s2.png").rgba);
}

TEST_F(LevelsCommand, oneBrightVoxelIsFoundByAPlanAndDrawnWithKeepThin) {
  constexpr size_t kSide = 96;
  std::string voxels(kSide * kSide * kSide, '\0');
  voxels[(40 * kSide + 51) * kSide + 33] = '\xff';
  writeFile(program_.folder / "one_96x96x96_uint8.raw", voxels);
  const CommandResult packed =
      program_.run("pack one_96x96x96_uint8.raw -o one.zarr --chunk 16 --levels 3");
  ASSERT_EQ(packed.status, 0) << packed.output;
  const std::string look =
      "one.zarr --threshold 100 --opacity 1 --no-shade --fit volume --size 20 ";
  const json plan = program_.json("plan " + look);
  EXPECT_EQ(plan["cut"]["thin_blocks"], 1);
  EXPECT_EQ(plan["cut"]["coarse_share"], 1.0);
  EXPECT_THAT(program_.run("render " + look + "-o v.png").output,
              HasSubstr("1 block has parts thinner than two voxels, --keep-thin refines it"));
  // From any side and in pictures of any size it is nearly as opaque as in one whose pixels are
  // smaller than a voxel. At level 0 a ray passes beside it in some of these pictures.
  const auto shown = [&](int size, const std::string& more) {
    const json report = program_.json(
        fmt::format("render one.zarr --threshold 20 --opacity 1 --no-shade --fit volume --size {} "
                    "-o v.png --force --step 1 {}",
                    size, more));
    int most = 0;
    const auto rgba = readPng(program_.folder / "v.png").rgba;
    for (size_t i = 3; i < rgba.size(); i += 4) most = std::max<int>(most, rgba[i]);
    if (more.find("keep") != std::string::npos) {
      EXPECT_EQ(report["cut"]["levels"][0]["level"], 0);
      EXPECT_EQ(report["cut"]["thin_blocks"], 0);
    }
    return most;
  };
  for (const std::string view :
       {"--view plain", "--view plain --azimuth 33 --elevation 21", "--view plain --azimuth 70"}) {
    const int truth = shown(400, view + " --level 0");
    EXPECT_GT(truth, 100);
    for (const int size : {40, 61, 76, 80}) {
      SCOPED_TRACE(fmt::format("{} at {}", view, size));
      EXPECT_GT(shown(size, view + " --keep-thin"), truth / 2);
    }
    // The plain picture has the same rays.
    const json verified = program_.json(
        "render one.zarr --threshold 20 --opacity 1 --no-shade --fit volume --size 40 -o v.png "
        "--force --keep-thin --verify " +
        view);
    EXPECT_LE(verified["verify"]["max_difference"].get<double>(), 1) << view;
  }
  EXPECT_EQ(program_.run("render " + look + "-o w.png --keep-thin --level 1").status, 2);
}

TEST_F(LevelsCommand, cullingAndGrowingBoxesTakeLevelZeroUnlessLevelsAreAskedFor) {
  const std::string series =
      "synth:mixing,dims=40x40x40,steps=2,levels=2 --threshold 100 --size 16 ";
  EXPECT_FALSE(
      program_.json("render " + series + "-o c%d.png --time 0:1 --culling toc").contains("cut"));
  EXPECT_FALSE(render("--partition boxes").contains("cut"));
  const json boxes = render("--partition boxes --pixel-error 1");
  EXPECT_EQ(boxes["cut"]["coarse_share"], 1.0);
}

TEST_F(LevelsCommand, whatKnowsTheFinestLevelAloneRefusesOthersInOneLine) {
  const CommandResult culling =
      program_.run("render " + arguments("-o x.png --level 1 --culling toc"));
  EXPECT_EQ(culling.status, 2);
  EXPECT_THAT(culling.output,
              HasSubstr("--culling draws the finest level alone; leave out --level"));
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
