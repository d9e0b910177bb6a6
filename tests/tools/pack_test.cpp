// sluice pack in a user's hands: killed, interrupted, out of room, in parallel to another.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <map>

#include "tests/tools/program.h"

namespace sluice {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::Not;

// Takes a second or more on one thread: enough to be interrupted in.
constexpr const char* kSlow = "synth:noise,dims=200x200x400,type=u16";
constexpr const char* kOptions = " --codec zstd --level 7 --threads 1 --chunk 32";

// A line of sh in which $SLUICE is the program.
CommandResult shell(const Program& program, const std::string& line) {
  return runCommand("cd " + shellQuoted(program.folder.path().string()) +
                    " && export XDG_CACHE_HOME=\"$PWD/cache\" && SLUICE=" SLUICE_PROGRAM " && { " +
                    line + "\n}");
}

TEST(PackCommand, packsChecksAndIsOpenedWithItsIndexRead) {
  const Program program;
  const auto report = program.json(
      "pack synth:shells,dims=90x70x50,spacing=1x2x3 -o v.zarr --chunk 32 --verify --unit "
      "micrometer");
  EXPECT_EQ(report["chunks"]["count"], 3 * 3 * 2);
  EXPECT_EQ(report["voxel_bytes"], 90 * 70 * 50);
  EXPECT_TRUE(report["verified"]);
  EXPECT_EQ(report["index"]["state"], "built");
  const auto info = program.json("info v.zarr");
  EXPECT_EQ(info["dims"], nlohmann::json({90, 70, 50}));
  EXPECT_EQ(info["spacing"], nlohmann::json({1.0, 2.0, 3.0}));
  EXPECT_EQ(info["index"]["state"], "read");
  EXPECT_EQ(program.run("pack --check v.zarr").status, 0);
  // A chunk with one bit changed.
  std::fstream file(program.folder / "v.zarr/0/0/1/1",
                    std::ios::in | std::ios::out | std::ios::binary);
  file.seekg(100);
  const int byte = file.get();
  file.seekp(100);
  file.put(static_cast<char>(byte ^ 1));
  file.close();
  for (const char* line :
       {"pack --check v.zarr", "render v.zarr -o a.png --size 32 --algorithm conventional"}) {
    const CommandResult result = program.run(line);
    EXPECT_EQ(result.status, 1);
    EXPECT_TRUE(isOneLine(result.output)) << result.output;
    EXPECT_NE(result.output.find("v.zarr/0/0/1/1"), std::string::npos) << result.output;
  }
  EXPECT_FALSE(program.exists("a.png"));
}

TEST(PackCommand, aPackedVolumeGivesTheSamePicture) {
  const Program program;
  std::vector<std::string> volumes = {"synth:shells,dims=80x70x60,spacing=1x1.5x2"};
  const std::string bonsai = SLUICE_DATA_DIR "/bonsai.nii.gz";
  if (fs::exists(bonsai)) volumes.push_back(bonsai);
  for (const std::string& volume : volumes)
    for (const char* options : {"--codec lz4", "--codec zstd", "--chunk 16", "--zarr 3"}) {
      SCOPED_TRACE(volume + " " + options);
      ASSERT_EQ(program.run("pack " + volume + " -o v.zarr --force " + options).status, 0);
      const std::string view = " --size 200 --threshold 40 --azimuth 30 --elevation 20 --shade -o ";
      ASSERT_EQ(program.run("render " + volume + view + "a.png").status, 0);
      ASSERT_EQ(program.run("render v.zarr" + view + "b.png").status, 0);
      EXPECT_TRUE(readFile(program.folder / "a.png") == readFile(program.folder / "b.png"));
    }
}

// Chunks are filled up to their side, a GB of them for each time step.
TEST(PackCommand, chunksAreNotMuchLargerThanTheVolume) {
  const Program program;
  const auto sideOf = [&](const std::string& command) {
    EXPECT_EQ(program.run(command).status, 0);
    return nlohmann::json::parse(readFile(program.folder / "v.zarr/0/.zarray"))["chunks"].back();
  };
  EXPECT_EQ(sideOf("pack synth:mixing,dims=20x20x20,steps=2 -o v.zarr --chunk 1024"), 64);
  EXPECT_EQ(sideOf("pack synth:noise,dims=20x150x20 -o v.zarr --chunk 1024 --force"), 256);
  EXPECT_EQ(sideOf("pack synth:noise,dims=20x20x20 -o v.zarr --chunk 16 --force"), 16);
}

// Time steps, slices and channels in another order than the store's, and read back by others.
TEST(PackCommand, allChannelsArePackedAndNamed) {
  if (runCommand("/usr/bin/python3 -c 'import numpy, tifffile, zarr'").status != 0)
    GTEST_SKIP() << "python3 with numpy, tifffile and zarr is missing";
  const Program program;
  for (const int steps : {1, 2}) {
    SCOPED_TRACE(steps);
    const std::string write = fmt::format(
        "import numpy as np, tifffile\n"
        "v = np.random.default_rng(1).integers(0, 60000, ({}, 5, 3, 20, 30)).astype(\"u2\")\n"
        "np.save(\"v.npy\", v)\n"
        "tifffile.imwrite(\"v.ome.tif\", v, ome=True, photometric=\"minisblack\","
        " metadata=dict(axes=\"TZCYX\", PhysicalSizeX=0.5, PhysicalSizeXUnit=\"um\","
        " PhysicalSizeY=0.5, PhysicalSizeYUnit=\"um\", PhysicalSizeZ=2, PhysicalSizeZUnit=\"um\","
        " Channel=dict(Name=[\"DAPI\", \"GFP 488\", \"red\"])))\n",
        steps);
    writeFile(program.folder / "write.py", write);
    ASSERT_EQ(shell(program, "/usr/bin/python3 write.py").status, 0);
    const auto report = program.json("pack v.ome.tif -o v.zarr --chunk 16 --verify --force");
    EXPECT_EQ(report["channels"], 3);
    EXPECT_EQ(report["voxel_bytes"], steps * 5 * 3 * 20 * 30 * 2);
    writeFile(program.folder / "read.py",
              "import json, numpy as np, zarr\n"
              "v = np.load(\"v.npy\").transpose(0, 2, 1, 3, 4)\n"
              "g = zarr.open(\"v.zarr\", \"r\")\n"
              "s = g[\"0\"][:]\n"
              "assert np.array_equal(s.reshape(v.shape), v), s.shape\n"
              "m = g.attrs[\"multiscales\"][0]\n"
              "assert [a[\"name\"] for a in m[\"axes\"]] == list(\"tczyx\")[5 - s.ndim:]\n"
              "assert m[\"axes\"][-4][\"type\"] == \"channel\"\n"
              "t = m[\"datasets\"][0][\"coordinateTransformations\"]\n"
              "assert t[0][\"scale\"] == [1, 1, 2, 0.5, 0.5][5 - s.ndim:], t\n"
              "print([c[\"label\"] for c in g.attrs[\"omero\"][\"channels\"]])\n");
    const CommandResult read = shell(program, "/usr/bin/python3 read.py");
    EXPECT_EQ(read.output, "['DAPI', 'GFP 488', 'red']\n");
    // The channels in turn, by number and by name, of the store and of the file.
    for (const char* volume : {"v.zarr", "v.ome.tif"})
      for (const char* state : {"", "read"})
        for (const auto& [number, channel] : {std::pair{0, "DAPI"}, {1, "'GFP 488'"}, {2, "red"}}) {
          const auto by_number = program.json(fmt::format("info {} --channel {}", volume, number));
          const auto by_name = program.json(fmt::format("info {} --channel {}", volume, channel));
          EXPECT_EQ(by_name["channel"], number);
          EXPECT_EQ(by_name["value_range"], by_number["value_range"]);
          EXPECT_EQ(by_name["index"]["state"], "read");
          // Packing has made the store's indices, the first turn the file's.
          if (*state != 0 || volume == std::string("v.zarr")) {
            EXPECT_EQ(by_number["index"]["state"], "read") << volume << number;
          }
        }
    // A single channel makes a volume without an axis for channels.
    ASSERT_EQ(program.run("pack v.ome.tif -o one.zarr --channel red --chunk 16 --force").status, 0);
    EXPECT_EQ(program.json("info one.zarr")["channels"], 1);
    EXPECT_EQ(program.json("info one.zarr")["value_range"],
              program.json("info v.zarr --channel 2")["value_range"]);
    const CommandResult unknown = program.run("info v.zarr --channel blue");
    EXPECT_EQ(unknown.status, 1);
    EXPECT_EQ(
        unknown.output,
        "sluice: v.zarr: --channel blue: the volume has no channel of that name, expected one "
        "of 0 (DAPI), 1 (GFP 488), 2 (red)\n");
  }
}

TEST(PackCommand, wrongUsageIsOneLine) {
  const Program program;
  for (const char* line :
       {"pack synth:cube", "pack synth:cube -o a.zarr --codec lzma",
        "pack synth:cube -o a.zarr --level 0", "pack synth:cube -o a.zarr --chunk 3",
        "pack synth:cube -o a.zarr --time 1", "pack --check a.zarr -o b.zarr"}) {
    const CommandResult result = program.run(line);
    EXPECT_EQ(result.status, 2) << line << ": " << result.output;
    EXPECT_TRUE(isOneLine(result.output)) << result.output;
  }
  for (const char* line :
       {"pack synth:cube,dims=9x9x9 -o a.raw", "pack none.nrrd -o a.zarr", "pack --check none.zarr",
        "pack synth:cube,dims=9x9x9 -o a.zarr --memory 1K",
        "pack synth:cube,dims=9x9x9 -o no/such/a.zarr/.. "}) {
    const CommandResult result = program.run(line);
    EXPECT_EQ(result.status, 1) << line << ": " << result.output;
    EXPECT_TRUE(isOneLine(result.output)) << result.output;
  }
  EXPECT_EQ(program.run("pack --check none.zarr").output,
            "sluice: none.zarr: expected a store that sluice pack has written, found no such file "
            "or folder\n");
  // It is there, and leads nowhere.
  ASSERT_EQ(program.inFolder("mkdir c.zarr && ln -s .zarray c.zarr/.zarray").status, 0);
  for (const char* line : {"pack --check c.zarr", "info c.zarr", "render c.zarr -o a.png"}) {
    const CommandResult result = program.run(line);
    EXPECT_EQ(result.status, 1);
    EXPECT_EQ(result.output,
              "sluice: c.zarr/.zarray: cannot be opened: Too many levels of symbolic links\n");
  }
  EXPECT_FALSE(program.exists("a.zarr"));
}

TEST(PackCommand, writesUnitsAsOmeZarrNamesThem) {
  const Program program;
  const auto packed = [&](const std::string& unit) {
    return program.run("pack synth:cube,dims=9x9x9 -o u.zarr --force --unit " + unit).output;
  };
  for (const auto& [said, written] : std::map<std::string, std::string>{
           {"um", "micrometer"}, {"MM", "millimeter"}, {"parsec", "parsec"}}) {
    EXPECT_THAT(packed(said), Not(HasSubstr("warning"))) << said;
    std::ifstream file(program.folder / "u.zarr/.zattrs");
    const auto axes = nlohmann::json::parse(file)["multiscales"][0]["axes"];
    EXPECT_EQ(axes.back()["unit"], written);
  }
  EXPECT_THAT(packed("furlong"),
              HasSubstr("sluice: warning: u.zarr: its spacing has the unit \"furlong\", which is "
                        "none of OME-Zarr's"));
}

// Names that a store cannot be renamed to are refused before the volume is packed.
TEST(PackCommand, aNameThatCannotBeMadeIsRefusedBeforePacking) {
  const Program program;
  std::filesystem::create_symlink("nowhere", program.folder / "to_nothing.zarr");
  std::filesystem::create_symlink("circle.zarr", program.folder / "circle.zarr");
  const std::string long_name = std::string(251, 'n') + ".zarr";
  for (const std::string& name :
       {std::string("to_nothing.zarr"), std::string("circle.zarr"), long_name}) {
    const CommandResult result = program.run("pack synth:cube,dims=9x9x9 -o " + name);
    EXPECT_EQ(result.status, 1) << result.output;
    EXPECT_TRUE(isOneLine(result.output)) << result.output;
    EXPECT_TRUE(result.output.starts_with("sluice: " + name + ": ")) << result.output;
  }
  for (const auto& entry : std::filesystem::directory_iterator(program.folder.path()))
    EXPECT_FALSE(entry.path().filename().string().ends_with(".partial")) << entry.path();
}

// Killed several times at several moments, then left alone.
// The sum of their voxels wrapped to none.
TEST(PackCommand, aSeriesOfMoreVoxelsThanAreCountedIsRefused) {
  const Program program;
  ASSERT_EQ(program.inFolder("mkdir v_0.zarr").status, 0);
  writeFile(program.folder / "v_0.zarr" / ".zarray",
            R"({"zarr_format": 2, "shape": [1048576, 1048576, 524288], "chunks": [256, 256, 256],
                "dtype": "|u1", "compressor": null, "fill_value": 0, "order": "C",
                "filters": null})");
  std::string steps;
  for (int i = 0; i < 32; ++i) {
    const std::string name = fmt::format("v_{}.zarr", i);
    if (i > 0) std::filesystem::create_symlink("v_0.zarr", program.folder / name);
    steps += " " + name;
  }
  const CommandResult refused = program.run("pack -q -o all.zarr" + steps);
  EXPECT_EQ(refused.status, 1);
  EXPECT_EQ(refused.output,
            "sluice: v_0.zarr: expected at most 2^59 voxels in all, found 524288 x 1048576 x "
            "1048576 in 32 time steps and 1 channel; pack a part of them\n");
}

