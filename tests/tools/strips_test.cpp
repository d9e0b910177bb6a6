// Pictures that do not fit into their share of --memory are drawn in strips: the same files, within
// the bound that `plan` gives.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <string>
#include <utility>

#include "tests/tools/program.h"

namespace sluice::strips_test {
namespace {

using testing::HasSubstr;

constexpr const char* kVolume = "synth:phantom,dims=60x56x50 --block 16 --page 16x16x16 ";

// Whether the report's pictures had less memory than a whole one takes.
bool isInStrips(const nlohmann::json& report, int width, int height) {
  return report["picture_memory_bytes"].get<uint64_t>() <
         uint64_t{44} * static_cast<uint64_t>(width) * static_cast<uint64_t>(height);
}

// Draws the same picture whole and in strips, and compares the files.
void expectTheSame(const Program& program, const std::string& render, int width, int height,
                   const std::string& extension) {
  SCOPED_TRACE(render);
  const std::string all =
      fmt::format("render {} {} --size {}x{} --pages 64 --force ", kVolume, render, width, height);
  const auto whole = program.json(all + "--memory 900M -o whole" + extension);
  const auto strips = program.json(all + "--memory 24M -o strips" + extension);
  EXPECT_FALSE(isInStrips(whole, width, height));
  EXPECT_TRUE(isInStrips(strips, width, height));
  EXPECT_TRUE(readFile(program.folder / ("whole" + extension)) ==
              readFile(program.folder / ("strips" + extension)));
}

TEST(Strips, areTheWholePictureByteByByte) {
  const Program program;
  for (const char* way :
       {"", "--projection perspective --azimuth 30 --no-shade", "--mode mip",
        "--mode average --projection perspective", "--background 336619 --clip 1,0,0,30",
        "--annotate", "--algorithm clipped --partition boxes"})
    expectTheSame(program, std::string("--device cpu ") + way, 601, 577, ".png");
}

TEST(Strips, areTheWholePictureOnGlToo) {
  const Program program;
  if (program.run("render synth:phantom,dims=8x8x8 --device gl --size 16x16 -o try.png").status !=
      0)
    GTEST_SKIP() << "no OpenGL";
  for (const char* way : {"", "--projection perspective --azimuth 30", "--mode mip"})
    expectTheSame(program, std::string("--device gl ") + way, 601, 577, ".png");
  expectTheSame(program, "--device gl --aov depth,opacity", 500, 577, ".exr");
}

TEST(Strips, ofExrWithDepthAndOpacityToo) {
  const Program program;
  for (const char* way : {"", "--aov depth,opacity --background 336619", "--aov none"})
    expectTheSame(program, std::string("--device cpu ") + way, 500, 577, ".exr");
}

TEST(Strips, ofATurntable) {
  const Program program;
  const std::string render = "render " + std::string(kVolume) +
                             "--frames 3 --device cpu --size 601x577 --pages 64 --elevation 20 ";
  program.json(render + "--memory 900M -o whole_%d.png");
  EXPECT_TRUE(isInStrips(program.json(render + "--memory 24M -o strips_%d.png"), 601, 577));
  for (int frame = 0; frame < 3; ++frame)
    EXPECT_TRUE(readFile(program.folder / fmt::format("whole_{}.png", frame)) ==
                readFile(program.folder / fmt::format("strips_{}.png", frame)))
        << frame;
}

// Frames of a saved path are drawn by the library.
TEST(Strips, ofTheFramesOfASavedPath) {
  const Program program;
  writeFile(program.folder / "v.json",
            R"({"sluice": "view", "volume": {"paths": ["synth:phantom,dims=60x56x50"]},
                "path": {"kind": "turn", "frames": 2}})");
  for (const char* way : {"-o {}_%d.png", "--background 336619 -o {}_%d.png", "-o {}_%d.exr"})
    for (const auto& [name, memory] : {std::pair("whole", "900M"), {"strips", "40M"}}) {
      const CommandResult drawn = program.run(
          fmt::format("render --state v.json --device cpu --size 1000x911 -q --force --memory {} ",
                      memory) +
          fmt::format(fmt::runtime(way), name));
      ASSERT_EQ(drawn.status, 0) << drawn.output;
      if (std::string(name) == "whole") continue;
      const std::string extension = std::string(way).substr(std::string(way).size() - 4);
      for (const char* frame : {"_0", "_1"})
        EXPECT_TRUE(readFile(program.folder / ("whole" + (frame + extension))) ==
                    readFile(program.folder / ("strips" + (frame + extension))))
            << way << frame;
    }
}

TEST(Strips, ofTheFramesOfASavedPathKeepWithinTheMemory) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "a sanitizer's own memory";
#endif
  const Program program;
  writeFile(program.folder / "v.json",
            R"({"sluice": "view", "volume": {"paths": ["synth:phantom,dims=60x56x50"]},
                "path": {"kind": "turn", "frames": 2}})");
  for (const char* extension : {"png", "exr"}) {
    const CommandResult drawn =
        program.run("render --state v.json --device cpu --size 2200x2200 -q --memory 64M -o f_%d." +
                    std::string(extension));
    ASSERT_EQ(drawn.status, 0) << drawn.output;
  }
  rusage used{};
  ASSERT_EQ(getrusage(RUSAGE_CHILDREN, &used), 0);
  // The budget, and the program with its libraries. A whole picture takes 200 MiB.
  EXPECT_LE(used.ru_maxrss >> 10, 64 + 96);
}

