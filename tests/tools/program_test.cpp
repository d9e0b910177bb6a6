#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <optional>
#include <sstream>

#include "io/pictures/png_file.h"
#include "tests/tools/program.h"

namespace sluice {
namespace {

using testing::HasSubstr;
using testing::Not;

TEST(Program, printsItsVersionAndHelp) {
  const Program program;
  EXPECT_EQ(program.run("--version").output, std::string(SLUICE_VERSION) + "\n");
  for (const char* command : {"info", "render", "plan", "simulate", "synth", "pack", "surface",
                              "fetch", "doctor", "bench limit", "bench render", "bench algorithms",
                              "bench simulate", "bench threshold", "bench packing"}) {
    const CommandResult help = program.run(std::string(command) + " --help");
    EXPECT_EQ(help.status, 0) << command;
    EXPECT_NE(help.output.find("--json"), std::string::npos) << command;
  }
}

TEST(Program, boxesDrawThePictureOfBlocksFromFewerSamplesAndKeepAnIndex) {
  const Program program;
  const CommandResult made =
      program.run("synth phantom -o head_96x96x96_uint8.raw --dims 96,96,96");
  ASSERT_EQ(made.status, 0) << made.output;
  const std::string line = "render head_96x96x96_uint8.raw -o a.png --size 64x64 --threshold 120 ";
  const auto blocks = program.json(line + "--partition blocks");
  const auto boxes = program.json(line + "--partition boxes --verify");
  EXPECT_LT(boxes["verify"]["max_difference"].get<double>(), 1);
  const auto &of_blocks = blocks["frames"][0], &of_boxes = boxes["frames"][0];
  EXPECT_LT(of_boxes["samples_drawn"].get<int64_t>(), of_blocks["samples_drawn"].get<int64_t>());
  EXPECT_EQ(of_boxes["samples_object"], of_blocks["samples_object"]);
  EXPECT_GT(of_boxes["boxes_drawn"].get<int64_t>(), of_blocks["boxes_drawn"].get<int64_t>());
  // The second time they come from the index.
  EXPECT_LT(program.json(line + "--partition boxes")["levels"]["disk"]["read_bytes"],
            boxes["levels"]["disk"]["read_bytes"]);
  EXPECT_EQ(program.run(line + "--partition bricks").status, 2);
}

TEST(Program, opacityFollowsTheGradientByOptionAndByFile) {
  const Program program;
  const std::string line = std::string("render ") + kSmall + " -o a.png --size 48x48 ";
  const auto plain = program.json(line + "--threshold 90 --verify");
  const auto modulated = program.json(line + "--threshold 90 --modulate --verify");
  EXPECT_LE(modulated["verify"]["max_difference"], 1);
  EXPECT_EQ(modulated["blocks"], plain["blocks"]) << "blocks follow from values alone";
  std::ofstream(program.folder / "t.json")
      << R"({"sluice_transfer_function": 1, "map": "grey", "opacities": [[90, 0.1]],
             "gradient_opacities": [[0, 0], [20, 1]]})";
  EXPECT_LE(program.json(line + "--transfer t.json --verify")["verify"]["max_difference"], 1);
  EXPECT_EQ(program.run(line + "--transfer t.json --modulate").status, 1) << "twice";
  EXPECT_EQ(program.run(line + "--threshold 90 --full-gradient 0.2").status, 2);
  EXPECT_EQ(program.run(line + "--threshold 90 --modulate --full-gradient 0").status, 2);
}

TEST(Program, occlusionAtThresholdOneIsThePlainPicture) {
  const Program program;
  const std::string line =
      std::string("render ") + kSmall +
      " -o a.png --size 96x96 --block 16 --threshold 90 --opacity 1 --occlusion clip ";
  const auto exact = program.json(line + "--opacity-threshold 1 --verify");
  EXPECT_LT(exact["verify"]["max_difference"].get<double>(), 1);
  const auto usual = program.json(line + "--verify");
  EXPECT_LE(usual["verify"]["max_difference"].get<double>(), 0.05 * 255 + 1);
  const auto& frame = usual["frames"][0];
  EXPECT_GT(frame["occlusion"]["updates"].get<int>(), 0);
  EXPECT_LT(frame["samples_taken"], exact["frames"][0]["samples_taken"]);
  EXPECT_EQ(program.run(line + "--opacity-threshold 0").status, 2);
  const CommandResult mip = program.run(line + "--mode mip");
  EXPECT_EQ(mip.status, 2);
  EXPECT_NE(mip.output.find("--occlusion"), std::string::npos) << mip.output;
}

