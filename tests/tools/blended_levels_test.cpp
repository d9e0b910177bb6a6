// Blended pictures from levels of resolution: a scan and its labels in packed stores.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "tests/tools/program.h"

namespace sluice {
namespace {

using testing::HasSubstr;

class BlendedLevels : public testing::Test {
 protected:
  void SetUp() override {
    run("pack synth:phantom,dims=160x160x160 -o scan.zarr --levels 3 --quiet");
    run("pack synth:parts,dims=160x160x160 -o parts.zarr --levels 3 --downsample mode "
        "--quiet");
  }
  void run(const std::string& arguments) const {
    const CommandResult result = program_.run(arguments);
    ASSERT_EQ(result.status, 0) << arguments << "\n" << result.output;
  }
  std::string picture(const std::string& name) const {
    return readFile(program_.folder.path() / name);
  }

  const Program program_;
};

const std::string kPair =
    " scan.zarr --over parts.zarr --look over:labels,0.3 --size 160x140 --block 32 ";
const std::string kBoth = kPair + "--combine blend ";

// The counts of each channel, which come from one cut.
TEST_F(BlendedLevels, aPlanIsThatOfThePicture) {
  for (const char* options :
       {"--pixel-error 1", "--pixel-error 3", "--level 1", "--level 0", "--pixel-error 1 --zoom 5",
        "--projection perspective --zoom 6 --pixel-error 2 --pages 512",
        "--pixel-error 1 --algorithm conventional", "--keep-thin --pixel-error 4"}) {
    const auto plan = program_.json(fmt::format("plan{}{}", kBoth, options));
    const auto frame =
        program_.json(fmt::format("render{}{} --force -o a.png", kBoth, options))["frames"][0];
    ASSERT_EQ(plan["channels"].size(), 2U) << options;
    for (size_t c = 0; c < 2; ++c) {
      const auto &planned = plan["channels"][c], &drawn = frame["channels"][c];
      EXPECT_EQ(planned["blocks"], drawn["blocks"]) << options << " " << c;
      if (std::string_view(options).ends_with("conventional")) continue;
      EXPECT_EQ(planned["algorithms"]["merged"]["chunks"], drawn["chunks"]) << options << " " << c;
    }
  }
}

// The simulator plans the requests of each channel from the same cut, also when the levels have two
// numbers a texel, a channel shows nothing, or all blocks are loaded.
TEST_F(BlendedLevels, aSimulatedTurnIsThatOfThePicture) {
  for (const char* options :
       {"--pixel-error 1", "--level 1", "--combine add --pixel-error 2",
        "--pixel-error 2 --look 0:red,254:255",
        // The clusters of both channels together differ from those of each.
        "--pixel-error 3 --zoom 3 --projection perspective --page 32x32x4 --pages 512",
        "--pixel-error 1 --page 32x32x4 --pages 256",
        "--pixel-error 1 --algorithm conventional --page 32x32x4 --pages 512",
        // Half of the memory holds fewer pages.
        "--level 0 --memory 40M --combine add", "--pixel-error 0.5 --memory 50M"}) {
    SCOPED_TRACE(options);
    const bool adds = std::string_view(options).find("--combine") != std::string_view::npos;
    const std::string command = fmt::format("{}--frames 3 --threads 2 --force {} {}", kPair,
                                            options, adds ? "" : "--combine blend ");
    const auto report = program_.json("render" + command + " --trace t.bin -o a.png")["channels"];
    const auto simulated = program_.json("simulate" + command + " --policies lru --export p.bin");
    ASSERT_EQ(report.size(), 2);
    for (size_t c = 0; c < 2; ++c) {
      const auto& cache = report[c]["levels"]["texture_cache"];
      EXPECT_EQ(simulated["runs"][c]["chosen"]["pages"], cache["pages"]);
      size_t rows = 0;
      for (const auto& row : simulated["rows"]) {
        if (row["channel"] != report[c]["channel"] || row["pages"] != cache["pages"]) continue;
        ++rows;
        EXPECT_EQ(row["chunk_requests"], cache["requests"]);
        EXPECT_EQ(row["chunk_misses"], cache["misses"]);
        EXPECT_EQ(row["evictions"], cache["evictions"]);
        EXPECT_EQ(row["pages_loaded"], cache["pages_loaded"]);
      }
      EXPECT_EQ(rows, 1);
      EXPECT_EQ(picture(c == 0 ? "p_0.bin" : "p_over.bin"),
                picture(c == 0 ? "t_0.bin" : "t_over.bin"));
    }
  }
}

// As coarse as it is asked for, it reads no finer level, and differs from the finest one by little.
TEST_F(BlendedLevels, aCoarsePictureReadsNoFineLevel) {
  const auto readBytes = [&](const std::string& options) {
    const auto report = program_.json(fmt::format("render{}{}", kBoth, options));
    return report["frames"][0]["decoded_bytes"].get<double>();
  };
  const double fine = readBytes("--level 0 --step 0.5 -o fine.png");
  const double coarse = readBytes("--level 1 --step 0.5 -o coarse.png");
  EXPECT_LT(coarse, fine / 2);  // two numbers of an eighth of the voxels, in fewer blocks
  EXPECT_GT(coarse, 0);
}

// A limit of bytes is one for all channels.
TEST_F(BlendedLevels, channelsShareALimitOfBytes) {
  for (const char* combine : {"blend", "add"}) {
    const auto frame = program_.json(
        fmt::format("render{}--combine {} --pixel-error 0.3 --max-bytes 1000000 --force -o a.png",
                    kPair, combine))["frames"][0];
    EXPECT_FALSE(frame["channels"][0]["cut"]["final"].get<bool>()) << combine;
    EXPECT_GT(frame["decoded_bytes"], 100000) << combine;
    EXPECT_LE(frame["decoded_bytes"], 1000000) << combine;
  }
}

// A channel that shows nothing takes nothing from a cut.
TEST_F(BlendedLevels, withOneThatShowsNothingItIsThePictureOfTheOther) {
  run("pack synth:phantom,dims=160x160x160 -o other.zarr --levels 3 --quiet");
  for (const char* options : {"--pixel-error 3", "--level 2 --projection perspective"}) {
    const std::string common =
        fmt::format(" --step 1 --fit volume --size 160x140 {} --force -o ", options);
    run("render scan.zarr --over other.zarr --combine blend --look over:red,254:255" + common +
        "both.png");
    run("render scan.zarr" + common + "one.png");
    EXPECT_EQ(picture("both.png"), picture("one.png")) << options;
  }
}

// A row of pictures ends with the one that is drawn at once.
TEST_F(BlendedLevels, aRowOfPicturesBecomesTheOneThatWaits) {
  const std::string command = fmt::format("render{}--step 1 --force ", kBoth);
  // Makes the index, which the automatic look follows from.
  run(command + "--pixel-error 1 -o whole.png");
  const auto report = program_.json(command + "--pixel-error 1 --progressive -o 'p_#.png'");
  const auto& pictures = report["frames"][0]["pictures"];
  ASSERT_GE(pictures.size(), 3U);
  ASSERT_EQ(pictures[0]["cut"]["levels"].size(), 1U);
  const int coarsest = pictures[0]["cut"]["levels"][0]["level"].get<int>();
  EXPECT_GT(coarsest, 0);
  EXPECT_EQ(picture(fmt::format("p_{}.png", pictures.size() - 1)), picture("whole.png"));
  run(command + fmt::format("--level {} -o coarse.png", coarsest));
  EXPECT_EQ(picture("p_0.png"), picture("coarse.png"));
}

// Of volumes with more and fewer levels, those that both have are used: the picture is the one of
// two volumes with as many levels as the one with fewer.
TEST_F(BlendedLevels, withFewerLevelsOfOneThoseInCommonAreBlended) {
  run("pack synth:phantom,dims=160x160x160 -o short.zarr --levels 1 --quiet");
  run("pack synth:parts,dims=160x160x160 -o short_parts.zarr --levels 1 --downsample mode --quiet");
  const auto drawn = [&](const std::string& volumes, const std::string& options,
                         const std::string& name) {
    return program_.json(fmt::format(
        "render {} --look over:labels,0.3 --combine blend --size 160x140 --block 32 --step 0.5 "
        "--threshold 60 --fit volume --no-shade {} --force -o {}.png",
        volumes, options, name));
  };
  for (const char* options : {"--pixel-error 8", "--pixel-error 1", "--level 1"}) {
    SCOPED_TRACE(options);
    const auto expected =
        drawn("short.zarr --over short_parts.zarr", options, "short")["frames"][0];
    for (const char* volumes :
         {"scan.zarr --over short_parts.zarr", "short.zarr --over parts.zarr"}) {
      const auto frame = drawn(volumes, options, "mixed")["frames"][0];
      for (size_t c = 0; c < 2; ++c)
        EXPECT_EQ(frame["channels"][c]["cut"]["levels"], expected["channels"][c]["cut"]["levels"])
            << volumes << " " << c;
      EXPECT_EQ(frame["decoded_bytes"], expected["decoded_bytes"]) << volumes;
      EXPECT_EQ(picture("mixed.png"), picture("short.png")) << volumes;
    }
  }
  const auto coarse =
      drawn("scan.zarr --over short_parts.zarr", "--pixel-error 8", "mixed")["frames"][0];
  EXPECT_EQ(coarse["channels"][0]["cut"]["levels"].size(), 1);
  EXPECT_EQ(coarse["channels"][0]["cut"]["levels"][0]["level"], 1);
}

// A level that one of them lacks was drawn as the finest one of all, without a word.
TEST_F(BlendedLevels, aLevelThatOneLacksIsRefused) {
  run("pack synth:phantom,dims=160x160x160 -o flat.zarr --levels none --quiet");
  run("pack synth:parts,dims=160x160x160 -o short.zarr --levels 1 --downsample mode --quiet");
  run("pack synth:parts,dims=160x160x160 -o means.zarr --levels 3 --quiet");
  const auto refused = [&](const std::string& arguments, const std::string& words) {
    for (const char* command : {"render -o no.png ", "plan ", "simulate "}) {
      const CommandResult result =
          program_.run(command + arguments + " --combine blend --look over:labels,0.3");
      EXPECT_EQ(result.status, 1) << command << arguments;
      EXPECT_THAT(result.output, HasSubstr(words)) << command << arguments;
    }
    EXPECT_FALSE(std::filesystem::exists(program_.folder.path() / "no.png"));
  };
  refused("scan.zarr --over short.zarr --level 2", "short.zarr has no such level in common");
  refused("scan.zarr --over flat.zarr --level 1", "flat.zarr: --level 1: there is 1 level");
  refused("flat.zarr --over scan.zarr --level 1", "flat.zarr: --level 1: there is 1 level");
  refused("scan.zarr --over means.zarr --level 1", "means.zarr: its coarser levels hold means");
}

// Unasked, volumes that differ in their levels keep them and are added, and others are blended.
TEST_F(BlendedLevels, unaskedIsBlendedFromLevelsThatBothHave) {
  run("pack synth:phantom,dims=160x160x160 -o flat.zarr --levels none --quiet");
  run("pack synth:parts,dims=160x160x160 -o short.zarr --levels 1 --downsample mode --quiet");
  for (const auto& [arguments, combine] :
       {std::pair("scan.zarr --over parts.zarr --pixel-error 2", "blend"),
        std::pair("scan.zarr --over parts.zarr --level 1", "blend"),
        std::pair("scan.zarr --over short.zarr --pixel-error 4", "blend"),
        std::pair("scan.zarr --over short.zarr --level 2", "add"),
        std::pair("flat.zarr --over parts.zarr --pixel-error 4", "add"),
        std::pair("flat.zarr --over parts.zarr --level 0", "blend")}) {
    SCOPED_TRACE(arguments);
    const std::string command =
        fmt::format("render {} --size 160x140 --block 32 --force ", arguments);
    run(command + "-o unasked.png");
    run(command + fmt::format("--combine {} -o asked.png", combine));
    EXPECT_EQ(picture("unasked.png"), picture("asked.png"));
  }
}

// Levels of one volume alone are not used, whichever has them.
TEST_F(BlendedLevels, withLevelsOfOneAloneTheFinestIsBlended) {
  run("pack synth:phantom,dims=160x160x160 -o flat.zarr --levels none --quiet");
  const std::string look =
      " --combine blend --look over:labels,0.3 --size 160x140 --shade --force ";
  run("render flat.zarr --over parts.zarr --pixel-error 4 -o flat.png" + look);
  run("render scan.zarr --over parts.zarr --level 0 -o finest.png" + look);
  EXPECT_EQ(picture("flat.png"), picture("finest.png"));
}

// Labels have shares, which are no spreads of values. They were drawn as such, which a check ended.
TEST(LevelsOfLabels, areNotDrawnInALookOfValues) {
  const Program program;
  const auto picture = [&](const std::string& arguments) {
    const CommandResult result = program.run(
        "render --size 16x12 --fit volume --no-shade --block 16 --step 0.5 --force -o a.png " +
        arguments);
    EXPECT_EQ(result.status, 0) << arguments << "\n" << result.output;
    return readFile(program.folder / "a.png");
  };
  const std::string phantom = "pack synth:phantom,dims=48x40x36 --chunk 16 --quiet ";
  for (const char* levels : {"modes.zarr --levels 2 --downsample mode", "flat.zarr --levels none",
                             "means.zarr --levels 2"})
    ASSERT_EQ(program.run(phantom + "-o " + levels).status, 0);
  std::vector<std::string> devices{""};
  if (program.run("render flat.zarr --size 9x9 -o try.png --device gl --gl osmesa").status == 0)
    devices.emplace_back(" --device gl --gl osmesa");
  const std::string first = "synth:shells,dims=48x40x36 --over ";
  for (const std::string& device : devices)
    for (const char* options : {"", " --look over:hot", " --pixel-error 4", " --labels",
                                " --threshold 80 --max-bytes 9000", " --mode mip"}) {
      SCOPED_TRACE(device + options);
      const std::string rest = " --combine add" + device + options;
      EXPECT_EQ(picture(first + "modes.zarr" + rest), picture(first + "flat.zarr" + rest));
    }
  // The first volume has levels of means, with which those of labels could be blended.
  for (const char* options : {"", "--pixel-error 2", "--combine blend", "--level 1"})
    picture(std::string("means.zarr --over modes.zarr ") + options);
  EXPECT_THAT(
      program.run("render means.zarr --over modes.zarr --combine blend --level 1 -o b.png").output,
      HasSubstr("modes.zarr: its coarser levels hold labels, which are no means"));
}

}  // namespace
}  // namespace sluice
