// Pictures of several channels, against sums of pictures of one and against NumPy.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "tests/tools/channels_fixture.h"

namespace sluice {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

TEST_F(Channels, activeOnesOfAnOmeFileAddUpInItsColoursAndWindows) {
  for (const char* device : {"cpu", "gl"})
    for (const char* mode : {"composite", "mip"}) {
      SCOPED_TRACE(fmt::format("{} {}", device, mode));
      const std::string common =
          fmt::format(" --background 000000 --mode {} --device {} --step 1{} -o ", mode, device,
                      std::string_view(device) == "gl" ? " --gl osmesa" : "");
      if (program_.run("render cells.ome.zarr --force" + common + "try.png").status != 0 &&
          std::string_view(device) == "gl")
        GTEST_SKIP() << "no software OpenGL";
      render("cells.ome.zarr" + common + "whole.png");
      for (size_t c = 0; c < kStoredLooks.size(); ++c)
        render(fmt::format("cells.ome.zarr --channel {} {} {} {}{}.png", c, kStoredLooks[c],
                           std::string_view(mode) == "composite" ? "--no-shade" : "", common, c));
      // Each of the pictures is rounded.
      EXPECT_LE(difference("sum whole.png 0.png 1.png 2.png"), 2);
    }
}

TEST_F(Channels, omeTiffHasColoursAndAutomaticWindows) {
  const std::string common = " --background 000000 --step 1 -o ";
  render("cells.ome.tif" + common + "whole.png");
  const std::array<const char*, 3> colors = {"00ffff", "00ff00", "ff00ff"};
  for (size_t c = 0; c < colors.size(); ++c)
    render(fmt::format("cells.ome.tif --channel {} --map {} --no-shade{}{}.png", c, colors[c],
                       common, c));
  EXPECT_LE(difference("sum whole.png 0.png 1.png 2.png"), 2);
}

TEST_F(Channels, projectionIsTheSumOfWindowsInNumPy) {
  // A pixel a voxel.
  const double zoom = std::sqrt(47.0 * 47 + 31 * 31 + 5 * 5) / 2 / 16;
  ASSERT_EQ(program_
                .run(fmt::format("render flat.ome.zarr --mode mip --view plain --fit volume --zoom "
                                 "{} --size 48x32 --background 000000 -o flat.png",
                                 zoom))
                .status,
            0);
  EXPECT_LE(difference("flat flat.png"), 2);
}

TEST_F(Channels, benchComparesThemWithEachAlone) {
  const auto report =
      program_.json("bench channels cells.ome.zarr --channel 0,1,2 --frames 2 --size 60x40");
  ASSERT_EQ(report["rows"].size(), 5U);
  double of_three = 0;
  for (size_t i = 0; i < 3; ++i) of_three += report["rows"][i]["ratio"].get<double>();
  EXPECT_NEAR(of_three, 3, 1e-9);
  EXPECT_EQ(report["rows"][3]["way"], "add");
  EXPECT_EQ(report["rows"][4]["way"], "blend");
  EXPECT_THAT(program_.run("bench channels cells.ome.zarr --channel 1").output,
              HasSubstr("measures several channels of one volume"));
}

TEST_F(Channels, pictureIsTheSameForAllBlocksAndBudgets) {
  for (const char* options : {"", "--block 16 --page 16x16x16", "--memory 80M", "--mode mip",
                              "--channel 0,2 --partition boxes"}) {
    const auto report = program_.json(
        fmt::format("render cells.ome.zarr {} --size 200x160 --force --verify -o a.png", options));
    EXPECT_LE(report["verify"]["max_difference"], 1) << options;
    EXPECT_EQ(report["verify"]["differing_pixels"], 0) << options;
    EXPECT_EQ(report["channels"].size(),
              std::string_view(options).starts_with("--channel") ? 2 : 3);
    uint64_t memory = 0;
    for (const auto& channel : report["channels"])
      memory += channel["memory_bytes"].get<uint64_t>();
    EXPECT_LE(memory, report["memory_bytes"]);
  }
}

// The second picture of a turn needs no reading, so that its channels are drawn together.
TEST_F(Channels, drawnTogetherAreThoseDrawnAlone) {
  std::vector<std::string> ways;
  std::string sums = "sum";
  for (const char* simd : {"plain", "sse4", "avx2", "avx512"}) {
    if (program_.run(fmt::format("render cells.ome.zarr --force --simd {} -o try.png", simd))
            .status != 0)
      continue;
    for (const char* options :
         {"", "--range=-1,255 --opacity 0.02", "--shade --projection perspective",
          "--range=-1,255 --opacity 0.9 --opacity-threshold 0.9", "--block 8 --jitter",
          "--range=-1,255 --shade --depth-cueing --clip 1,1,0,20"}) {
      const size_t n = ways.size();
      ways.push_back(fmt::format("{} {}", simd, options));
      SCOPED_TRACE(ways.back());
      const std::string common =
          fmt::format(" --device cpu --force --step 1 --simd {} {} -o ", simd, options);
      render(fmt::format("cells.ome.zarr --frames 2{}turn_{}_#.png", common, n));
      render(fmt::format("cells.ome.zarr --azimuth 180{}alone_{}.png", common, n));
      sums += fmt::format("{} turn_{}_1.png alone_{}.png", n == 0 ? "" : " /", n, n);
    }
  }
  const std::vector<double> most = differences(sums);
  ASSERT_EQ(most.size(), ways.size());
  for (size_t i = 0; i < ways.size(); ++i) EXPECT_LE(most[i], 1) << ways[i];
}

TEST_F(Channels, stripsMakeTheSamePicture) {
  render("cells.ome.zarr -o whole.png --background 000000", "1200x900");
  render("cells.ome.zarr -o strips.png --background 000000 --memory 60M", "1200x900");
  EXPECT_LE(difference("sum strips.png whole.png"), 1);
}

TEST_F(Channels, planAndReportCountEachChannel) {
  const auto plan = program_.json("plan cells.ome.zarr");
  const auto report = program_.json("render cells.ome.zarr -o a.png");
  ASSERT_EQ(plan["channels"].size(), 3U);
  int64_t blocks = 0, grey = 0, chunks = 0;
  for (int c = 0; c < 3; ++c) {
    const auto alone = program_.json(fmt::format("plan cells.ome.zarr --channel {} {} --no-shade",
                                                 c, kStoredLooks[static_cast<size_t>(c)]));
    const auto& channel = plan["channels"][static_cast<size_t>(c)];
    EXPECT_EQ(channel["channel"], c);
    EXPECT_EQ(channel["read"], alone["read"]);
    EXPECT_EQ(channel["blocks"], alone["blocks"]);
    EXPECT_EQ(report["frames"][0]["channels"][static_cast<size_t>(c)]["blocks"], alone["blocks"]);
    blocks += alone["read"]["blocks"].get<int64_t>();
    grey += alone["blocks"]["grey"].get<int64_t>();
    chunks += alone["algorithms"]["merged"]["chunks"].get<int64_t>();
  }
  EXPECT_EQ(plan["read"]["blocks"], blocks);
  EXPECT_EQ(plan["blocks"]["grey"], grey);
  EXPECT_EQ(report["frames"][0]["blocks"]["grey"], grey);
  EXPECT_EQ(report["frames"][0]["chunks"], chunks);
  EXPECT_EQ(report["levels"]["volume_buffer"]["loads"], blocks);
}

TEST_F(Channels, oneThatShowsNothingIsNamedAndNotRead) {
  render("cells.ome.zarr -o two.png --background 000000 --channel 0,2");
  const std::string line =
      "cells.ome.zarr -o three.png --background 000000 --look Actin:,60000:65000 ";
  const CommandResult result =
      program_.run("render --force --fit volume --size 200x160 --report r.json " + line);
  EXPECT_EQ(result.status, 0);
  EXPECT_THAT(result.output, HasSubstr("three.png: channel 1 (Actin) shows nothing: "));
  EXPECT_LE(difference("sum three.png two.png"), 0);
  const auto report = program_.json("render --force --fit volume --size 200x160 " + line);
  EXPECT_EQ(report["frames"][0]["empty"], "");
  EXPECT_TRUE(report["frames"][0]["channels"][1]["empty"]);
  EXPECT_EQ(report["frames"][0]["channels"][1]["decoded_bytes"], 0);
  EXPECT_GT(report["frames"][0]["channels"][0]["decoded_bytes"], 0);
}

// --channel is of the first volume, so that the note may not name it for the other one.
TEST_F(Channels, ofAVolumeOverAnotherTheFirstIsDrawnAndANoteSaysSo) {
  const CommandResult both = program_.run(
      "render cells.ome.zarr --channel 1 --over cells.ome.zarr --size 40x30 -o both.png");
  EXPECT_EQ(both.status, 0) << both.output;
  EXPECT_THAT(both.output,
              HasSubstr("channel 0 (DAPI) of 4 is read, as of every volume of --over"));
  EXPECT_THAT(both.output, testing::Not(HasSubstr("--channel takes")));
}

TEST_F(Channels, printedLookMakesThePictureAgain) {
  render("cells.ome.zarr -o a.png --background 000000 --look 2:orange,600:4000 --channel 2,0,1");
  const auto report = program_.json(
      "render cells.ome.zarr --force -o b.png --background 000000 --size 200x160 --fit volume "
      "--look 2:orange,600:4000 --channel 2,0,1");
  const std::string look = report["look"]["options"];
  EXPECT_THAT(look, StartsWith("--channel 2,0,1 --look=2:orange,600:4000,0.05 --look=0:00ffff"));
  render("cells.ome.tif -o b.png --background 000000 " + look);
  EXPECT_LE(difference("sum a.png b.png"), 0);
}

TEST_F(Channels, printedLookHasAllSettings) {
  const auto look = [&](const std::string& arguments, const std::string& settings) {
    const auto optionsOf = [&](const std::string& name, const std::string& options) {
      const auto report = program_.json(fmt::format(
          "render cells.ome.zarr --force --size 48x40 -o {} {} {}", name, arguments, options));
      return report["look"]["options"].get<std::string>();
    };
    const std::string printed = optionsOf("first.png", settings);
    EXPECT_EQ(optionsOf("again.png", printed), printed);
    EXPECT_TRUE(readFile(program_.folder / "first.png") == readFile(program_.folder / "again.png"))
        << arguments << " " << settings << "\n"
        << printed;
  };
  for (const char* settings :
       {"", "--shade --light 50,20 --ambient 0.1", "--shade --shadows=0.5", "--threshold 900",
        "--threshold 900 --opacity 0.2 --depth-cueing", "--labels", "--labels --opacity 0.4",
        "--look 0:labels", "--map red --range 300,4000", "--combine blend --shade --diffuse 0.3",
        "--modulate --jitter=0.5", "--opacities 500:0,3000:0.2 --shade --specular 0.6",
        "--channel 0,2 --look Spots:orange --opacity 0.3"})
    look("", settings);
  look("--mode attenuated-mip", "--attenuation 0.3");
  look("--mode mip", "--look 0:red,100:2000");
  look("--channel 1", "--look 1:green --iso 900:0.5 --shade --shadows");
}

TEST_F(Channels, turnsAndSavedViewsShowAll) {
  render("cells.ome.zarr -o turn_####.png --frames 3 --background 000000");
  render("cells.ome.zarr -o one.png --azimuth 120 --background 000000");
  EXPECT_LE(difference("sum turn_0001.png one.png"), 0);
  const auto state =
      nlohmann::json{{"sluice", "view"},
                     {"volume", {{"paths", {"cells.ome.tif"}}, {"channel", "0,Spots"}}},
                     {"look", {{"channels", {"Spots:ff0000,600:4000", "0:00ffff,400:3000"}}}},
                     {"background", {0, 0, 0}}};
  writeFile(program_.folder / "view.json", state.dump());
  const CommandResult saved =
      program_.run("render --state view.json --fit volume --size 200x160 -o saved.png");
  ASSERT_EQ(saved.status, 0) << saved.output;
  render(
      "cells.ome.tif --channel 0,2 --look 2:ff0000,600:4000 --look 0:00ffff,400:3000 -o a.png "
      "--background 000000");
  EXPECT_LE(difference("sum saved.png a.png"), 0);
}

TEST_F(Channels, packedVolumeLooksTheSame) {
  ASSERT_EQ(program_.run("pack cells.ome.zarr -o p.zarr --chunk 16").status, 0);
  render("cells.ome.zarr -o a.png --background 000000");
  render("p.zarr -o b.png --background 000000");
  EXPECT_LE(difference("sum a.png b.png"), 1);
}

TEST_F(Channels, withoutColoursArePackedWithoutThem) {
  for (const char* file : {"plain.ome.tif", "plain.tif"}) {
    ASSERT_EQ(program_.run(fmt::format("pack {} -o plain.zarr --force", file)).status, 0);
    for (const char* shown : {"", "--channel 0,1,2", "--channel 2,1"}) {
      SCOPED_TRACE(fmt::format("{} {}", file, shown));
      render(fmt::format("{} {} -o a.png --background 000000", file, shown));
      render(fmt::format("plain.zarr {} -o b.png --background 000000", shown));
      EXPECT_LE(difference("sum a.png b.png"), 0);
    }
  }
}

TEST_F(Channels, aRowOfPicturesShowsAllInEachOfThem) {
  ASSERT_EQ(program_.run("pack cells.ome.zarr -o p.zarr --chunk 16 --levels 2").status, 0);
  for (const char* mode : {"composite", "mip --downsample max"}) {
    SCOPED_TRACE(mode);
    std::string render_mode = mode;
    if (render_mode != "composite") {
      ASSERT_EQ(program_.run("pack cells.ome.zarr -o m.zarr --chunk 16 --levels 2 --downsample max")
                    .status,
                0);
      render_mode = "mip";
    }
    const std::string command =
        fmt::format("{} --mode {} --fit volume --size 200x160 --background 000000 --force",
                    render_mode == "mip" ? "m.zarr" : "p.zarr", render_mode);
    const auto report = program_.json("render " + command + " --progressive -o 'p_#.png'");
    ASSERT_GE(report["frames"][0]["pictures"].size(), 2);
    ASSERT_EQ(program_.run("render " + command + " -o whole.png").status, 0);
    EXPECT_LE(difference("sum whole.png " + report["output"].get<std::string>()), 0);
    for (const int channel : {0, 1, 2})
      ASSERT_EQ(program_
                    .run(fmt::format("render {} --level 2 --channel {} {} {} -o {}.png", command,
                                     channel, kStoredLooks[static_cast<size_t>(channel)],
                                     render_mode == "mip" ? "" : "--no-shade", channel))
                    .status,
                0);
    // The sum of the coarsest pictures, each of which is rounded.
    EXPECT_LE(difference("sum p_0.png 0.png 1.png 2.png"), 2);
  }
}

TEST_F(Channels, severalOfThemMayBeDrawnOverTime) {
  const std::string common = " --range 400,3000 --background 000000 ";
  ASSERT_EQ(program_.run("pack moving.ome.zarr -o packed.zarr").status, 0);
  for (const char* store : {"moving.ome.zarr", "packed.zarr"}) {
    render(store + common + "--channel 0,Spots --time 0:1 -o whole_#.png");
    for (const int t : {0, 1}) {
      render(
          fmt::format("{}{}--channel 0,Spots --time {} --this-step -o one.png", store, common, t));
      EXPECT_LE(difference(fmt::format("sum whole_{}.png one.png", t), 100), 0);
    }
  }
  EXPECT_THAT(program_.run("render moving.ome.zarr --channel 0,1 --time 0:2 -o a.png").output,
              HasSubstr("--time 2: the volume has 2 time steps"));
}

TEST_F(Channels, wrongOnesAreRefusedInOneLine) {
  const std::vector<std::pair<std::string, std::string>> wrong = {
      {"cells.ome.zarr --channel 0,7 -o a.png",
       "sluice: cells.ome.zarr: --channel 7: the volume has 4 channels, counted from 0\n"},
      {"cells.ome.zarr --channel 0,GFP -o a.png",
       "sluice: cells.ome.zarr: --channel GFP: the volume has no channel of that name, expected "
       "one "
       "of 0 (DAPI), 1 (Actin), 2 (Spots), 3 (Dust)\n"},
      {"cells.ome.zarr --channel 0,,1 -o a.png",
       "sluice: cells.ome.zarr: --channel 0,,1: expected a channel on both sides of each comma\n"},
      {"cells.ome.zarr --channel 1,Actin -o a.png",
       "sluice: cells.ome.zarr: --channel 1,Actin: channel 1 (Actin) comes twice\n"},
      {"cells.ome.zarr --look Dust:red -o a.png",
       "sluice: --look Dust:red: that channel is not shown; the picture shows channel 0 (DAPI), "
       "channel 1 (Actin), channel 2 (Spots)\n"},
      {"cells.ome.zarr --look 1:red --look Actin:green -o a.png",
       "sluice: --look Actin:green: channel 1 (Actin) has --look 1:red already; give one of "
       "them\n"},
      {"cells.ome.zarr --culling toc -o a.png",
       "sluice: cells.ome.zarr: --culling looks at one channel, not 3; give one --channel\n"}};
  for (const auto& [arguments, message] : wrong) {
    const CommandResult result = program_.run("render -q " + arguments);
    EXPECT_EQ(result.status, 1) << arguments;
    EXPECT_EQ(result.output, message) << arguments;
  }
  const CommandResult look = program_.run("render cells.ome.zarr --look 1:red,5:5 -o a.png");
  EXPECT_THAT(look.output, HasSubstr("--look: expected a channel and its colour"));
  const CommandResult map = program_.run("render cells.ome.zarr --look 1:nosuch -o a.png");
  EXPECT_EQ(map.status, 1);
  EXPECT_THAT(map.output, HasSubstr("--look 1:nosuch: expected one of viridis"));
}

}  // namespace
}  // namespace sluice