TEST(PackCommand, theIndexOfAReplacedStoreGoesWithoutAWord) {
  const Program program;
  ASSERT_EQ(program.run("pack synth:shells,dims=24x20x16 -q -o v.zarr").status, 0);
  const CommandResult replaced =
      program.run("pack synth:noise,dims=24x20x16 -o v.zarr --force --levels 1 --chunk 4");
  EXPECT_EQ(replaced.status, 0);
  EXPECT_THAT(replaced.output, HasSubstr("index built"));
  EXPECT_THAT(replaced.output, testing::Not(HasSubstr("not used")));
  // The same if the store was removed by hand.
  fs::remove_all(program.folder / "v.zarr");
  const CommandResult again = program.run("pack synth:noise,dims=24x20x16,seed=2 -o v.zarr");
  EXPECT_EQ(again.status, 0);
  EXPECT_THAT(again.output, HasSubstr("index built"));
  EXPECT_THAT(again.output, testing::Not(HasSubstr("not used")));
}

// A billion chunks of which one shard's are there took 8 GB for their numbers.
TEST(PackCommand, aCheckTakesNoMemoryForChunksThatAreNotThere) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "a sanitizer's own addresses";
#endif
  const Program program;
  ASSERT_EQ(program.run("pack synth:noise,dims=64x64x64 -q -o v.zarr --zarr 3 --chunk 16").status,
            0);
  const std::filesystem::path text = program.folder / "v.zarr" / "0" / "zarr.json";
  auto array = nlohmann::json::parse(readFile(text));
  array["shape"] = {int64_t{1} << 34, 64, 64};
  writeFile(text, array.dump());
  const CommandResult checked =
      program.inFolder("ulimit -v 2000000 && " SLUICE_PROGRAM " pack --check v.zarr --threads 2");
  EXPECT_EQ(checked.status, 0) << checked.output;
  EXPECT_THAT(checked.output, HasSubstr("v.zarr: 64 chunks"));
}

