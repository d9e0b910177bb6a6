// Pictures of coarse levels that do not wait for the finest one: what is read for them, and what
// they say.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "tests/tools/coarse_store.h"

namespace sluice {
namespace {

using nlohmann::json;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

TEST_F(CoarseFirst, noChunkOfLevelZeroIsReadForAPictureOfCoarserLevels) {
  spoilLevelZero();
  const json report = render("--pixel-error 2");
  ASSERT_FALSE(report["cut"]["levels"].empty());
  EXPECT_GT(report["cut"]["levels"][0]["level"], 0);
  EXPECT_EQ(report["cut"]["coarse_share"], 1.0);
  EXPECT_EQ(report["volume"]["index"]["state"], "not made");
  // Twice: for its values and for the picture.
  EXPECT_LE(report["levels"]["disk"]["read_bytes"], 2 * bytesOf({"1", "2", "3", "spread"}));
  const CommandResult finest =
      program_.run(std::string("render v.zarr -o y.png ") + kCoarseLook + " --level 0");
  EXPECT_EQ(finest.status, 1) << "level 0 cannot be read";
}

TEST_F(CoarseFirst, thePictureIsNearlyTheOneThatIsDrawnWithTheIndex) {
  for (const char* more : {"--pixel-error 2", "--level 1", "--level 2"}) {
    removeIndex();
    render(more);
    const auto first = picture();
    const json known = render("--pixel-error 0.01");
    EXPECT_EQ(known["volume"]["index"]["state"], "built");
    EXPECT_EQ(render(more)["volume"]["index"]["state"], "read");
    // Where level 0 shows nothing, the spreads of coarse voxels may reach beyond the threshold.
    EXPECT_LT(meanDifference(first, picture()), 1.5) << more;
  }
}

// Thin vessels, which the means of the level hide and its spreads show.
TEST_F(CoarseFirst, theFitTakesInWhatSpreadsShow) {
  constexpr int kSide = 128, kMiddle = 64;
  std::string voxels;
  for (int z = 0; z < kSide; ++z)
    for (int y = 0; y < kSide; ++y)
      for (int x = 0; x < kSide; ++x) {
        const int off = (x == kMiddle ? 0 : 1) + (y == kMiddle ? 0 : 1) + (z == kMiddle ? 0 : 1);
        const int far =
            std::max({std::abs(x - kMiddle), std::abs(y - kMiddle), std::abs(z - kMiddle)});
        const bool is_seen = far < 10 || (off <= 1 && far < 56);
        voxels += static_cast<char>(is_seen ? 220 : 20);
      }
  writeFile(program_.folder / "t_128x128x128_uint8.raw", voxels);
  run("pack t_128x128x128_uint8.raw -o t.zarr --levels 2");
  removeIndex();
  EXPECT_THAT(run("render t.zarr -o x.png --threshold 100 --opacity 1 --size 16 --azimuth 30"),
              HasSubstr("the fit come from level 1"));
  const Rgba8Picture drawn = picture();
  int shown = 0;
  for (int y = 0; y < 16; ++y)
    for (int x = 0; x < 16; ++x) {
      const int alpha = drawn.rgba[static_cast<size_t>(4 * (y * 16 + x) + 3)];
      shown += alpha > 20 ? 1 : 0;
      if (std::min(x, y) == 0 || std::max(x, y) == 15) {
        EXPECT_LE(alpha, 20) << x << " " << y;
      }
    }
  EXPECT_GT(shown, 20);
}

// The camera's options, as a picture keeps them.
double zoomOf(const std::filesystem::path& exr) {
  const std::string bytes = readFile(exr);
  const size_t at = bytes.find("--zoom ");
  return at == std::string::npos ? 0 : std::stod(bytes.substr(at + 7));
}

TEST_F(CoarseFirst, theFitIsNearlyThatOfLevelZero) {
  // Spheres leave most of the bricks' corners empty.
  for (const char* look : {"--threshold 60 --pixel-error 2", "--iso 200 --max-bytes 1M"}) {
    const std::string picture =
        std::string("render v.zarr -o x.exr --size 100 --range 0,255 --force ") + look;
    removeIndex();
    EXPECT_THAT(run(picture), HasSubstr("no index yet"));
    const double first = zoomOf(program_.folder / "x.exr");
    run("info v.zarr");
    EXPECT_THAT(run(picture), Not(HasSubstr("no index yet")));
    EXPECT_GT(first, 1);
    EXPECT_NEAR(first / zoomOf(program_.folder / "x.exr"), 1, 0.01) << look;
  }
}

// Fit, range and look follow from the voxels, not from the blocks of an index.
TEST_F(CoarseFirst, anIndexOfOtherBlocksTellsTheSame) {
  for (const char* indexed : {"info v.zarr --block 64", "render v.zarr -o x.exr --level 0 --force",
                              "render v.zarr -o x.exr --level 0 --no-shade --block 16 --force"}) {
    removeIndex();
    run(indexed);
    const auto picture = [&](int block) {
      json report = program_.json(fmt::format(
          "render v.zarr -o x.exr --size 100 --pixel-error 2 --block {} --force", block));
      EXPECT_EQ(report["volume"]["values_level"], 0) << indexed << ", blocks of " << block;
      return std::pair(zoomOf(program_.folder / "x.exr"), report["look"].dump());
    };
    const auto first = picture(32);
    EXPECT_EQ(picture(128), first);
    run("info v.zarr --block 32");
    EXPECT_EQ(picture(32), first);
  }
}

// Whichever of several volumes it is.
TEST_F(CoarseFirst, isSaidOfTheVolumeThatHasNoIndex) {
  run("pack synth:phantom,dims=160x150x140 -o w.zarr --chunk 16 --levels 3");
  removeIndex();
  run("info v.zarr --block 32");
  const std::string picture =
      "v.zarr --over w.zarr --pixel-error 2 --look over:green,60:255 --threshold 60 --no-shade "
      "--block 32 --view plain --size 64 ";
  for (const char* command :
       {"plan ", "simulate --frames 1 --policies lru ", "render --force -o x.png "}) {
    SCOPED_TRACE(command);
    EXPECT_THAT(run(command + picture), AllOf(HasSubstr("w.zarr: level 0 has no index yet"),
                                              Not(HasSubstr("v.zarr: level 0 has no index yet"))));
    EXPECT_THAT(program_.json(command + picture)["warnings"],
                testing::Contains(HasSubstr("w.zarr: level 0 has no index yet")));
  }
}

TEST_F(CoarseFirst, whatComesFromACoarseLevelIsSaid) {
  const std::string said =
      run(std::string("render v.zarr -o x.png ") + kCoarseLook + " --pixel-error 2");
  EXPECT_THAT(said, HasSubstr("level 0 has no index yet"));
  EXPECT_THAT(said, HasSubstr("may differ a little"));
  const json first = render("--pixel-error 2")["volume"];
  EXPECT_EQ(first["values_level"], 1);
  const json finest = render("--pixel-error 0.01")["volume"];
  EXPECT_EQ(finest["values_level"], 0);
  for (const size_t end : {0U, 1U})
    EXPECT_NEAR(first["value_range"][end].get<double>(), finest["value_range"][end].get<double>(),
                0.1 * finest["value_range"][1].get<double>());
  EXPECT_THAT(run(std::string("render v.zarr -o x.png ") + kCoarseLook + " --pixel-error 2"),
              Not(HasSubstr("no index")));
}

TEST_F(CoarseFirst, aPictureOfLevelZeroMakesItsIndex) {
  const json report = render("--pixel-error 0.01");
  EXPECT_EQ(report["volume"]["index"]["state"], "built");
  EXPECT_EQ(report["cut"]["levels"][0]["level"], 0);
}

TEST_F(CoarseFirst, withAnIndexNothingIsTakenFromACoarserLevel) {
  render("--pixel-error 0.01");
  const json report = render("--pixel-error 2");
  EXPECT_EQ(report["volume"]["index"]["state"], "read");
  EXPECT_EQ(report["volume"]["values_level"], 0);
}

// Blocks of level 0 that a picture has read are known from then on: only what shows of them is
// drawn.
TEST_F(CoarseFirst, rangesOfTheBlocksThatAPictureReadsAreKept) {
  const std::string all = "--pixel-error 0.01 --max-bytes 1G --pages 4096";
  const json first = render(all);
  EXPECT_EQ(first["volume"]["index"]["state"], "not made");
  ASSERT_EQ(first["cut"]["levels"][0]["level"], 0);
  const auto shown = picture();
  const json second = render(all);
  EXPECT_EQ(second["volume"]["index"]["state"], "not made");
  EXPECT_LT(second["cut"]["levels"][0]["cells"], first["cut"]["levels"][0]["cells"]);
  for (size_t i = 0; i < shown.rgba.size(); ++i)
    ASSERT_NEAR(picture().rgba[i], shown.rgba[i], 1) << i;
  // Within one command, too: the second frame shows as few cells.
  removeIndex();
  const json turn = program_.json(std::string("render v.zarr -o turn_##.png --frames 2 ") +
                                  kCoarseLook + " " + all);
  EXPECT_EQ(turn["cut"]["levels"][0]["cells"], second["cut"]["levels"][0]["cells"]);
  // Ranges of another state of the store are not believed.
  writeFile(program_.folder / "v.zarr/.zattrs", readFile(program_.folder / "v.zarr/.zattrs") + " ");
  EXPECT_EQ(render(all)["cut"]["levels"][0]["cells"], first["cut"]["levels"][0]["cells"]);
}

TEST_F(CoarseFirst, levelsOfAnotherProgramAreDrawnWithoutLevelZeroToo) {
  removeSpreads();
  spoilLevelZero();
  const json report = render("--pixel-error 2");
  EXPECT_EQ(report["cut"]["spreads"], false);
  EXPECT_GT(report["cut"]["levels"][0]["level"], 0);
  EXPECT_LE(report["levels"]["disk"]["read_bytes"], 2 * bytesOf({"1", "2", "3"}));
}

TEST_F(CoarseFirst, aPlanReadsNothingOfLevelZeroEither) {
  spoilLevelZero();
  const std::string look = "--threshold 60 --range 0,255 --block 32 --size 64 --pixel-error 2";
  const json plan = program_.json("plan v.zarr " + look);
  EXPECT_GT(plan["cut"]["levels"][0]["level"], 0);
  EXPECT_THAT(run("plan v.zarr " + look), HasSubstr("level 0 has no index yet"));
}

}  // namespace
}  // namespace sluice