TEST(Program, debugViewsShowPhasesMapsAndBoxes) {
  const Program program;
  const std::string line =
      std::string("render ") + kSmall +
      " -o a.png --size 96x96 --block 16 --threshold 90 --opacity 1 --debug-view ";
  EXPECT_EQ(program.run(line + "--occlusion clip --partition boxes").status, 0);
  for (const char* name : {"a.png", "a.boxes.png", "a.drawn_0.png", "a.drawn_1.png", "a.map_1.png"})
    EXPECT_TRUE(std::filesystem::exists(program.folder / name)) << name;
  EXPECT_FALSE(std::filesystem::exists(program.folder / "a.map_0.png")) << "nothing was hidden yet";
  EXPECT_EQ(program.run(line + "--occlusion clip --frames 2").status, 2);
  const CommandResult nothing = program.run(line);
  EXPECT_EQ(nothing.status, 2);
  EXPECT_NE(nothing.output.find("--occlusion"), std::string::npos) << nothing.output;
}

TEST(Program, infoSaysWhatTheVolumeIs) {
  const Program program;
  const auto info =
      program.json("info synth:cube,dims=100x50x20,type=u16,spacing=1x2x3 --block 16");
  EXPECT_EQ(info["dims"], nlohmann::json({100, 50, 20}));
  EXPECT_EQ(info["voxel_type"], "u16");
  EXPECT_EQ(info["spacing"], nlohmann::json({1.0, 2.0, 3.0}));
  EXPECT_EQ(info["time_steps"], 1);
  EXPECT_EQ(info["blocks"]["size"], 16);
  EXPECT_EQ(info["blocks"]["count"], 8 * 4 * 2);  // ceil(99/13) x ceil(49/13) x ceil(19/13)
  EXPECT_TRUE(info["index"].contains("path"));
  EXPECT_TRUE(info["index"].contains("state"));
}

TEST(Program, infoPrintsShortSpacings) {
  const Program program;
  const std::string volume =
      "info synth:cube,dims=9x8x7,spacing=1.1x0.9999999999999999x1.6999999999999997 --levels";
  EXPECT_NE(program.run(volume).output.find("spacing 1.1 x 1 x 1.7, "), std::string::npos);
  EXPECT_EQ(program.json(volume)["spacing"],
            nlohmann::json({1.1, 0.9999999999999999, 1.6999999999999997}));
}

TEST(Program, infoGivesValuesTheirRangeHoweverLarge) {
  const Program program;
  std::string bytes;
  for (int i = 0; i < 512; ++i) {
    const float value = i == 7 ? -1e38F : i == 9 ? 3e38F : 1e38F;
    bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
  }
  writeFile(program.folder / "v_8x8x8_float32.raw", bytes);
  const auto info = program.json("info v_8x8x8_float32.raw");
  EXPECT_FLOAT_EQ(info["value_range"][0].get<float>(), -1e38F);
  EXPECT_FLOAT_EQ(info["value_range"][1].get<float>(), 3e38F);
  EXPECT_NE(program.run("info v_8x8x8_float32.raw").output.find("are drawn as infinities"),
            std::string::npos);
}

// Values that follow by a factor have no digits of its rounding, and a background that no voxel has
// is none.
TEST(Program, infoGivesValuesThatTheDataHave) {
  const Program program;
  std::string voxels;
  for (int i = 0; i < 8 * 8 * 8; ++i) {
    const int value = 50 + i % 109;  // -5 to 5.8
    voxels += {static_cast<char>(value), '\0'};
  }
  std::ofstream(program.folder / "v_8x8x8_int16.raw", std::ios::binary) << voxels;
  ASSERT_EQ(program.run("pack v_8x8x8_int16.raw -o v.zarr -q").status, 0);
  // Its array alone, as xarray writes one.
  std::filesystem::rename(program.folder / "v.zarr/0", program.folder / "w.zarr");
  writeFile(program.folder / "w.zarr/.zattrs",
            R"({"_ARRAY_DIMENSIONS": ["z", "y", "x"], "scale_factor": 0.1, "add_offset": -10})");
  const std::string info = program.run("info w.zarr").output;
  EXPECT_THAT(info, HasSubstr("  values -5 to 5.8\n"));
  EXPECT_THAT(info, HasSubstr(" a side\n"));
  EXPECT_THAT(info, Not(HasSubstr("not all")));
}