TEST(PackCommand, killedOrInterruptedItGoesOnToTheSameBytes) {
  const Program program;
  const std::string line =
      std::string("$SLUICE pack synth:noise,dims=200x200x200,type=u16") + kOptions + " --json -o ";
  ASSERT_EQ(shell(program, line + "whole.zarr").status, 0);
  const auto expected = filesOf(program.folder / "whole.zarr");
  for (const char* signal : {"INT", "TERM", "KILL"}) {
    SCOPED_TRACE(signal);
    int stopped = 0;
    for (const int journal_bytes :
         {960, 3200, 5600}) {  // bytes of the journal for 343 chunks, 32 each
      const CommandResult result = shell(
          // sh has its background jobs ignore SIGINT.
          program, "env --default-signal=INT " + line +
                       "v.zarr & pid=$!; while kill -0 $pid 2>/dev/null && " +
                       fmt::format("[ $(stat -c %s v.zarr.partial/journal 2>/dev/null || echo 0) "
                                   "-lt {} ]; do sleep 0.01; done; kill -{} $pid; wait $pid",
                                   journal_bytes, signal));
      if (result.status == 0) break;  // it was faster
      ++stopped;
      EXPECT_FALSE(program.exists("v.zarr"));
      EXPECT_EQ(result.status, signal == std::string("KILL")   ? 137
                               : signal == std::string("TERM") ? 143
                                                               : 130)
          << result.output;
      if (signal != std::string("KILL")) {
        EXPECT_TRUE(isOneLine(result.output)) << result.output;
        EXPECT_NE(result.output.find("run the same command again"), std::string::npos);
      }
    }
    EXPECT_GT(stopped, 0);
    if (!program.exists("v.zarr")) {
      const CommandResult last = shell(program, line + "v.zarr");
      ASSERT_EQ(last.status, 0) << last.output;
      // A warning may come first: the last signal's store had an index.
      const size_t begin = last.output.find('{');
      ASSERT_NE(begin, std::string::npos) << last.output;
      const auto report = nlohmann::json::parse(last.output.substr(begin));
      EXPECT_GT(report["chunks"]["kept"].get<int64_t>(), 0);
    }
    EXPECT_TRUE(filesOf(program.folder / "v.zarr") == expected);
    EXPECT_FALSE(program.exists("v.zarr.partial"));
    fs::remove_all(program.folder / "v.zarr");
  }
}

