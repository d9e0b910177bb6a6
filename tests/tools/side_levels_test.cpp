// Levels that sluice makes for files that have none, and keeps beside the index.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>
#include <map>
#include <numeric>
#include <span>

#include "io/pictures/png_file.h"
#include "io/zarr/reading/zarr_codec.h"
#include "tests/tools/program.h"

namespace sluice::side_levels_test {
namespace {

namespace fs = std::filesystem;
using testing::Field;
using testing::HasSubstr;
using testing::Not;

constexpr const char* kVolume = "v_131x117x95_uint8.raw";
constexpr const char* kLook = "--threshold 60 --no-shade --view plain --size 64 --pixel-error 1";
constexpr const char* kMade = " once and keeps ";

class SideLevelsCommand : public testing::Test {
 protected:
  void SetUp() override {
    ASSERT_EQ(program_.run(std::string("synth shells --dims 131,117,95 -o ") + kVolume).status, 0);
  }
  CommandResult render(const std::string& more = "", const std::string& levels = "always") const {
    return program_.run(line(more, levels));
  }
  static std::string line(const std::string& more = "", const std::string& levels = "always") {
    return std::string("render ") + kVolume + " " + kLook + " -o x.png --force --levels " + levels +
           " " + more;
  }
  std::vector<uint8_t> picture() const {
    const auto rgba = readPng(program_.folder / "x.png").rgba;
    return {rgba.begin(), rgba.end()};
  }
  // The one group of levels, finished or not.
  fs::path group(const std::string& ending = ".zarr") const {
    for (const auto& entry : fs::recursive_directory_iterator(program_.folder / "cache"))
      if (entry.path().filename().string().starts_with("levels-") &&
          entry.path().string().ends_with(ending))
        return entry.path();
    return {};
  }
  // The chunk files below a folder, by name.
  static std::map<std::string, std::string> chunksOf(const fs::path& folder) {
    std::map<std::string, std::string> chunks;
    for (const auto& entry : fs::recursive_directory_iterator(folder))
      if (entry.is_regular_file() && entry.path().filename().string()[0] != '.')
        chunks[fs::relative(entry.path(), folder).string()] = readFile(entry.path());
    return chunks;
  }
  // The voxels of these files: packed stores are compressed in another way.
  static std::map<std::string, std::string> voxelsOf(const fs::path& folder) {
    std::map<std::string, std::string> chunks = chunksOf(folder);
    for (auto& [name, chunk] : chunks) {
      constexpr size_t kBytesAt = 4;  // of the decoded chunk, in Blosc's header
      uint32_t bytes = 0;
      std::memcpy(&bytes, chunk.data() + kBytesAt, sizeof bytes);
      std::string voxels(bytes, '\0');
      decodeChunk(ZarrCodec::kBlosc, std::as_bytes(std::span(chunk)),
                  std::as_writable_bytes(std::span(voxels)), name);
      chunk = std::move(voxels);
    }
    return chunks;
  }
  // A chunk file of the first level.
  fs::path someChunk() const { return group() / "0" / chunksOf(group() / "0").begin()->first; }

