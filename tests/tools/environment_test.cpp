// The program in its environment: terminals, pipes, limits, and the place of its indices.
#include <gtest/gtest.h>

#include <algorithm>

#include "tests/tools/program.h"

namespace sluice {
namespace {

namespace fs = std::filesystem;

std::vector<std::string> indexFiles(const fs::path& folder) {
  std::vector<std::string> files;
  if (!fs::exists(folder)) return files;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    if (entry.path().extension() == ".idx") files.push_back(entry.path().string());
  return files;
}

TEST(Environment, indicesLitterNeitherScanNorStore) {
  const Program program;
  ASSERT_EQ(program.run(std::string("pack ") + kSmall + " -o v.zarr -q").status, 0);
  fs::create_directory(program.folder / "scan");
  for (const char* angle : {"10", "20", "30"})
    ASSERT_EQ(
        program
            .run(std::string("render ") + kSmall + " -q --background 000000 --size 16 -o scan/" +
                 angle + ".png --azimuth " + angle)
            .status,
        0);
  const auto scan = filesOf(program.folder / "scan"), store = filesOf(program.folder / "v.zarr");
  for (const char* volume : {"scan", "v.zarr", "v.zarr/0"}) {
    EXPECT_EQ(program.json(std::string("info ") + volume)["index"]["state"],
              std::string(volume) == "v.zarr" ? "read" : "built");
    EXPECT_EQ(program.json(std::string("info ") + volume)["index"]["state"], "read") << volume;
  }
  EXPECT_EQ(filesOf(program.folder / "scan"), scan);
  EXPECT_EQ(filesOf(program.folder / "v.zarr"), store);
  EXPECT_GE(indexFiles(program.folder / "cache").size(), 3U);
  for (const auto& entry : fs::directory_iterator(program.folder.path()))
    EXPECT_EQ(entry.path().string().find("sluice-index"), std::string::npos) << entry.path();
}

TEST(Environment, theUserSaysWhereIndicesGo) {
  const Program program;
  ASSERT_EQ(program.run("synth shells -q -o v_20x20x20_uint8.raw --dims 20,20,20").status, 0);
  const std::string info = "info v_20x20x20_uint8.raw";
  EXPECT_EQ(program.json(info + " --index-dir mine")["index"]["state"], "built");
  EXPECT_EQ(program.json(info + " --index-dir mine")["index"]["state"], "read");
  EXPECT_EQ(indexFiles(program.folder / "mine").size(), 1U);
  EXPECT_TRUE(indexFiles(program.folder / "cache").empty());
  setenv("SLUICE_INDEX", "beside", 1);
  EXPECT_EQ(program.json(info)["index"]["state"], "built");
  unsetenv("SLUICE_INDEX");
  EXPECT_EQ(program.json(info)["index"]["state"], "read") << "found beside the volume";
  EXPECT_EQ(indexFiles(program.folder / "v_20x20x20_uint8.raw.sluice-index").size(), 1U);
}

TEST(Environment, aTurntableShowsProgressOnATerminalAndEndsItsLine) {
  const Program program;
  if (runCommand("command -v script").status != 0) GTEST_SKIP() << "script(1) is not here";
  const std::string line = std::string(SLUICE_PROGRAM) + " render " + kSmall +
                           " -o t.png --frames 40 --size 300x300 --verify";
  const CommandResult seen = runCommand("cd " + shellQuoted(program.folder.path().string()) +
                                        " && script -qec " + shellQuoted(line) + " /dev/null");
  EXPECT_EQ(seen.status, 0) << seen.output;
  EXPECT_NE(seen.output.find("s left"), std::string::npos) << seen.output;
  const size_t done = seen.output.find("frames: 40 in ");
  ASSERT_NE(done, std::string::npos) << seen.output;
  // The line of the progress ends before the next output.
  const size_t end = seen.output.find('\n', done);
  EXPECT_EQ(seen.output.substr(done, end - done).find("blocks"), std::string::npos) << seen.output;
  EXPECT_EQ(program.run(line.substr(line.find(" render") + 1) + " --force").output.find("s left"),
            std::string::npos)
      << "no terminal, no progress";
}

TEST(Environment, pipesAsFilesOfOptionsDoNotHang) {
  const Program program;
  const std::string folder = shellQuoted(program.folder.path().string());
  ASSERT_EQ(runCommand("cd " + folder + " && mkfifo pipe").status, 0);
  const std::string render = std::string("render ") + kSmall + " --size 16 -o a.png ";
  for (const char* option :
       {"--transfer pipe", "--frames 2 --path pipe", "--report pipe", "--trace pipe"}) {
    const CommandResult result =
        runCommand("cd " + folder + " && timeout 60 " SLUICE_PROGRAM " " + render + option);
    EXPECT_EQ(result.status, 1) << option << ": " << result.output;
    EXPECT_NE(result.output.find("pipe"), std::string::npos) << result.output;
  }
  // A pipe with a writer is read to its end.
  const CommandResult fed =
      runCommand("cd " + folder +
                 " && (printf '%s' '{\"keys\": [{\"at\": 0, \"azimuth\": 10}]}' > pipe &) && "
                 "timeout 60 " SLUICE_PROGRAM " " +
                 render + "--frames 2 --path pipe");
  EXPECT_EQ(fed.status, 0) << fed.output;
}

// Whatever lies at the name of a file: a pipe that nobody writes to, a folder, a device without an
// end, a circle of links, nothing.
TEST(Environment, anyFileOfAnOptionIsReadOrRefusedInOneLine) {
  const Program program;
  ASSERT_EQ(
      program
          .inFolder("mkfifo pipe && mkdir folder && ln -s b a && ln -s a b && cp -P a a.hdr && "
                    "cp -P b b.hdr")
          .status,
      0);
  writeFile(program.folder / "v_8x8x8_uint8.raw", std::string(512, '\1'));
  const std::string render = "render v_8x8x8_uint8.raw --size 16 -o out_%d.png --force ";
  for (const std::string name : {"pipe", "folder", "/dev/zero", "a", "none"})
    for (const std::string& line :
         {render + "--transfer " + name, render + "--labels --labels-table " + name,
          render + "--state " + name, render + "--frames 2 --path " + name,
          render + "--over " + name, "render v_8x8x8_uint8.raw " + name + " --size 16 -o a.png",
          "simulate " + name, "simulate --format text " + name, "info " + name,
          "bench report " + name + " " + name, "pack --check " + name}) {
      const CommandResult result =
          program.inFolder("XDG_CACHE_HOME=\"$PWD/cache\" timeout 60 " SLUICE_PROGRAM " " + line);
      EXPECT_TRUE(result.status == 1 || result.status == 2) << line << ": " << result.status;
      EXPECT_TRUE(isOneLine(result.output)) << line << ": " << result.output;
      EXPECT_NE(result.output.find(name), std::string::npos) << line << ": " << result.output;
      EXPECT_EQ(result.output.find("filesystem error"), std::string::npos) << result.output;
    }
}

TEST(Environment, aPathOfMoreThanSixteenMebibytesIsRefused) {
  const Program program;
  const std::string folder = shellQuoted(program.folder.path().string());
  ASSERT_EQ(runCommand("cd " + folder + " && truncate -s 1T big.json").status, 0);
  for (const char* option : {"--frames 2 --path", "--transfer"}) {
    const CommandResult result =
        program.run(std::string("render ") + kSmall + " -o a.png " + option + " big.json");
    EXPECT_EQ(result.status, 1);
    EXPECT_NE(result.output.find("at most 16.0 MiB"), std::string::npos) << result.output;
  }
}

TEST(Environment, aSoftLimitOfOpenFilesIsRaised) {
  const Program program;
  ASSERT_EQ(program.run("synth flow -q --dims 8,8,8 --steps 100 -o s_8x8x8_uint8_###.raw").status,
            0);
  const CommandResult result =
      runCommand("cd " + shellQuoted(program.folder.path().string()) +
                 " && ulimit -S -n 64 && " SLUICE_PROGRAM " info s_8x8x8_uint8_*.raw --time 99");
  EXPECT_EQ(result.status, 0) << result.output;
}

TEST(Environment, moreSlicesThanCanBeDrawnAreAnError) {
  const Program program;
  const CommandResult result =
      program.run(std::string("render ") + kSmall + " -o a.png --step 1e-6 --size 16");
  EXPECT_EQ(result.status, 1);
  EXPECT_NE(result.output.find("--step 1e-06: "), std::string::npos) << result.output;
  EXPECT_FALSE(program.exists("a.png"));
}

TEST(Environment, whatAKilledRunLeftIsTakenOverByTheNext) {
  const Program program;
  program.signalled("synth noise -o big.raw --dims 3000,3000,3000", "KILL", "[ -e big.raw.0.tmp ]");
  ASSERT_FALSE(program.exists("big.raw"));
  ASSERT_FALSE(fs::is_empty(program.folder.path())) << "killed too early";
  ASSERT_EQ(program.run("synth cube -q -o big.raw --dims 8,8,8").status, 0);
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(program.folder.path()))
    names.push_back(entry.path().filename().string());
  EXPECT_EQ(names, std::vector<std::string>{"big.raw"});
  EXPECT_EQ(fs::file_size(program.folder / "big.raw"), 512U);
}

TEST(Environment, infoSaysWhereTheVolumeLiesAndWhatElseTheFileHolds) {
  const Program program;
  writeFile(program.folder / "v.mhd",
            "ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = False\n"
            "TransformMatrix = 0 1 0 -1 0 0 0 0 1\nOffset = 10 -20 30\nElementSpacing = 0.5 2 3\n"
            "DimSize = 3 5 4\nElementType = MET_UCHAR\nElementDataFile = v.raw\n");
  writeFile(program.folder / "v.raw", std::string(60, 'x'));
  const auto info = program.json("info v.mhd");
  EXPECT_EQ(info["origin"], nlohmann::json({10.0, -20.0, 30.0}));
  // x runs along world y by 2 * 0.5, y along -x by 4 * 2, z by 3 * 3.
  EXPECT_EQ(info["bounds"], nlohmann::json({{2.0, -20.0, 30.0}, {10.0, -19.0, 39.0}}));
  for (const char* name :
       {"unit", "orientation", "channels", "channel", "levels", "grids", "notes"})
    EXPECT_TRUE(info.contains(name)) << name;
  EXPECT_TRUE(info["orientation"].contains("frame"));
  const std::string text = program.run("info v.mhd").output;
  EXPECT_NE(text.find("from (2, -20, 30) to (10, -19, 39)"), std::string::npos) << text;
  EXPECT_NE(text.find("origin (10, -20, 30)"), std::string::npos) << text;
  EXPECT_NE(text.find("orientation"), std::string::npos) << text;
}

TEST(Environment, planForecastsWhatAFrameReadsAndHolds) {
  const Program program;
  const std::string volume = "synth:shells,dims=150x140x130 --threshold 90 --size 200x200";
  const auto plan = program.json("plan " + volume);
  const auto drawn = program.json("render " + volume + " -o a.png");
  EXPECT_EQ(plan["read"]["voxel_bytes"], drawn["frames"][0]["decoded_bytes"]);
  EXPECT_LE(drawn["peak_rss_bytes"].get<int64_t>(), plan["memory"]["peak_bytes"].get<int64_t>());
  EXPECT_TRUE(plan["memory"]["fits"].get<bool>());
  EXPECT_GE(plan["memory"]["machine_bytes"].get<uint64_t>(), uint64_t{1} << 28);
  // The least memory that it names works, and a byte less does not.
  const auto least = plan["memory"]["least_bytes"].get<uint64_t>();
  const auto tight = program.json("plan " + volume + " --gl osmesa --pages 64 --memory 1M");
  EXPECT_FALSE(tight["memory"]["fits"].get<bool>());
  const auto smallest = tight["memory"]["least_bytes"].get<uint64_t>();
  const std::string line = "render " + volume + " --gl osmesa --pages 64 -o b.png --memory ";
  EXPECT_EQ(program.run(line + std::to_string(smallest)).status, 0);
  EXPECT_EQ(program.run(line + std::to_string(smallest - 1)).status, 1);
  EXPECT_GT(least, 0U);
  const std::string text = program.run("plan " + volume).output;
  EXPECT_NE(text.find("fits this machine"), std::string::npos) << text;
}

}  // namespace
}  // namespace sluice