TEST(PackCommand, aFullDiskIsOneLineAndMoreRoomGoesOn) {
  const Program program;
  const std::string disk = (program.folder / "disk").string();
  if (shell(program, "mkdir disk && mount -t tmpfs -o size=4m tmpfs disk").status != 0)
    GTEST_SKIP() << "root, who may mount a tmpfs, is missing";
  const std::string line =
      "$SLUICE pack synth:noise,dims=128x128x512,share=1 --chunk 32 -o disk/v.zarr";
  const CommandResult full = shell(program, line);
  const CommandResult again = shell(program, line);
  const bool named = program.exists("disk/v.zarr");
  shell(program, "mount -o remount,size=64m disk");
  const CommandResult rest = shell(program, line);
  const CommandResult sound = shell(program, "$SLUICE pack --check disk/v.zarr");
  shell(program, "umount disk");
  for (const CommandResult& result : {full, again}) {
    EXPECT_EQ(result.status, 1);
    EXPECT_TRUE(isOneLine(result.output)) << result.output;
    EXPECT_NE(result.output.find("No space left on device"), std::string::npos) << result.output;
  }
  EXPECT_FALSE(named);
  EXPECT_EQ(rest.status, 0) << rest.output;
  EXPECT_NE(rest.output.find("done before an interruption"), std::string::npos) << rest.output;
  EXPECT_EQ(sound.status, 0) << sound.output;
}