  const Program program_;
};

TEST_F(SideLevelsCommand, areThoseThatPackMakes) {
  for (const std::string options :
       {"", "--spacing 1,1,3", "--type i16 --dims 60,100,121", "--type f32 --dims 65,90,62"}) {
    SCOPED_TRACE(options);
    fs::remove_all(program_.folder / "cache");
    const std::string raw = (options.find("dims") == std::string::npos ? kVolume : "other.raw");
    const size_t bytes =
        options.find("i16") != std::string::npos ? 60 * 100 * 121 * 2 : 65 * 90 * 62 * 4;
    if (raw == "other.raw") {
      // Numbers whose floats are all finite.
      std::string data(bytes, '\0');
      for (size_t i = 0; i < bytes; ++i) data[i] = static_cast<char>(i * 2654435761U >> 25);
      writeFile(program_.folder / raw, data);
    }
    ASSERT_EQ(
        program_.run("pack " + raw + " " + options + " -o p.zarr --force --levels auto").status, 0);
    fs::remove_all(program_.folder / "cache");
    const CommandResult made = program_.run("info " + raw + " " + options + " --levels");
    EXPECT_THAT(made.output, Not(HasSubstr("level 1"))) << "the volume is small";
    ASSERT_EQ(program_
                  .run("render " + raw + " " + options +
                       " -o x.png --force --size 32 --level 1 "
                       "--levels always")
                  .status,
              0);
    int levels = 0;
    for (; fs::exists(program_.folder / "p.zarr" / std::to_string(levels + 1)); ++levels) {
      const std::string packed = std::to_string(levels + 1), ours = std::to_string(levels);
      EXPECT_TRUE(voxelsOf(group() / ours) == voxelsOf(program_.folder / "p.zarr" / packed))
          << ours;
      EXPECT_TRUE(voxelsOf(group() / "spread" / ours) ==
                  voxelsOf(program_.folder / "p.zarr/spread" / packed))
          << ours;
    }
    EXPECT_GT(levels, 0);
    EXPECT_FALSE(fs::exists(group() / std::to_string(levels)));
  }
}

TEST_F(SideLevelsCommand, areMadeOnceWithTheIndexOrAfterItAndSayTheirSize) {
  const CommandResult first = render();
  EXPECT_THAT(first.output, HasSubstr("makes 2 coarser levels once"));
  EXPECT_THAT(first.output, HasSubstr("at most 411.5 KiB"));
  EXPECT_THAT(first.output, HasSubstr("at level 1"));
  const auto shown = picture();
  EXPECT_THAT(render().output, Not(HasSubstr(kMade)));
  EXPECT_EQ(picture(), shown);
  // The index is there already.
  fs::remove_all(group());
  EXPECT_THAT(render().output, HasSubstr(kMade));
  EXPECT_EQ(picture(), shown);
}

TEST_F(SideLevelsCommand, areNotMadeOfSmallVolumesOrIfNobodyWantsThem) {
  for (const char* const levels : {"auto", "none"}) {
    EXPECT_THAT(render("", levels).output, Not(HasSubstr(kMade)));
    EXPECT_TRUE(group().empty());
  }
  const auto finest = picture();
  render();
  EXPECT_NE(picture(), finest);
  // Levels that are there are not used either.
  EXPECT_THAT(render("", "none").output, Not(HasSubstr("at level 1")));
  EXPECT_EQ(picture(), finest);
}

TEST_F(SideLevelsCommand, thatAreThereAreUsedByPicturesThatAskForNothing) {
  const std::string plain = std::string("render ") + kVolume +
                            " --threshold 60 --no-shade --view plain --size 64 -o x.png --force ";
  EXPECT_THAT(program_.run(plain).output, Not(HasSubstr("at level")));
  EXPECT_TRUE(group().empty());
  const auto finest = picture();
  render();
  const auto coarse = picture();
  const CommandResult used = program_.run(plain);
  EXPECT_THAT(used.output, HasSubstr("at level 1"));
  EXPECT_THAT(used.output, Not(HasSubstr(kMade)));
  EXPECT_EQ(picture(), coarse);
  for (const char* const option : {"--level 0", "--levels none"}) {
    EXPECT_THAT(program_.run(plain + option).output, Not(HasSubstr("at level 1")));
    EXPECT_EQ(picture(), finest) << option;
  }
}

// Levels take two more layers around a block.
TEST_F(SideLevelsCommand, thatAreThereKeepNoSmallBlocksFromBeingDrawn) {
  const auto blocksOfFour = [&](const std::string& more) {
    return program_.run(std::string("render ") + kVolume +
                        " --threshold 60 --no-shade --size 64 --block 4 --force " + more);
  };
  ASSERT_EQ(blocksOfFour("-o a.png").status, 0);
  ASSERT_EQ(render().status, 0);
  const CommandResult after = blocksOfFour("-o b.png");
  ASSERT_EQ(after.status, 0) << after.output;
  EXPECT_EQ(readFile(program_.folder / "a.png"), readFile(program_.folder / "b.png"));
  for (const char* asking : {"--pixel-error 1", "--level 1", "--levels always"})
    EXPECT_THAT(blocksOfFour(std::string(asking) + " -o c.png").output,
                HasSubstr("blocks of 4 voxels a side have no room for the border"));
  ASSERT_EQ(program_.run(std::string("pack ") + kVolume + " -o p.zarr --levels auto").status, 0);
  EXPECT_THAT(program_.run("render p.zarr --threshold 60 --no-shade --size 64 --block 4 -o d.png"),
              Field(&CommandResult::output, HasSubstr("p.zarr: drawn from level 0 alone")));
}

TEST_F(SideLevelsCommand, areMadeByDefaultOfLargeFilesOfNarrowVoxels) {
  const auto fileOf = [&](const std::string& name, uintmax_t bytes) {
    writeFile(program_.folder / name, "");
    fs::resize_file(program_.folder / name, bytes);  // of zeros, which take no room
    return name;
  };
  constexpr uintmax_t kVoxels = uintmax_t{513} * 512 * 512;
  const std::string narrow = fileOf("n_513x512x512_uint8.raw", kVoxels);
  for (const char* const option : {" --level 0", " --levels none"}) {
    EXPECT_THAT(program_.run("plan " + narrow + option).output, Not(HasSubstr(kMade)));
    EXPECT_TRUE(group().empty()) << option;
  }
  EXPECT_THAT(program_.run("info " + narrow).output, HasSubstr(kMade));
  EXPECT_FALSE(group().empty());
  EXPECT_THAT(program_.run("plan " + narrow).output, Not(HasSubstr(kMade)));
  // Pictures of extremes have levels of their own.
  for (const char* const mode : {"mip", "minip"}) {
    const std::string plan = "plan " + narrow + " --mode " + mode;
    EXPECT_THAT(program_.run(plan + " --level 0").output, Not(HasSubstr(kMade))) << mode;
    EXPECT_THAT(program_.run(plan).output, HasSubstr(kMade)) << mode;
    EXPECT_THAT(program_.run(plan).output, Not(HasSubstr(kMade))) << mode;
  }
  // Levels of wide voxels take longer.
  fs::remove_all(program_.folder / "cache");
  const std::string wide = fileOf("w_513x512x512_float32.raw", 4 * kVoxels);
  EXPECT_THAT(program_.run("info " + wide).output, Not(HasSubstr(kMade)));
  EXPECT_TRUE(group().empty());
}

TEST_F(SideLevelsCommand, areMadeAgainWhenTheFileHasChanged) {
  ASSERT_EQ(render().status, 0);
  const auto old = chunksOf(group());
  std::string voxels = readFile(program_.folder / kVolume);
  std::reverse(voxels.begin(), voxels.end());
  voxels[0] = static_cast<char>(200);
  writeFile(program_.folder / kVolume, voxels);
  fs::last_write_time(program_.folder / kVolume,
                      fs::last_write_time(program_.folder / kVolume) + std::chrono::seconds(1));
  const CommandResult again = render();
  EXPECT_EQ(again.status, 0);
  EXPECT_THAT(again.output, HasSubstr("of another state of the volume"));
  EXPECT_THAT(again.output, HasSubstr(kMade));
  EXPECT_NE(chunksOf(group()), old);
  EXPECT_THAT(render().output, Not(HasSubstr("warning")));
}

TEST_F(SideLevelsCommand, goOnAfterAKill) {
  const std::string big =
      "render synth:noise,dims=200x200x520,share=1 --threshold 60 -o x.png "
      "--force --size 32 --level 1 --levels always";
  ASSERT_EQ(program_.run(big).status, 0);
  const auto whole = chunksOf(group());
  int stopped = 0;
  for (const char* const signal : {"KILL", "TERM", "KILL"}) {
    fs::remove_all(program_.folder / "cache");
    stopped +=
        program_.signalled(big, signal, "[ -s cache/sluice/index/*/levels-*.partial/journal ]")
            .status != 0;
    EXPECT_TRUE(!group().empty() || !group(".partial").empty());
    const CommandResult rest = program_.run(big);
    EXPECT_EQ(rest.status, 0) << rest.output;
    EXPECT_EQ(chunksOf(group()), whole);
    EXPECT_TRUE(group(".partial").empty());
  }
  EXPECT_GT(stopped, 0);
}

TEST_F(SideLevelsCommand, thatAreDamagedAreMadeAgainAndThePictureIsTheSame) {
  ASSERT_EQ(render().status, 0);
  const auto shown = picture();
  const auto expectMended = [&](const char* word, bool at_opening) {
    const CommandResult result = render();
    EXPECT_EQ(result.status, 0);
    EXPECT_THAT(result.output, HasSubstr(word));
    EXPECT_EQ(picture(), shown) << word;
    if (!at_opening) {
      EXPECT_THAT(render().output, HasSubstr(kMade)) << word;
    }
    EXPECT_THAT(render().output, Not(testing::AnyOf(HasSubstr(kMade), HasSubstr("warning"))));
  };
  // Damage that is found when the levels are opened.
  fs::remove_all(group() / "1");
  expectMended("the levels are made again", true);
  fs::remove_all(group() / "spread");
  expectMended("the levels are made again", true);
  writeFile(group() / ".zattrs", "{}");
  expectMended("the levels are made again", true);
  fs::remove_all(group());
  expectMended("the levels are made again", true);
  fs::remove(group() / ".zgroup");  // it looks like no store any more
  writeFile(group() / ".zattrs", "{}");
  expectMended("the levels are made again", true);
  const fs::path folder = group();
  fs::remove_all(folder);
  writeFile(folder, "a file in its place");
  expectMended("the levels are made again", true);
  // Damage that is found when they are read.
  std::string chunk = readFile(someChunk());
  chunk[chunk.size() / 2] = static_cast<char>(chunk[chunk.size() / 2] ^ 1);
  writeFile(someChunk(), chunk);
  expectMended("what is damaged is made of level 0", false);
  fs::remove(someChunk());
  expectMended("what is damaged is made of level 0", false);
}

TEST_F(SideLevelsCommand, thatCannotBeKeptAreOneLineAndThePictureIsLevelZeros) {
  ASSERT_EQ(render("", "none").status, 0);
  const auto finest = picture();
  const auto expectFinest = [&](const CommandResult& result, const char* word) {
    EXPECT_EQ(result.status, 0) << result.output;
    EXPECT_THAT(result.output, HasSubstr(word));
    EXPECT_EQ(picture(), finest);
  };
  // Chunks are larger than that, and the index that is there already is not written.
  const std::string limited =
      "cd " + shellQuoted(program_.folder.path().string()) +
      " && trap '' XFSZ && ulimit -f 24 && XDG_CACHE_HOME=\"$PWD/cache\" " SLUICE_PROGRAM " ";
  expectFinest(runCommand(limited + line()), "its coarser levels cannot be kept, level 0 is drawn");
  EXPECT_TRUE(group().empty());
  const std::string here = "cd " + shellQuoted(program_.folder.path().string()) + " && ";
  if (runCommand(here + "mkdir disk && mount -t tmpfs -o size=256k tmpfs disk").status != 0)
    GTEST_SKIP() << "root, who may mount a tmpfs, is missing";
  const CommandResult full = render("--index-dir disk");
  runCommand(here + "mount -o remount,size=4m,ro disk");
  const CommandResult read_only = render("--index-dir disk");
  runCommand(here + "umount disk");
  EXPECT_THAT(full.output, HasSubstr("since they may take 411.5 KiB"));
  expectFinest(read_only, "since they cannot be kept");
}

// A pyramid of another program, whose coarsest level is large, and which has no index.
class ShortPyramid : public testing::Test {
 protected:
  void SetUp() override {
    run("pack synth:shells,dims=320x300x280 -o v.zarr --chunk 32 --levels 1");
    fs::remove_all(program_.folder / "cache");
    fs::remove_all(program_.folder / "v.zarr/spread");
    std::string attributes = readFile(program_.folder / "v.zarr/.zattrs");
    attributes.replace(attributes.find("spreads"), 7, "nothing");
    writeFile(program_.folder / "v.zarr/.zattrs", attributes);
  }
  std::string run(const std::string& command) const {
    const CommandResult result = program_.run(command);
    EXPECT_EQ(result.status, 0) << result.output;
    return result.output;
  }
  static std::string line(const std::string& volume, const std::string& more) {
    return "render " + volume +
           " --threshold 60 --opacity 0.1 --range 0,255 --no-shade --view plain --fit volume "
           "--size 64 -o x.png --force " +
           more;
  }
  // Chunks have checksums: reading one of these is an error.
  void spoilLevelZero() const {
    for (const auto& file : fs::recursive_directory_iterator(program_.folder / "v.zarr/0"))
      if (file.is_regular_file() && file.path().filename().string().front() != '.')
        writeFile(file.path(), "spoilt");
  }
  const Program program_;
};

TEST_F(ShortPyramid, isContinuedOnceWithoutReadingLevelZero) {
  spoilLevelZero();
  const std::string asked = line("v.zarr", "--pixel-error 2");
  EXPECT_THAT(run(asked), HasSubstr(kMade));
  EXPECT_THAT(run(asked), Not(HasSubstr(kMade)));
  // Levels that are there are used, however large the coarsest one of the file is.
  const nlohmann::json report = program_.json(asked);
  const nlohmann::json& levels = report["cut"]["levels"];
  ASSERT_FALSE(levels.empty());
  EXPECT_GT(levels.back()["level"], 1);
  EXPECT_EQ(report["cut"]["spreads"], false);
}

TEST_F(ShortPyramid, itsFurtherLevelsAreThoseThatPackMakes) {
  run("pack synth:shells,dims=320x300x280 -o all.zarr --chunk 32 --levels 3");
  for (const char* level : {"2", "3"}) {
    run(line("v.zarr", std::string("--levels always --level ") + level));
    const auto continued = readPng(program_.folder / "x.png").rgba;
    fs::remove_all(program_.folder / "all.zarr/spread");
    std::string attributes = readFile(program_.folder / "all.zarr/.zattrs");
    if (const size_t at = attributes.find("spreads"); at != std::string::npos)
      attributes.replace(at, 7, "nothing");
    writeFile(program_.folder / "all.zarr/.zattrs", attributes);
    run(line("all.zarr", std::string("--level ") + level));
    const auto packed = readPng(program_.folder / "x.png").rgba;
    // Means of means are rounded twice.
    double sum = 0;
    for (size_t i = 0; i < packed.size(); ++i) sum += std::abs(packed[i] - continued[i]);
    EXPECT_LT(sum / static_cast<double>(packed.size()), 0.5) << level;
    EXPECT_GT(std::accumulate(packed.begin(), packed.end(), 0.0), 0) << "something shows";
  }
}

TEST_F(ShortPyramid, isNotContinuedIfItsCoarsestLevelIsSmallOrNobodyAsks) {
  run("pack synth:shells,dims=240x240x240 -o small.zarr --chunk 32 --levels 1");
  EXPECT_THAT(run(line("small.zarr", "--pixel-error 2")), Not(HasSubstr(kMade)));
  EXPECT_THAT(run(line("v.zarr", "")), Not(HasSubstr(kMade)));
  EXPECT_THAT(run(line("v.zarr", "--levels always --level 0")), Not(HasSubstr(kMade)));
  EXPECT_THAT(run(line("v.zarr", "--levels none --pixel-error 2")), Not(HasSubstr(kMade)));
}

TEST_F(ShortPyramid, beginsWithASampleOfItsCoarsestLevelIfTimeIsShort) {
  spoilLevelZero();
  const nlohmann::json report = program_.json(line("v.zarr", "--time-limit 0"));
  EXPECT_EQ(report["volume"]["sample"], "125 of 125 chunks of level 1");
  EXPECT_EQ(report["volume"]["values_level"], 2);
  EXPECT_EQ(report["cut"]["final"], false);
}

}  // namespace
}  // namespace sluice::side_levels_test
