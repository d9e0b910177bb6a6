// Pictures of several channels, or with a second volume, by ranks that mpirun has started.
#include <fstream>

#include "tests/parallel/ranks_program.h"
#include "tests/tools/script_files.h"

namespace sluice {
namespace {

using nlohmann::json;
using testing::HasSubstr;

// Channels are files by zarr-python, which is sought in the system's own Python.
class RanksChannels : public RanksTest {
 protected:
  // Writes cells.ome.zarr into each of the folders.
  void writeCells(const std::vector<std::string>& folders) const {
    for (const std::string& folder : folders)
      if (!copyScriptFiles("channels.py", "numpy, PIL, tifffile, zarr", program_.folder / folder))
        GTEST_SKIP() << "python3 with numpy, pil, tifffile and zarr is missing";
  }
  CommandResult onRanks(int ranks, const std::string& arguments) const {
    return inFolder(GetParam().start(ranks, 60) + " " + arguments);
  }
  CommandResult inFolder(const std::string& command) const {
    return runCommand("cd " + shellQuoted(program_.folder.path().string()) +
                      "; export XDG_CACHE_HOME=\"$PWD/cache\"; " + command);
  }
  // Draws the picture on so many ranks, and returns the report; `one` is that of one process.
  json expectSame(int ranks, const std::string& picture, const json& one) const {
    const CommandResult run = onRanks(ranks, picture + " -o many.png --json -q");
    EXPECT_EQ(run.status, 0) << run.output;
    if (run.status != 0) return {};
    EXPECT_LE(pictureDifference(program_.folder / "one.png", program_.folder / "many.png"), 1);
    json many = json::parse(run.output);
    EXPECT_EQ(many["ranks"].size(), static_cast<size_t>(ranks));
    for (size_t c = 0; c < one["channels"].size(); ++c) {
      const json &here = many["frames"][0]["channels"][c], &all = one["frames"][0]["channels"][c];
      for (const char* count : {"blocks", "samples_drawn", "decoded_bytes", "empty"})
        EXPECT_EQ(here[count], all[count]) << "channel " << c << " " << count;
      uint64_t read_bytes = 0;
      for (const json& rank : many["ranks"])
        read_bytes += rank["channels"][c]["read_bytes"].get<uint64_t>();
      EXPECT_EQ(many["channels"][c]["read_bytes"], read_bytes);
    }
    return many;
  }
  void expectSame(const std::string& options) const {
    const std::string picture = "render --size 100x80 --force " + options;
    const json one = program_.json(picture + " -o one.png");
    for (const int ranks : {2, 3, 4}) {
      SCOPED_TRACE(fmt::format("{} ranks, {}", ranks, picture));
      expectSame(ranks, picture, one);
    }
  }
  // Starts a rank with each of the arguments; the second one would draw something else.
  void expectRefused(const std::string& first, const std::string& second,
                     const std::string& reason) const {
    SCOPED_TRACE(first + " : " + second);
    const CommandResult run = inFolder(GetParam().startEach({first, second}));
    EXPECT_EQ(run.status, 1) << run.output;
    EXPECT_EQ(occurrences(run.output, "sluice: "), 1) << run.output;
    EXPECT_THAT(run.output, HasSubstr("sluice: rank 1 of 2"));
    EXPECT_THAT(run.output, HasSubstr(reason));
    EXPECT_FALSE(program_.exists("a.png"));
  }
  const Program program_;
};

TEST_P(RanksChannels, drawThePictureOfOneProcess) {
  ASSERT_NO_FATAL_FAILURE(writeCells({"."}));
  if (IsSkipped()) return;
  for (const char* options : {"", "--shade --projection perspective", "--mode mip",
                              "--channel 2,0 --mode average --background 000000"})
    expectSame(fmt::format("cells.ome.zarr --block 16 --page 16x16x16 {}", options));
}

TEST_P(RanksChannels, drawASecondVolumeOnAGridOfItsOwn) {
  constexpr const char* kOver = "--over synth:parts,dims=40x44x48";
  for (const std::string& options :
       {fmt::format("synth:phantom,dims=60x64x68 {} --block 8 --crop 3,5,2,50,60,60", kOver),
        fmt::format("synth:phantom,dims=100x94x88,levels=4 {} --block 8 --pixel-error 2", kOver),
        fmt::format("synth:phantom,dims=60x64x68 {} --block 8 --mode mip --look over:hot", kOver)})
    expectSame(options);
}

TEST_P(RanksChannels, blendThePictureOfOneProcess) {
  ASSERT_NO_FATAL_FAILURE(writeCells({"."}));
  if (IsSkipped()) return;
  // Some ranks have no block of the spots, and nobody has one of channel 1 in the last picture.
  for (const char* options : {"--block 16", "--block 16 --shade --projection perspective",
                              "--block 8 --look 2:red,5120:5300",
                              "--block 16 --algorithm conventional --look 1:,60000:65000"})
    expectSame(fmt::format("cells.ome.zarr --combine blend --page 16x16x16 {}", options));
}

TEST_P(RanksChannels, blendASecondVolumeWithTheFirst) {
  expectSame(
      "synth:phantom,dims=60x64x68 --over synth:parts,dims=60x64x68 --combine blend --block 8");
  expectSame("synth:phantom,dims=60x64x68 --over synth:parts,dims=60x64x68 --block 8");
  // The cut through the levels is dealt once for all channels, whatever the algorithm loads.
  for (const char* options : {"", "--pixel-error 8 --algorithm conventional",
                              "--level 1 --algorithm conventional", "--level 1 --shade"})
    expectSame(
        fmt::format("synth:phantom,dims=60x64x68,levels=3 --over "
                    "synth:shells,dims=60x64x68,levels=3 --combine blend --block 8 {}",
                    options));
}

// A rank that decided for itself to leave a channel out would not meet the others.
TEST_P(RanksChannels, composeAChannelThatOneRankAloneHas) {
  const std::string picture =
      "render synth:shells,dims=40x40x40 --over synth:shells,dims=8x8x8 --block 8 --size 60 "
      "--frames 2 --force ";
  const json one = program_.json(picture + "-o one_%d.png");
  const CommandResult run = onRanks(4, picture + "-o many_%d.png --json -q");
  ASSERT_EQ(run.status, 0) << run.output;
  const json many = json::parse(run.output);
  for (size_t frame = 0; frame < 2; ++frame) {
    int have = 0;
    for (const json& rank : many["ranks"]) {
      const json& blocks = rank["frames"][frame]["channels"][1]["blocks"];
      have += blocks["grey"].get<int>() + blocks["black"].get<int>() > 0 ? 1 : 0;
    }
    EXPECT_EQ(have, 1);
    EXPECT_FALSE(many["frames"][frame]["channels"][1]["empty"]);
    EXPECT_LE(pictureDifference(program_.folder / fmt::format("one_{}.png", frame),
                                program_.folder / fmt::format("many_{}.png", frame)),
              1);
  }
}

TEST_P(RanksChannels, leaveOutChannelsThatShowNothing) {
  ASSERT_NO_FATAL_FAILURE(writeCells({"."}));
  if (IsSkipped()) return;
  const std::string cells = "cells.ome.zarr --block 16 ";
  for (const char* looks : {"--look 1:,60000:65000", "--look 0:,60000:65000 --look 2:,60000:65000"})
    expectSame(cells + looks);
  const CommandResult run =
      onRanks(3, "render --size 60 " + cells + "--look 1:,60000:65000 -o a.png");
  EXPECT_EQ(run.status, 0);
  EXPECT_EQ(occurrences(run.output, "channel 1 (Actin) shows nothing: "), 1) << run.output;
  const CommandResult none =
      onRanks(3, "render --size 60 " + cells + "--range 60000,65000 -o b.png");
  EXPECT_EQ(none.status, 0);
  EXPECT_EQ(occurrences(none.output, "b.png shows nothing: "), 1) << none.output;
}

TEST_P(RanksChannels, drawASeriesTogetherWithAVolumeOfOneStep) {
  ASSERT_EQ(program_.run("synth mixing -o mix_%03d.nrrd --dims 40,40,40 --steps 3 -q").status, 0);
  for (const char* over :
       {"--over synth:parts,dims=24x24x24", "--over synth:shells,dims=40x40x40 --combine blend"}) {
    SCOPED_TRACE(over);
    const std::string series = fmt::format(
        "render mix_%03d.nrrd --threshold 100 {} --time 0:2 --block 8 --size 60 ", over);
    ASSERT_EQ(program_.run(series + "-o one_%d.png -q --force").status, 0);
    const CommandResult run = onRanks(3, series + "-o many_%d.png -q --force");
    ASSERT_EQ(run.status, 0) << run.output;
    for (int step = 0; step < 3; ++step)
      EXPECT_LE(pictureDifference(program_.folder / fmt::format("one_{}.png", step),
                                  program_.folder / fmt::format("many_{}.png", step)),
                1)
          << step;
  }
}

TEST_P(RanksChannels, keepToTheirOwnBudgets) {
  const std::string picture =
      "render synth:phantom,dims=128x128x128 --over synth:parts,dims=128x128x128 --block 16 "
      "--page 16x16x16 -o a.png ";
  const CommandResult run = onRanks(2, picture + "--size 200 --memory 60M --json -q");
  ASSERT_EQ(run.status, 0) << run.output;
  for (const json& rank : json::parse(run.output)["ranks"]) {
    const uint64_t budget = uint64_t{60} << 20;
    EXPECT_EQ(rank["memory_bytes"], budget);
    EXPECT_LE(rank["part_bytes"].get<uint64_t>(), rank["part_memory_bytes"].get<uint64_t>() / 2);
    EXPECT_LE(rank["peak_anonymous_bytes"].get<uint64_t>(), budget + (uint64_t{64} << 20));
  }
  const CommandResult small = onRanks(2, picture + "--force --size 2000 --memory 60M");
  EXPECT_EQ(small.status, 1);
  EXPECT_EQ(occurrences(small.output, "sluice: "), 1) << small.output;
  EXPECT_THAT(small.output, HasSubstr("2 channels share the memory evenly"));
}

TEST_P(RanksChannels, agreeOnEachChannel) {
  ASSERT_NO_FATAL_FAILURE(writeCells({"a", "same", "look", "voxels", "list"}));
  if (IsSkipped()) return;
  const auto edit = [&](const char* folder, const auto& change) {
    const std::filesystem::path file = program_.folder / folder / "cells.ome.zarr/.zattrs";
    json attributes = json::parse(readFile(file));
    change(attributes["omero"]["channels"][1]);
    writeFile(file, attributes.dump());
  };
  edit("look", [](json& channel) { channel["window"]["end"] = 1900; });
  edit("list", [](json& channel) { channel["active"] = false; });
  const std::filesystem::path chunks = program_.folder / "voxels/cells.ome.zarr/0";
  std::filesystem::copy_file(chunks / "1.0.0.0", chunks / "2.0.0.0",
                             std::filesystem::copy_options::overwrite_existing);
  const auto render = [](const std::string& folder, const std::string& more = "") {
    return "render " + folder + "/cells.ome.zarr --size 50 --fit volume -o a.png" + more;
  };
  expectRefused(render("a"), render("look"), "transfer functions of channel 1 differ");
  expectRefused(render("a"), render("voxels"),
                "is channel 2 of voxels/cells.ome.zarr an old copy on one host?");
  expectRefused(render("a"), render("list"), "the list of channels is 0,2, on rank 0 0,1,2");
  expectRefused(render("a", " --look 1:red"), render("a", " --look 1:green"),
                "--look is 1:green, on rank 0 1:red");
  const CommandResult same = inFolder(GetParam().startEach({render("a"), render("same")}));
  EXPECT_EQ(same.status, 0) << same.output;
}

TEST_P(RanksChannels, agreeOnTheSecondVolume) {
  ASSERT_EQ(program_.run("synth shells -o a.nrrd --dims 24,24,24 -q").status, 0);
  ASSERT_EQ(program_.run("synth sparse -o b.nrrd --dims 24,24,24 -q").status, 0);
  std::filesystem::copy_file(program_.folder / "a.nrrd", program_.folder / "c.nrrd");
  const std::string render = "render synth:shells,dims=40x40x40 --size 50 --fit volume -o a.png ";
  expectRefused(render + "--over a.nrrd", render + "--over b.nrrd",
                "is b.nrrd an old copy on one host?");
  expectRefused(render + "--over a.nrrd", render, "--over is not given, on rank 0 given");
  const CommandResult same =
      inFolder(GetParam().startEach({render + "--over a.nrrd", render + "--over c.nrrd"}));
  EXPECT_EQ(same.status, 0) << same.output;
}

INSTANTIATE_TEST_SUITE_P(By, RanksChannels, testing::Values(kOpenMpiLauncher, kMpichLauncher),
                         [](const auto& tested) { return tested.param.name; });

}  // namespace
}  // namespace sluice