// A strip may be empty if the picture is not; a picture is empty if all of its strips are.
TEST(Strips, sayThatThePictureIsEmpty) {
  const Program program;
  const std::string render = "render " + std::string(kVolume) +
                             "--device cpu --size 800x700 --pages 64 --memory 24M --fit volume "
                             "--force -o a.png ";
  const auto shown = program.json(render + "--zoom 0.1");
  EXPECT_EQ(shown["frames"][0]["empty"], "");
  const auto empty = program.json(render + "--threshold 250 --crop 0,0,0,2,2,2");
  EXPECT_NE(empty["frames"][0]["empty"], "");
}

TEST(Strips, ofASeriesWithCulling) {
  const Program program;
  ASSERT_EQ(program.run("synth mixing -o mix_%d.nrrd --dims 48,48,48 --steps 3 -q").status, 0);
  const std::string render =
      "render mix_%d.nrrd --time 0:2 --culling toc --threshold 100 --opacity 1 --block 8 --page "
      "8x8x8 --pages 512 --no-shade --device cpu --size 601x577 ";
  program.json(render + "--memory 900M -o whole_%d.png");
  const auto strips = program.json(render + "--memory 24M -o strips_%d.png");
  EXPECT_TRUE(isInStrips(strips, 601, 577));
  ASSERT_EQ(strips["frames"].size(), 3U);
  for (int step = 0; step < 3; ++step)
    EXPECT_TRUE(readFile(program.folder / fmt::format("whole_{}.png", step)) ==
                readFile(program.folder / fmt::format("strips_{}.png", step)))
        << step;
}

// A strip reads only the blocks that it shows: together little more than a whole picture does.
TEST(Strips, readWhatTheyShow) {
  const Program program;
  const std::string render =
      "render synth:phantom,dims=200x200x200 --block 16 --page 16x16x16 --pages 64 --device cpu "
      "--no-shade --size 500x2600 ";
  const auto whole = program.json(render + "--memory 900M -o whole.png");
  const auto strips = program.json(render + "--memory 24M -o strips.png");
  ASSERT_TRUE(isInStrips(strips, 500, 2600));
  const auto decoded = [](const nlohmann::json& report) {
    return report["frames"][0]["decoded_bytes"].get<double>();
  };
  EXPECT_GT(decoded(strips), 0);
  EXPECT_LT(decoded(strips), 4 * decoded(whole));
}

// The memory of the process until the file is written stays within the bound that `plan` gives.
TEST(Strips, keepWithinTheBoundOfPlan) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "a sanitizer's own memory";
#endif
  const Program program;
  // A whole picture takes more than the bound: 140 MiB as PNG, 170 MiB as EXR.
  for (const auto& [extension, memory] : {std::pair("png", "24M"), {"exr", "64M"}}) {
    const std::string what =
        std::string(kVolume) + "--device cpu --size 2000x2000 --memory " + memory + " --pages 64";
    SCOPED_TRACE(fmt::format("{} {}", extension, memory));
    const auto plan = program.json("plan " + what);
    const auto report = program.json(fmt::format("render {} --force -o large.{}", what, extension));
    const auto peak = report["peak_anonymous_bytes"].get<uint64_t>();
    EXPECT_LE(peak, plan["memory"]["peak_bytes"].get<uint64_t>());
    EXPECT_LT(plan["memory"]["picture_bytes"].get<uint64_t>(), uint64_t{44} * 2000 * 2000);
    EXPECT_LE(plan["memory"]["buffer_bytes"].get<uint64_t>(),
              plan["memory"]["budget_bytes"].get<uint64_t>());
    EXPECT_LE(plan["memory"]["picture_bytes"].get<uint64_t>(),
              plan["memory"]["buffer_bytes"].get<uint64_t>());
  }
}

// A picture with occlusion depends on its maps, so it is drawn whole, or the memory is too little.
TEST(Strips, areNotMadeWithOcclusion) {
  const Program program;
  const std::string render = "render " + std::string(kVolume) +
                             "--device cpu --size 900x800 --pages 64 --occlusion clip --force ";
  const CommandResult refused = program.run(render + "--memory 24M -o strips.png");
  EXPECT_EQ(refused.status, 1);
  EXPECT_THAT(refused.output, HasSubstr("--memory 24.0 MiB is too small"));
  EXPECT_FALSE(isInStrips(program.json(render + "--memory 64M -o whole.png"), 900, 800));
}

TEST(Strips, doNotGoWithOptionsThatLookAtWholePictures) {
  const Program program;
  const CommandResult run = program.run("render " + std::string(kVolume) +
                                        "--device cpu --size 3000x3000 --memory 24M --pages 64 "
                                        "--verify -o a.png");
  EXPECT_EQ(run.status, 1);
  EXPECT_THAT(run.output, HasSubstr("--memory 24.0 MiB is too small"));
  EXPECT_FALSE(program.exists("a.png"));
}

TEST(Strips, aLargePictureTellsATerminalHowFarItIs) {
  const Program program;
  if (program.inFolder("script --version").status != 0) GTEST_SKIP() << "script is missing";
  const std::string told =
      program
          .inFolder("script -qec '" SLUICE_PROGRAM " render " + std::string(kVolume) +
                    "--device cpu --size 1800x1800 --memory 24M --pages 64 -o a.png' /dev/null")
          .output;
  EXPECT_THAT(told, testing::ContainsRegex("drawing [0-9]+ %, [0-9]+ s left"));
  EXPECT_THAT(told, testing::ContainsRegex("drawing: done in [0-9.]+ s\r\n"));
}

}  // namespace
}  // namespace sluice::strips_test
