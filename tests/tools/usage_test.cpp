// Wrong usage and bad input: one line that says what to do, and the status.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "io/pictures/png_file.h"
#include "tests/tools/program.h"

namespace sluice {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

// Options of drawing that would change nothing are in no help, and giving one is a warning.
TEST(Usage, commandsSayWhichOptionsTheyIgnore) {
  const Program program;
  const std::string reading = "--device cpu,--gl egl,--simd avx2,--pages 64,--policy fifo,--seed 3";
  const std::string window =
      "--simd avx2,--pages 64,--policy fifo,--seed 3,--page 8x8x8,--block 16,--algorithm clipped,"
      "--merge paper,--partition boxes,--occlusion cull,--opacity-threshold 0.9,--time-limit 1";
  for (const auto& [command, options] : {std::pair<std::string, std::string>{"info", reading},
                                         {"prepare", reading},
                                         {"bench packing", reading},
                                         {"view", window}}) {
    std::istringstream listed(options);
    for (std::string option; std::getline(listed, option, ',');) {
      const std::string name = option.substr(0, option.find(' '));
      // The file that is missing ends the command once its options are taken.
      const CommandResult result = program.run(command + " none.nrrd " + option);
      EXPECT_EQ(result.status, 1) << command << " " << option << ": " << result.output;
      EXPECT_NE(result.output.find("sluice: warning: " + name + " changes nothing here\n"),
                std::string::npos)
          << result.output;
      const std::string help = command == "view" ? " --help-all" : " --help";
      EXPECT_EQ(program.run(command + help).output.find(" " + name + " "), std::string::npos)
          << command << " " << name;
    }
  }
}

TEST(Usage, wrongUsageIsOneLineAndStatusTwo) {
  const Program program;
  for (const char* line :
       {"paint", "render", "render synth:cube -o a.png --size 0x4",
        "render synth:cube -o a.png --threshold 1 --transfer b.json",
        "render synth:cube -o a.png --mode x", "render synth:cube -o a.png --page 3x4x5",
        "render synth:cube -o a.png --pages 100", "render synth:cube -o a.png --eye 1,2,3",
        "info synth:cube --dims 0,1,1", "info synth:cube --memory lots", "synth paper -o a.raw",
        "bench", "render synth:cube -o a.png --map nosuch",
        // Options that contradict each other.
        "render synth:cube -o a.png --shadows --no-shade",
        "render synth:cube -o a.png --iso 9 --mode mip", "plan synth:cube --iso 9 --mode mip",
        "render synth:cube -o a.png --culling toc --iso 9",
        "render synth:cube -o a.png --culling toc --mode mip",
        "render synth:cube -o a.png --occlusion cull --mode mip",
        "render synth:cube -o a.png --culling toc --level 1",
        "plan synth:cube --partition boxes --level 1", "plan synth:cube --culling auto",
        "render synth:cube -o a.mp4", "render synth:cube -o a.mp4 --frames 2 --continue",
        "render synth:cube -o a.mp4 --frames 2 --progressive",
        "render synth:cube -o a.png --progressive --culling toc",
        "render synth:cube -o a.png --aov depth", "render synth:cube -o a.exr --annotate",
        "render synth:cube -o a.png --annotate --size 9",
        "render synth:cube -o a.exr --aov depth --mode mip",
        "render synth:cube -o a_%d.png --debug-view --occlusion map --frames 2",
        "render synth:cube -o a.png --debug-view",
        "render synth:cube -o a_%d.png --time 0:1 --frames 2",
        "render synth:cube -o a.png --over synth:ball --combine blend --iso 9",
        "plan synth:cube --channel 0,1 --combine blend --mode mip",
        "prepare synth:cube --iso 9 --basis none.json",
        "pack synth:cube -o a.zarr --zarr 2 --shard 64x64x64"}) {
    const CommandResult result = program.run(line);
    EXPECT_EQ(result.status, 2) << line << ": " << result.output;
    EXPECT_TRUE(isOneLine(result.output)) << result.output;
  }
}

TEST(Usage, aForgottenOutputIsTheLastWordUnlessItBelongsToAnOption) {
  const Program program;
  const auto said = [&](const std::string& words) {
    return program.run("render synth:cube " + words).output;
  };
  EXPECT_THAT(said("a.png"), HasSubstr("--output is required; to write a.png, give -o a.png"));
  EXPECT_THAT(said("-q a.png"), HasSubstr("to write a.png"));
  const CommandResult result = program.run("surface synth:cube --iso 9 -j 1");
  EXPECT_THAT(result.output, AllOf(HasSubstr("--output is required"), Not(HasSubstr("to write"))));
}

// One command shows a file: its picture is named after it and says how large things are.
TEST(Usage, aPictureWithoutANameIsNamedAfterItsVolumeAndAnnotated) {
  const Program program;
  ASSERT_EQ(program.run("synth shells --dims 24,24,24 -o step_0.nrrd").status, 0);
  ASSERT_EQ(program.run("pack synth:shells,dims=24x24x24 -o c.ome.zarr -q").status, 0);
  const auto picture = [&](const std::string& name) { return readPng(program.folder / name).rgba; };
  for (const auto& [words, written] : std::vector<std::pair<std::string, std::string>>{
           {"synth:shells,dims=24x24x24", "shells.png"},
           {"'step_%d.nrrd'", "step.png"},
           {"c.ome.zarr", "c.png"},
           {"synth:cube,dims=24x24x24 --frames 2", "cube_001.png"}}) {
    ASSERT_EQ(program.run("render -s 160 " + words).status, 0) << words;
    ASSERT_EQ(program.run("render -s 160 --force -o x.png --annotate " + words).status, 0);
    EXPECT_EQ(picture(written), picture(written == "cube_001.png" ? "x_001.png" : "x.png"))
        << words;
  }
  // No room for letters.
  EXPECT_EQ(program.run("render synth:cube -s 64").status, 0);
  // Neither a file of others nor a slice is written over.
  writeFile(program.folder / "shells.png", "mine");
  EXPECT_EQ(program.run("render synth:shells,dims=24x24x24 -s 160").status, 1);
  EXPECT_EQ(readFile(program.folder / "shells.png"), "mine");
  ASSERT_EQ(program.run("render synth:shells -o slice.png -s 64").status, 0);
  ASSERT_EQ(program.run("render slice.png -s 64").status, 0);
  EXPECT_TRUE(std::filesystem::exists(program.folder / "slice_drawn.png"));
}

TEST(Usage, badInputIsOneLineAndStatusOne) {
  const Program program;
  writeFile(program.folder / "short_16x16x16_uint8.raw", std::string(4000, 'x'));
  writeFile(program.folder / "noise.bin", "not a volume");
  std::filesystem::create_directory(program.folder / "empty");
  const std::vector<std::pair<std::string, std::string>> cases = {
      {"info missing.nrrd", "missing.nrrd"},
      {"info short_16x16x16_uint8.raw", "4096"},
      {"info noise.bin", "noise.bin"},
      {"info empty", "empty"},
      {"render synth:cube,dims=16x16x16 -o a.jpg", ".png"},
      {"render synth:cube,dims=16x16x16 -o nowhere/a.png", "nowhere/a.png"},
      {"render synth:cube,dims=16x16x16 -o a.png --transfer none.json", "none.json"},
      {"render synth:cube,dims=16x16x16 -o a.png --time 3", "--time 3"},
      {"render synth:cube,dims=64x64x64 -o a.png --memory 1M", "--memory"},
      {"simulate noise.bin --format text", "noise.bin"}};
  for (const auto& [line, named] : cases) {
    const CommandResult result = program.run(line);
    EXPECT_EQ(result.status, 1) << line << ": " << result.output;
    EXPECT_TRUE(isOneLine(result.output)) << result.output;
    EXPECT_NE(result.output.find(named), std::string::npos) << result.output;
  }
  EXPECT_FALSE(program.exists("a.png"));
}

TEST(Usage, picturesBeyondTheDeviceAreRefusedAlikeByPlanAndRender) {
  const Program program;
  const std::string more = " synth:cube,dims=16x16x16 --device cpu --size ";
  for (const std::string size : {"20000x10", "10x70000"})
    for (const std::string command : {"plan", "render -o a.png", "render -o a.exr"}) {
      const CommandResult refused = program.run(command + more + size);
      EXPECT_EQ(refused.status, 1);
      EXPECT_EQ(refused.output, "sluice: --size " + size +
                                    ": this device draws at most 16384 pixels along an axis; give "
                                    "less\n");
    }
  EXPECT_EQ(program.run("plan" + more + "16384x10").status, 0);
}

TEST(Usage, benchesOfOneChannelRefuseSeveral) {
  const Program program;
  for (const std::string bench : {"render", "algorithms", "skipping", "occlusion", "culling",
                                  "levels", "quality", "threshold", "packing"}) {
    const CommandResult refused = program.run("bench " + bench + " a.ome.zarr --channel 0,1");
    EXPECT_EQ(refused.status, 2) << bench;
    EXPECT_EQ(refused.output, "sluice: --channel: bench " + bench +
                                  " measures one channel, found '0,1'; give one\n");
  }
  EXPECT_EQ(program.run("bench channels a.ome.zarr --channel 0,1").status, 1) << "no such file";
}

TEST(Usage, theLeastMemoryThatAnErrorNamesWorks) {
  const Program program;
  const std::string line = "render synth:shells,dims=70x70x70 -o a.png --size 32x32 --memory ";
  const CommandResult refused = program.run(line + "1M");
  ASSERT_EQ(refused.status, 1);
  // The CPU device borrows chunks, and software OpenGL has textures.
  EXPECT_NE(refused.output.find(" of chunks and "), std::string::npos) << refused.output;
  EXPECT_NE(program.run(line + "1M --device gl").output.find(" of textures and "),
            std::string::npos);
  const size_t at = refused.output.find("give --memory ");
  ASSERT_NE(at, std::string::npos) << refused.output;
  const std::string least = std::to_string(std::stoull(refused.output.substr(at + 14)));
  EXPECT_EQ(program.run(line + least).status, 0) << program.run(line + least).output;
}

}  // namespace
}  // namespace sluice