TEST(PackCommand, aFolderThatCannotBeWrittenIsOneLine) {
  const Program program;
  if (shell(program, "mkdir disk && mount -t tmpfs -o ro tmpfs disk").status != 0)
    GTEST_SKIP() << "root, who may mount a tmpfs, is missing";
  const CommandResult result = shell(program, "$SLUICE pack synth:cube,dims=9x9x9 -o disk/v.zarr");
  shell(program, "umount disk");
  EXPECT_EQ(result.status, 1);
  EXPECT_TRUE(isOneLine(result.output)) << result.output;
  EXPECT_NE(result.output.find("Read-only file system"), std::string::npos) << result.output;
}

TEST(PackCommand, twoAtOnceAreOneStoreAndOneLine) {
  const Program program;
  const std::string line = std::string("$SLUICE pack ") + kSlow + kOptions + " -o v.zarr";
  const CommandResult result = shell(
      program,
      line + " >first.txt 2>&1 & while [ ! -s v.zarr.partial/journal ]; do sleep 0.01; done; " +
          line + "; echo $?; wait");
  EXPECT_NE(result.output.find("another sluice is packing"), std::string::npos) << result.output;
  EXPECT_TRUE(result.output.ends_with("\n1\n")) << result.output;
  EXPECT_EQ(program.run("pack --check v.zarr").status, 0) << readFile(program.folder / "first.txt");
}

}  // namespace
}  // namespace sluice