TEST(Program, theSecondOpeningReadsTheIndex) {
  const Program program;
  const CommandResult made =
      program.run("synth phantom -o head_40x40x40_uint8.raw --dims 40,40,40");
  ASSERT_EQ(made.status, 0) << made.output;
  EXPECT_EQ(program.json("info head_40x40x40_uint8.raw")["index"]["state"], "built");
  EXPECT_EQ(program.json("info head_40x40x40_uint8.raw")["index"]["state"], "read");
  // After another voxel and another modification time, the index is built again.
  std::fstream file(program.folder / "head_40x40x40_uint8.raw",
                    std::ios::in | std::ios::out | std::ios::binary);
  file.seekp(20000);
  file.put('\xff');
  file.close();
  EXPECT_EQ(program.json("info head_40x40x40_uint8.raw")["index"]["state"], "built");
}

TEST(Program, rendersAPictureAndReportsWhatItTook) {
  const Program program;
  const CommandResult result =
      program.run(std::string("render ") + kSmall +
                  " -o a.png --size 80x60 --azimuth 20 --device gl --report r.json --verify");
  ASSERT_EQ(result.status, 0) << result.output;
  const Rgba8Picture picture = readPng(program.folder / "a.png");
  EXPECT_EQ(picture.width, 80);
  EXPECT_EQ(picture.height, 60);
  EXPECT_GT(*std::max_element(picture.rgba.begin(), picture.rgba.end()), 30);

  const auto report = nlohmann::json::parse(readFile(program.folder / "r.json"));
  EXPECT_EQ(report["command"], "render");
  EXPECT_EQ(report["options"]["size"], "80x60");
  EXPECT_EQ(report["frames"].size(), 1U);
  for (const char* stage :
       {"classify", "plan", "read", "decode", "copy", "upload", "draw", "write"})
    EXPECT_GE(report["frames"][0]["stages"][stage].get<double>(), 0) << stage;
  EXPECT_GT(report["frames"][0]["samples_drawn"].get<int64_t>(), 0);
  EXPECT_EQ(report["frames"][0]["samples_drawn"], report["frames"][0]["samples_object"]);
  for (const char* level : {"volume_buffer", "texture_buffer", "texture_cache"}) {
    const auto& counters = report["levels"][level];
    EXPECT_EQ(counters["requests"].get<int64_t>(),
              counters["hits"].get<int64_t>() + counters["misses"].get<int64_t>())
        << level;
    EXPECT_LE(counters["peak_bytes"].get<uint64_t>(), counters["budget_bytes"].get<uint64_t>());
  }
  EXPECT_TRUE(report["levels"]["disk"].contains("read_bytes"));
  EXPECT_GT(report["levels"]["texture_cache"]["uploaded_bytes"].get<int64_t>(), 0);
  EXPECT_GT(report["peak_rss_bytes"].get<int64_t>(), 1 << 20);
  EXPECT_TRUE(report["gl"].contains("renderer"));
  EXPECT_LE(report["verify"]["max_difference"].get<double>(), 1.0);
}

TEST(Program, framesAreNumberedAndTurn) {
  const Program program;
  ASSERT_EQ(program.run(std::string("render ") + kSmall + " -o t.png --frames 3 --size 32").status,
            0);
  ASSERT_EQ(
      program.run(std::string("render ") + kSmall + " -o p_%02d.png --frames 2 --size 32").status,
      0);
  for (const char* name : {"t_000.png", "t_001.png", "t_002.png", "p_00.png", "p_01.png"})
    EXPECT_TRUE(program.exists(name)) << name;
  EXPECT_NE(readFile(program.folder / "t_000.png"), readFile(program.folder / "t_001.png"));
}

TEST(Program, aPathOfKeyFramesMovesTheCamera) {
  const Program program;
  writeFile(program.folder / "path.json",
            R"({"keys": [{"at": 0, "azimuth": 10}, {"at": 1, "azimuth": 70, "zoom": 2}]})");
  ASSERT_EQ(program
                .run(std::string("render ") + kSmall +
                     " -o k.png --view plain --path path.json --frames 2 --size 40 --step 1")
                .status,
            0);
  ASSERT_EQ(program
                .run(std::string("render ") + kSmall +
                     " -o end.png --view plain --azimuth 70 --zoom 2 --size 40 --step 1")
                .status,
            0);
  EXPECT_EQ(readFile(program.folder / "k_001.png"), readFile(program.folder / "end.png"));
}

TEST(Program, aBackgroundLeavesNoTransparency) {
  const Program program;
  ASSERT_EQ(program.run(std::string("render ") + kSmall + " -o a.png --size 24 --background 204060")
                .status,
            0);
  const Rgba8Picture picture = readPng(program.folder / "a.png");
  EXPECT_EQ(picture.rgba[0], 0x20);
  EXPECT_EQ(picture.rgba[1], 0x40);
  EXPECT_EQ(picture.rgba[2], 0x60);
  for (size_t i = 3; i < picture.rgba.size(); i += 4) ASSERT_EQ(picture.rgba[i], 255);
}

