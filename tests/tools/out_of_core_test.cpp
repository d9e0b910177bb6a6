// Volumes larger than memory in a user's hands: budgets of any size, both kinds of store, an index
// that cannot be kept, a process in parallel to another or killed on its way.
#include <gtest/gtest.h>

#include <algorithm>
#include <charconv>
#include <fstream>
#include <set>

#include "io/pictures/png_file.h"
#include "tests/tools/program.h"

namespace sluice::out_of_core_test {
namespace {

namespace fs = std::filesystem;

constexpr const char* kView =
    " --threshold 60 --azimuth 30 --elevation 20 --size 96x80 --gl osmesa";

// v.raw and v.zarr of the same voxels; most blocks are visible.
void makeStores(const Program& program) {
  ASSERT_EQ(
      program.run("synth noise -o v_200x150x120_uint8.raw --dims 200,150,120 --share 0.3").status,
      0);
  ASSERT_EQ(program.run("pack v_200x150x120_uint8.raw -o v.zarr --chunk 40").status, 0);
}

int largestDifference(const Rgba8Picture& a, const Rgba8Picture& b) {
  EXPECT_EQ(a.rgba.size(), b.rgba.size());
  int most = 0;
  for (size_t i = 0; i < std::min(a.rgba.size(), b.rgba.size()); ++i)
    most = std::max(most, std::abs(a.rgba[i] - b.rgba[i]));
  return most;
}

// The least memory named in the message for a budget that is too small.
std::string leastMemoryIn(const std::string& line) {
  const std::string words = "give --memory ";
  const size_t at = line.find(words);
  if (at == std::string::npos) return {};
  const size_t end = line.find(' ', at + words.size());
  return line.substr(at + words.size(), end - at - words.size());
}

TEST(OutOfCore, anyBudgetGivesTheSamePictureFromAnyStore) {
  const Program program;
  makeStores(program);
  int turn = 0;  // the two stores take turns, so that each meets every block size and every budget
  for (const char* block : {"16", "32", "64"}) {
    const std::string view = std::string(kView) + " --block " + block;
    ASSERT_EQ(program.run("render v_200x150x120_uint8.raw --memory 1G -o all.png" + view).status,
              0);
    const Rgba8Picture expected = readPng(program.folder / "all.png");
    EXPECT_GT(
        std::count_if(expected.rgba.begin(), expected.rgba.end(), [](int v) { return v > 20; }),
        1000);
    for (const char* memory : {"16M", "24M", "64M", "256M"}) {
      const char* volume = turn++ % 2 == 0 ? "v_200x150x120_uint8.raw" : "v.zarr";
      SCOPED_TRACE(std::string(volume) + ", blocks of " + block + ", --memory " + memory);
      const auto report = program.json("render " + std::string(volume) + " --memory " + memory +
                                       " -o some.png" + view);
      EXPECT_LE(largestDifference(readPng(program.folder / "some.png"), expected), 1);
      const auto& levels = report["levels"];
      EXPECT_LE(levels["volume_buffer"]["peak_bytes"].get<uint64_t>() +
                    levels["texture_buffer"]["peak_bytes"].get<uint64_t>() +
                    levels["texture_cache"]["peak_bytes"].get<uint64_t>(),
                report["memory_bytes"].get<uint64_t>());
    }
    ++turn;
  }
}

TEST(OutOfCore, theSameNumberOfPagesGivesTheVerySamePicture) {
  const Program program;
  makeStores(program);
  const std::string view = std::string(kView) + " --pages 16";
  ASSERT_EQ(program.run("render v_200x150x120_uint8.raw --memory 1G -o all.png" + view).status, 0);
  const std::string expected = readFile(program.folder / "all.png");
  for (const char* volume : {"v_200x150x120_uint8.raw", "v.zarr"}) {
    ASSERT_EQ(
        program.run(std::string("render ") + volume + " --memory 16M -o some.png" + view).status,
        0);
    EXPECT_TRUE(readFile(program.folder / "some.png") == expected) << volume;
  }
}

// Which blocks merge follows from the clusters, and so from the pages that fit into memory; a
// block's place in its chunk rounds its texture coordinates. Blocks that do not merge keep their
// places.
TEST(OutOfCore, unmergedBlocksGiveTheVerySamePictureUnderAnyBudget) {
  const Program program;
  makeStores(program);
  const std::string view = std::string(kView) + " --block 16 --algorithm trimmed";
  ASSERT_EQ(program.run("render v_200x150x120_uint8.raw --memory 1G -o all.png" + view).status, 0);
  const std::string expected = readFile(program.folder / "all.png");
  std::set<int64_t> pages;
  for (const char* memory : {"16M", "24M", "64M", "256M"}) {
    const auto report = program.json(std::string("render v_200x150x120_uint8.raw --memory ") +
                                     memory + " -o some.png" + view);
    EXPECT_TRUE(readFile(program.folder / "some.png") == expected) << memory;
    pages.insert(report["levels"]["texture_cache"]["pages"].get<int64_t>());
  }
  EXPECT_GT(pages.size(), 1U) << "clusters of several sizes";
}

TEST(OutOfCore, aSlabGivesTheVerySamePictureUnderAnyBudget) {
  const Program program;
  ASSERT_EQ(
      program.run("synth slab -o s_260x200x200_uint8.raw --dims 260,200,200 --share 0.3").status,
      0);
  const std::string line = std::string("render s_260x200x200_uint8.raw") + kView + " -o ";
  ASSERT_EQ(program.run(line + "all.png --memory 1G").status, 0);
  const std::string expected = readFile(program.folder / "all.png");
  for (const char* memory : {"24M", "32M", "64M", "256M"}) {
    ASSERT_EQ(program.run(line + "some.png --memory " + memory).status, 0) << memory;
    EXPECT_TRUE(readFile(program.folder / "some.png") == expected) << memory;
  }
}

TEST(OutOfCore, tooLittleMemoryIsOneLineWithTheLeastThatWorksAndThatWorks) {
  const Program program;
  makeStores(program);
  const std::string raw = "v_200x150x120_uint8.raw", zarr = "v.zarr";
  for (const auto& [volume, options] : {std::pair(raw, ""),
                                        {zarr, ""},
                                        {zarr, " --block 16"},
                                        {raw, " --shade"},
                                        {zarr, " --threads 1"},
                                        {raw, " --page 64x64x16"}}) {
    const std::string line = "render " + volume + " -o least.png" + kView + options + " --memory ";
    SCOPED_TRACE(line);
    const CommandResult refused = program.run(line + "1M");
    EXPECT_EQ(refused.status, 1);
    EXPECT_EQ(std::count(refused.output.begin(), refused.output.end(), '\n'), 1);
    const std::string least = leastMemoryIn(refused.output);
    ASSERT_FALSE(least.empty()) << refused.output;
    const CommandResult result = program.run(line + least);
    EXPECT_EQ(result.status, 0) << result.output;
    EXPECT_EQ(program.run(line + std::to_string(std::stoull(least) - 1)).status, 1);
  }
}

// Needs that grow with the budget: plans of cuts, what culling keeps, channels that differ.
TEST(OutOfCore, theLeastThatIsNamedWorksForEveryKindOfPicture) {
  const Program program;
  makeStores(program);
  const std::string raw = "v_200x150x120_uint8.raw";
  for (const std::string& command : {
           "render " + raw + " -o a.png --levels always --keep-thin --block 32",
           "render " + raw + " -o a.png --levels always --block 8 --threshold 200",
           "render " + raw + " -o a.png --shadows --shade",
           "render " + raw + " -o a.png --over v.zarr --block 16",
           "render " + raw + " -o a.png --over " + raw + " --combine blend --block 32",
           std::string("render synth:mixing,dims=96x96x96,steps=4 -o a_#.png --time 0:3 -t 100 "
                       "--opacity 1 --culling toc --block 16"),
           "surface " + raw + " -o a.ply --iso 90",
           std::string("surface v.zarr -o a.ply --iso 90"),
       }) {
    const std::string line = command + " --force -q" +
                             (command.starts_with("render") ? " --device cpu --size 128" : "") +
                             " --memory ";
    SCOPED_TRACE(line);
    ASSERT_EQ(program.run(line + "1G").status, 0);
    // Too little for a picture without culling names the least of that.
    const bool culls = command.find("--culling") != std::string::npos;
    const CommandResult refused = program.run(line + (culls ? "5000000" : "2500000"));
    EXPECT_EQ(refused.status, 1) << refused.output;
    const std::string least = leastMemoryIn(refused.output.substr(0, refused.output.size() - 1));
    ASSERT_FALSE(least.empty()) << refused.output;
    const CommandResult result = program.run(line + least);
    EXPECT_EQ(result.status, 0) << result.output;
    EXPECT_EQ(program.run(line + std::to_string(std::stoull(least) - 1)).status, 1);
  }
}

TEST(OutOfCore, twoProcessesOpenOneVolumeForTheFirstTimeAtOnce) {
  const Program program;
  ASSERT_EQ(
      program.run("synth noise -o v_200x200x200_uint8.raw --dims 200,200,200 --share 0.3").status,
      0);
  const std::string line = SLUICE_PROGRAM " render v_200x200x200_uint8.raw" + std::string(kView);
  const CommandResult both =
      runCommand("cd " + shellQuoted(program.folder.path().string()) + " && " + line +
                 " -o a.png & cd " + shellQuoted(program.folder.path().string()) + " && " + line +
                 " -o b.png; b=$?; wait $!; exit $((b + $?))");
  EXPECT_EQ(both.status, 0) << both.output;
  EXPECT_TRUE(readFile(program.folder / "a.png") == readFile(program.folder / "b.png"));
  EXPECT_EQ(program.json("info v_200x200x200_uint8.raw")["index"]["state"], "read");
}

TEST(OutOfCore, aProcessKilledWhileItIndexesLeavesNothingThatIsBelieved) {
  const Program program;
  ASSERT_EQ(
      program.run("synth noise -o v_256x256x256_uint8.raw --dims 256,256,256 --share 0.3").status,
      0);
  const std::string volume = "v_256x256x256_uint8.raw";
  ASSERT_EQ(program.run("render " + volume + " -o whole.png" + kView).status, 0);
  const std::string expected = readFile(program.folder / "whole.png");
  for (const char* seconds : {"0.03", "0.06", "0.09", "0.12", "0.15"}) {
    fs::remove_all(program.folder / "cache");
    runCommand("cd " + shellQuoted(program.folder.path().string()) + " && timeout -s KILL " +
               seconds + " " SLUICE_PROGRAM " info " + volume);
    ASSERT_EQ(program.run("render " + volume + " -o again.png" + kView).status, 0);
    EXPECT_TRUE(readFile(program.folder / "again.png") == expected) << seconds;
  }
}

TEST(OutOfCore, anIndexThatCannotBeKeptAnywhereIsSaidAndNoFailure) {
  const Program program;
  ASSERT_EQ(program.run("synth noise -o v_64x64x64_uint8.raw --dims 64,64,64 --share 0.3").status,
            0);
  const std::string volume = "v_64x64x64_uint8.raw";
  // Files in place of the folders, because root may write to any folder.
  std::ofstream(program.folder / "cache") << "no folder";
  fs::permissions(program.folder / volume, fs::perms::owner_read);
  const auto info = program.json("info " + volume);
  EXPECT_EQ(info["index"]["state"], "built, not kept");
  const CommandResult drawn = program.run("render " + volume + " -o a.png" + kView);
  EXPECT_EQ(drawn.status, 0);
  EXPECT_NE(drawn.output.find("no index is kept"), std::string::npos) << drawn.output;
}

// A limit on file sizes stands in for a full disk.
TEST(OutOfCore, aDiskThatIsFullWhileIndexingLeavesNoIndexAndThePictureIsDrawn) {
  const Program program;
  ASSERT_EQ(
      program.run("synth noise -o v_128x128x128_uint8.raw --dims 128,128,128 --share 0.3").status,
      0);
  const std::string volume = "v_128x128x128_uint8.raw";
  const std::string folder = shellQuoted(program.folder.path().string());
  const CommandResult info =
      runCommand("cd " + folder + " && trap '' XFSZ; ulimit -f 1; XDG_CACHE_HOME=\"$PWD/cache\" " +
                 SLUICE_PROGRAM " info " + volume + " --block 16");
  EXPECT_EQ(info.status, 0) << info.output;
  EXPECT_NE(info.output.find("not kept"), std::string::npos) << info.output;
  EXPECT_NE(info.output.find("File too large"), std::string::npos) << info.output;
  if (program.exists("cache")) {
    for (const auto& entry : fs::recursive_directory_iterator(program.folder / "cache"))
      EXPECT_FALSE(entry.is_regular_file()) << entry.path();
  }
  EXPECT_EQ(program.json("info " + volume + " --block 16")["index"]["state"], "built");
  EXPECT_EQ(program.json("info " + volume + " --block 16")["index"]["state"], "read");
}

// The file ends while it is read: cut short as soon as the program has it open, which is well
// before one thread is through it.
TEST(OutOfCore, aFileCutShortWhileIndexingIsOneLineAndLeavesNoIndex) {
  const Program program;
  ASSERT_EQ(
      program.run("synth noise -o v_700x700x700_uint8.raw --dims 700,700,700 --share 0.3").status,
      0);
  const std::string volume = "v_700x700x700_uint8.raw";
  const CommandResult info = runCommand(
      "cd " + shellQuoted(program.folder.path().string()) + "; " SLUICE_PROGRAM " info " + volume +
      " --quiet --threads 1 & until ls -l /proc/$!/fd | grep -q " + volume +
      " || ! kill -0 $!; do :; done 2>/dev/null; truncate -s 1000000 " + volume + "; wait $!");
  EXPECT_EQ(info.status, 1) << info.output;
  EXPECT_EQ(std::count(info.output.begin(), info.output.end(), '\n'), 1) << info.output;
  EXPECT_NE(info.output.find(volume), std::string::npos) << info.output;
  if (program.exists("cache")) {
    for (const auto& entry : fs::recursive_directory_iterator(program.folder / "cache"))
      EXPECT_FALSE(entry.is_regular_file()) << entry.path();
  }
}

// How much a limit leaves out depends on the machine; a source that stalls tests that a session
// leaves out late data.
TEST(OutOfCore, aLimitedPictureSaysWhetherItIsWholeAndTheNextOnesLackNoMore) {
  const Program program;
  makeStores(program);
  const auto report =
      program.json("render v.zarr -o f.png --frames 8 --time-limit 0" + std::string(kView));
  const auto& frames = report["frames"];
  ASSERT_EQ(frames.size(), 8);
  double missing = 1;
  for (const auto& frame : frames) {
    EXPECT_EQ(frame["complete"].get<bool>(), frame["missing_share"].get<double>() == 0);
    EXPECT_LE(frame["missing_share"].get<double>(), missing);
    missing = frame["missing_share"].get<double>();
  }
  const auto unlimited = program.json("render v.zarr -o g.png" + std::string(kView));
  EXPECT_TRUE(unlimited["frames"][0]["complete"]);
}

}  // namespace
}  // namespace sluice::out_of_core_test
