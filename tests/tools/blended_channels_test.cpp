// Blended pictures of several channels, against NumPy and against each other.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "tests/tools/channels_fixture.h"

namespace sluice {
namespace {

using testing::HasSubstr;

using BlendedChannels = Channels;

TEST_F(BlendedChannels, samplesAreThoseOfNumPy) {
  const double zoom = std::sqrt(47.0 * 47 + 31 * 31 + 8 * 8) / 2 / 16;
  for (const char* options : {"", "--simd plain", "--simd sse4", "--block 16 --page 16x16x16",
                              "--device gl --gl osmesa"}) {
    const std::string command = fmt::format(
        "render deep.ome.zarr --combine blend --opacity 0.4 --view plain --fit volume "
        "--zoom {} --step 1 --size 48x32 --background 000000 --force -o deep.png {}",
        zoom, options);
    const CommandResult drawn = program_.run(command);
    if (drawn.output.find("has no such instructions") != std::string::npos ||
        (drawn.status != 0 && std::string_view(options).starts_with("--device gl")))
      continue;
    ASSERT_EQ(drawn.status, 0) << drawn.output;
    EXPECT_LE(difference("deep deep.png"), 2) << options;
  }
}

TEST_F(BlendedChannels, pictureIsTheSameForAllBlocksAndBudgets) {
  for (const char* options :
       {"", "--block 16 --page 16x16x16", "--memory 80M", "--memory 60M --block 16 --page 16x16x16",
        "--projection perspective --shade", "--depth-cueing --jitter --clip 1,0.3,0,25",
        "--algorithm conventional", "--algorithm clipped", "--crop 10,5,2,70,60,17"}) {
    const auto report =
        program_.json(fmt::format("render cells.ome.zarr --combine blend {} --size 200x160 --force "
                                  "--verify -o a.png",
                                  options));
    EXPECT_LE(report["verify"]["max_difference"], 1) << options;
    EXPECT_EQ(report["verify"]["differing_pixels"], 0) << options;
    EXPECT_EQ(report["channels"].size(), 3) << options;
  }
}

// Lit and not, labels and gradients, with as many boxes a block as there may be.
TEST_F(BlendedChannels, picturesOfBothDevicesAreAlike) {
  if (program_.run("render cells.ome.zarr --force --gl osmesa -o try.png").status != 0)
    GTEST_SKIP() << "no software OpenGL";
  for (const char* options :
       {"cells.ome.zarr --projection perspective --shade", "cells.ome.zarr --step 1.3 --block 16",
        "cells.ome.zarr --channel 0,1 --clip 0,0,1,12 --shade --depth-cueing --jitter",
        "cells.ome.zarr --modulate --shade --projection perspective",
        "cells.ome.zarr --crop 30,0,0,32,60,18 --memory 80M --block 16 --page 16x16x16",
        "eight.ome.zarr --channel 0,1,2,3,4,5,6,7 --over flat.ome.zarr --look over:labels,0.3"}) {
    const std::string command = fmt::format("{} --combine blend -o ", options);
    render(command + "cpu.png --device cpu");
    render(command + "gl.png --device gl --gl osmesa");
    EXPECT_LE(difference("sum cpu.png gl.png", 20), 1) << options;
  }
}

TEST_F(BlendedChannels, withOneThatShowsNothingIsThePictureOfTheOther) {
  for (const char* view : {"--no-shade", "--no-shade --projection perspective", "--shade"}) {
    const std::string common = fmt::format(" {} --background 000000 --step 1 -o ", view);
    render("cells.ome.zarr --channel 0,3 --combine blend --look 3:red,65000:65535" + common +
           "both.png");
    render(fmt::format("cells.ome.zarr --channel 0 {} {}one.png", kStoredLooks[0], common));
    EXPECT_LE(difference("sum both.png one.png", 100), 1) << view;
  }
}

// Strips load the blocks that they show alone, of which the cache keeps few here.
TEST_F(BlendedChannels, stripsLoadTheirPartAlone) {
  const std::string command =
      "render cells.ome.zarr --combine blend --step 1 --size 2000x1500 --force --quiet --block 16 "
      "--page 16x16x16 --pages 8 ";
  const auto whole = program_.json(command + "-o whole.png");
  const auto strips = program_.json(command + "--memory 60M -o strips.png");
  EXPECT_LE(difference("sum strips.png whole.png"), 0);
  const auto loaded = [](const auto& report) {
    return report["levels"]["texture_cache"]["pages_loaded"].template get<double>();
  };
  EXPECT_GT(loaded(strips), 5 * loaded(whole));
  EXPECT_LT(loaded(strips), 25 * loaded(whole));  // 47 if each loads all
}

// A plan has the chunks that pictures are drawn from, and refuses what pictures do.
TEST_F(BlendedChannels, planIsThatOfThePicture) {
  for (const char* room : {"--pages 8", "--memory 40M"}) {
    const std::string options = fmt::format(
        " cells.ome.zarr --combine blend --step 1 --size 200x160 --block 16 --page 16x16x16 {} ",
        room);
    const auto plan = program_.json("plan" + options)["algorithms"]["merged"];
    const auto frame = program_.json("render" + options + "--force -o a.png")["frames"][0];
    EXPECT_GT(plan["chunks"], 0);
    EXPECT_EQ(plan["chunks"], frame["chunks"]) << room;
    EXPECT_EQ(plan["pages"], frame["pages"]) << room;
  }
  const CommandResult refused = program_.run("plan cells.ome.zarr --combine blend --mode mip");
  EXPECT_EQ(refused.status, 2);
  EXPECT_THAT(refused.output, HasSubstr("--combine blend needs --mode composite"));
}

// As many channels as pictures show, and a volume over them.
TEST_F(BlendedChannels, mayBeNineLayers) {
  const auto report = program_.json(
      "render eight.ome.zarr --channel 0,1,2,3,4,5,6,7 --over flat.ome.zarr --combine blend "
      "--step 1 --size 48x32 --verify -o a.png");
  EXPECT_EQ(report["channels"].size(), 9);
  EXPECT_EQ(report["verify"]["differing_pixels"], 0);
}

TEST_F(BlendedChannels, areRefusedInOneLineWhereTheyAreNotKnown) {
  for (const auto& [arguments, message] :
       {std::pair("--mode mip", "a pixel; leave out --combine, which adds the pictures"),
        std::pair("--shade --shadows", "leave out --shadows and --occlusion-light"),
        std::pair("--occlusion map", "leave out --occlusion and --partition"),
        std::pair("--partition boxes", "leave out --occlusion and --partition")}) {
    const CommandResult result =
        program_.run(fmt::format("render cells.ome.zarr --combine blend {} -o no.png", arguments));
    // As if the options named the channels, which the file does here.
    EXPECT_EQ(result.status, 2) << arguments;
    EXPECT_THAT(result.output, HasSubstr(message)) << arguments;
  }
}

}  // namespace
}  // namespace sluice