TEST(Program, doctorListsEveryWayToOpenGl) {
  const Program program;
  const auto report = program.json("doctor");
  EXPECT_EQ(report["version"], SLUICE_VERSION);
  EXPECT_GT(report["memory_bytes"].get<uint64_t>(), uint64_t{1} << 28);
  ASSERT_GE(report["gl"].size(), 2U);
  for (const auto& way : report["gl"]) {
    EXPECT_TRUE(way["backend"] == "osmesa" || way["backend"] == "egl");
    if (way["works"].get<bool>()) {
      EXPECT_GE(way["max_3d_texture_size"].get<int>(), 256);
    } else {
      EXPECT_NE(way["reason"], "");
    }
  }
}

TEST(Program, eachDeviceGivesTheSamePictureAndSaysWhichItIs) {
  const Program program;
  const auto report = program.json("doctor");
  const std::string automatic = report["device"]["auto"];
  EXPECT_TRUE(automatic == "gl" || automatic == "cpu");
  EXPECT_NE(report["device"]["reason"], "");
  std::vector<std::string> ways{"--device cpu"};
  for (const auto& target : report["simd"])
    ways.push_back("--device cpu --simd " + target.get<std::string>());
  if (std::any_of(report["gl"].begin(), report["gl"].end(),
                  [](const auto& way) { return way["works"].template get<bool>(); }))
    ways.emplace_back("--device gl");
  std::optional<Rgba8Picture> first;
  for (const std::string& way : ways) {
    ASSERT_EQ(program
                  .run(std::string("render ") + kSmall +
                       " -q -o d.png --size 64 --force --report d.json " + way)
                  .status,
              0)
        << way;
    const bool on_gl = way == "--device gl";
    const auto frame = nlohmann::json::parse(std::ifstream(program.folder / "d.json"));
    EXPECT_EQ(frame["device"], on_gl ? "gl" : "cpu");
    const uint64_t uploaded_bytes = frame["levels"]["texture_cache"]["uploaded_bytes"];
    EXPECT_EQ(uploaded_bytes == 0, !on_gl) << way;
    const Rgba8Picture picture = readPng(program.folder / "d.png");
    if (!first) first = picture;
    int most = 0;
    for (size_t i = 0; i < picture.rgba.size(); ++i)
      most = std::max(most, std::abs(picture.rgba[i] - first->rgba[i]));
    EXPECT_LE(most, on_gl ? 3 : 1) << way;
  }
}

TEST(Program, aDeviceThatIsNotThereIsOneLine) {
  const Program program;
  EXPECT_EQ(program.run(std::string("render ") + kSmall + " -o d.png --device none").status, 2);
  EXPECT_EQ(program.json("bench limit --frames 1 --device cpu --threads 1")["device"], "cpu");
}

TEST(Program, eachGlGivesTheSamePicture) {
  const Program program;
  const auto report = program.json("doctor");
  std::vector<Rgba8Picture> pictures;
  for (const std::string backend : {"osmesa", "egl"}) {
    const bool works = std::any_of(report["gl"].begin(), report["gl"].end(), [&](const auto& way) {
      return way["backend"] == backend && way["works"].template get<bool>();
    });
    if (!works) GTEST_SKIP() << backend << " does not work on this machine";
    ASSERT_EQ(
        program.run(std::string("render ") + kSmall + " -o g.png --size 64 --gl " + backend).status,
        0);
    pictures.push_back(readPng(program.folder / "g.png"));
  }
  int most = 0;
  for (size_t i = 0; i < pictures[0].rgba.size(); ++i)
    most = std::max(most, std::abs(pictures[0].rgba[i] - pictures[1].rgba[i]));
  EXPECT_LE(most, 2);
}

TEST(Program, reportsSayWhatWasUsed) {
  const Program program;
  const auto options = [&](const std::string& more) {
    return program.json(std::string("render ") + kSmall + " -o a.png --force --device cpu " +
                        more)["options"];
  };
  // Pixels are smaller than voxels, and the picture is lit.
  EXPECT_EQ(options("--size 300 --shade")["step"], "0.25");
  EXPECT_EQ(options("--size 300 --no-shade")["step"], "0.5");
  EXPECT_EQ(options("--size 300 --step 2")["step"], "2");
  EXPECT_FALSE(options("--size 32 --mode mip").contains("step"));
  const nlohmann::json all = options("--size 32 -j 2");
  EXPECT_EQ(all["threads"], "2");
  EXPECT_NE(options("--size 32")["threads"], "0");
  EXPECT_EQ(all["device"], "cpu");
  EXPECT_NE(all["simd"], "auto");
}

}  // namespace
}  // namespace sluice
