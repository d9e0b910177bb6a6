// `plan` compared with `render` of the same options and with itself.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include "tests/tools/program.h"

namespace sluice {
namespace {

using testing::HasSubstr;
using testing::Not;

constexpr const char* kPlan = "plan synth:phantom,dims=60x56x50 --threshold 60 --block 32";

TEST(Plan, growingBoxesLieBetweenObjectBoxesAndPerfectBricks) {
  const Program program;
  const auto plan = program.json(std::string(kPlan) + " --partition boxes");
  const auto& boxes = plan["partition"];
  EXPECT_GT(boxes["visible_boxes"].get<int64_t>(), 0);
  EXPECT_LT(boxes["visible_boxes"], boxes["boxes"]);
  EXPECT_LT(boxes["visible_cells"], boxes["object_cells"]);
  EXPECT_LT(boxes["visible_cells"].get<double>(), 1.35 * boxes["perfect_cells"].get<double>());
  EXPECT_LE(boxes["object_cells"].get<int64_t>(), 59 * 55 * 49);
  EXPECT_LE(boxes["textures"], boxes["boxes"]);
  EXPECT_EQ(boxes["uniform_boxes"].get<int64_t>() + boxes["gradient_boxes"].get<int64_t>() +
                boxes["other_boxes"].get<int64_t>(),
            boxes["boxes"].get<int64_t>());
  EXPECT_EQ(plan["options"]["partition"], "boxes");
  EXPECT_EQ(boxes["index_pieces"], 1) << "kept for the picture that may follow";
}

TEST(Plan, withoutGrowingBoxesNothingIsSaidOfThem) {
  const Program program;
  EXPECT_FALSE(program.json(kPlan).contains("partition"));
  EXPECT_FALSE(program.json(std::string(kPlan) + " --partition blocks").contains("partition"));
  EXPECT_EQ(program.run(std::string(kPlan) + " --partition bricks").status, 2);
}

TEST(Plan, printsTheThreePartitions) {
  const Program program;
  const CommandResult result = program.run(std::string(kPlan) + " --partition boxes");
  EXPECT_EQ(result.status, 0);
  for (const char* line : {"object boxes", "growing boxes", "bricks of 8^3", "boxes grown"})
    EXPECT_NE(result.output.find(line), std::string::npos) << line;
}

TEST(BenchSlicing, saysWhatBothSlicersTake) {
  const Program program;
  const auto report = program.json("bench slicing");
  EXPECT_GT(report["slices"].get<int64_t>(), 10000);
  EXPECT_GT(report["incremental_ns"].get<double>(), 0);
  EXPECT_GT(report["plain_ns"].get<double>(), 0);
}

TEST(Plan, countsOneBlockAndOneCluster) {
  const Program program;
  const CommandResult plan = program.run("plan synth:cube,dims=16x16x16");
  EXPECT_NE(plan.output.find("reads 1 block, "), std::string::npos) << plan.output;
  EXPECT_NE(plan.output.find("1 cluster of"), std::string::npos) << plan.output;
}

TEST(Plan, theFirstSaysThatItMakesTheIndex) {
  const Program program;
  const std::string line = std::string("plan ") + kSmall;
  const CommandResult first = program.run(line), second = program.run(line);
  EXPECT_NE(first.output.find("index built: this plan has read the whole volume for it, the next "
                              "one reads no voxel\n"),
            std::string::npos)
      << first.output;
  EXPECT_EQ(second.output.find("index"), std::string::npos) << second.output;
  const CommandResult never = runCommand("cd " + shellQuoted(program.folder.path().string()) +
                                         " && SLUICE_INDEX=off " SLUICE_PROGRAM " " + line);
  EXPECT_NE(never.output.find("and so will the next one"), std::string::npos) << never.output;
}

// Hundreds of thousands of blocks, most of which are empty.
constexpr const char* kManyBlocks = "synth:noise,dims=80x80x80,type=u16 --block 4 -j 1";

TEST(Plan, keepsWithinTheMemory) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "a sanitizer's own memory";
#endif
  const Program program;
  const auto plan = program.json(fmt::format("plan {} --memory 96M", kManyBlocks));
  EXPECT_GT(plan["algorithms"]["conventional"]["chunks"].get<int64_t>(), 400'000);
  rusage used{};
  ASSERT_EQ(getrusage(RUSAGE_CHILDREN, &used), 0);
  // The budget, and the program with its libraries. A plan of all blocks takes some 300 MiB.
  EXPECT_LE(used.ru_maxrss >> 10, 96 + 64);
}

TEST(Plan, refusesAMemoryThatHasNoRoomForItAsRenderDoes) {
  const Program program;
  for (const char* algorithm : {"merged", "conventional"}) {
    const std::string options =
        fmt::format("{} --memory 40M --device cpu --algorithm {}", kManyBlocks, algorithm);
    const CommandResult plan = program.run("plan " + options);
    EXPECT_EQ(plan.status, 1);
    EXPECT_THAT(plan.output, HasSubstr("of buffers are the least that works"));
    EXPECT_EQ(plan.output, program.run("render -o a.png " + options).output);
  }
  const std::string two = std::string(kManyBlocks) + " --memory 60M --device cpu --over " +
                          std::string(kManyBlocks).substr(0, std::string(kManyBlocks).find(' '));
  const CommandResult plan = program.run("plan " + two);
  EXPECT_THAT(plan.output, HasSubstr("--memory 60.0 MiB is too small: 2 channels share"));
  EXPECT_EQ(plan.output, program.run("render -o a.png " + two).output);
}

// The number is of all channels together, as the option is.
TEST(Plan, theMemoryThatAMessageNamesIsEnough) {
  const Program program;
  for (const std::string more : {"", " --over synth:cube,dims=24x24x24"}) {
    const std::string line = "render synth:cube,dims=24x24x24 --size 32x32 -o a.png --force" + more;
    const std::string output = program.run(line + " --memory 64K").output;
    const size_t at = output.find("give --memory ");
    ASSERT_NE(at, std::string::npos) << output;
    const auto bytes = std::stoull(output.substr(at + std::string("give --memory ").size()));
    const CommandResult enough = program.run(fmt::format("{} --memory {}", line, bytes));
    EXPECT_EQ(enough.status, 0) << output << enough.output;
    EXPECT_NE(program.run(fmt::format("{} --memory {}", line, bytes - 2)).status, 0);
  }
}

TEST(Plan, countsTheReadsOfEachAlgorithm) {
  const Program program;
  for (const char* crop : {"", " --crop 2,3,4,30,20,9"})
    for (const char* algorithm : {"conventional", "clipped", "trimmed", "merged"}) {
      const std::string options = fmt::format(
          "synth:shells,dims=60x56x50 --threshold 90 --block 16 --algorithm {}{}", algorithm, crop);
      const auto plan = program.json("plan " + options);
      const auto drawn = program.json("render --force -o a.png " + options);
      EXPECT_EQ(plan["read"]["blocks"], drawn["levels"]["volume_buffer"]["loads"]) << options;
      EXPECT_EQ(plan["read"]["voxel_bytes"], drawn["frames"][0]["decoded_bytes"]) << options;
      EXPECT_EQ(plan["most_read"], plan["read"]) << options;
    }
}

TEST(Plan, boundsTheReadsThatALittleMemoryRepeats) {
  const Program program;
  writeFile(program.folder / "v_96x96x96_uint16.raw", std::string(size_t{96} * 96 * 96 * 2, 'v'));
  // The memory beside the plan of 17576 blocks holds few of them, and the picture comes in strips.
  for (const char* view : {"", " --azimuth 282 --projection perspective"}) {
    const std::string options = fmt::format(
        "v_96x96x96_uint16.raw --block 8 -j 1 --memory 9M --pages 1 --mode mip "
        "--size 200 --device cpu{}",
        view);
    const auto plan = program.json("plan " + options);
    const auto drawn = program.json("render --force -o a.png " + options);
    const auto& most = plan["most_read"];
    const auto decoded = drawn["frames"][0]["decoded_bytes"].get<uint64_t>();
    EXPECT_GT(decoded, plan["read"]["voxel_bytes"].get<uint64_t>());
    EXPECT_LE(decoded, most["voxel_bytes"].get<uint64_t>());
    EXPECT_LE(drawn["levels"]["volume_buffer"]["loads"], most["blocks"]);
    // A chunk shows in one or two of the seven strips, and its blocks are those of two clusters.
    EXPECT_LT(most["blocks"].get<int64_t>(), 4 * plan["read"]["blocks"].get<int64_t>());
    EXPECT_THAT(program.run("plan " + options).output,
                HasSubstr(fmt::format("reads blocks up to {} times in all",
                                      most["blocks"].get<int64_t>())));
  }
  EXPECT_THAT(program.run("plan v_96x96x96_uint16.raw --block 8").output, Not(HasSubstr("up to")));
}

TEST(Plan, namesTheLeastMemoryThatRenderWorksWith) {
  const Program program;
  for (const char* options :
       {"--device cpu --pages 64", "--device cpu --size 500 --block 32 --azimuth 101",
        "--device cpu --pages 64 --algorithm conventional", "--pages 64 --partition boxes",
        "--device cpu --pages 64 --occlusion clip", "--gl osmesa --pages 64"}) {
    const std::string line = fmt::format("synth:shells,dims=90x80x70 --threshold 90 {}", options);
    const auto tight = program.json(fmt::format("plan {} --memory 2M", line));
    EXPECT_FALSE(tight["memory"]["fits"].get<bool>()) << line;
    const auto least = tight["memory"]["least_bytes"].get<uint64_t>();
    for (const uint64_t memory : {least, least - 1}) {
      const bool fits = memory == least;
      const std::string with = fmt::format("{} --memory {}", line, memory);
      EXPECT_EQ(program.json("plan " + with)["memory"]["fits"], fits) << with;
      EXPECT_EQ(program.run("render --force -o a.png " + with).status, fits ? 0 : 1) << with;
    }
  }
}

// The more memory there is, the more blocks may a cut have, whose plan takes memory: the least that
// works is searched.
TEST(Plan, ofLevelsNamesTheLeastMemoryThatRenderWorksWith) {
  const Program program;
  for (const std::string more : {"", " --over synth:shells,dims=120x110x100,levels=3"}) {
    const std::string line =
        "synth:shells,dims=120x110x100,levels=3 --threshold 60 --device cpu --size 200 --block 8 "
        "--pixel-error 1 --memory ";
    const auto least =
        program.json("plan " + line + "64M" + more)["memory"]["least_bytes"].get<uint64_t>();
    for (const uint64_t memory : {least, least - 1}) {
      const bool fits = memory == least;
      const std::string with = fmt::format("{}{}{}", line, memory, more);
      const CommandResult drawn = program.run("render -q --force -o a.png " + with);
      EXPECT_EQ(drawn.status, fits ? 0 : 1) << with << drawn.output;
      const std::string named = fits ? "" : fmt::format("give --memory {} ", least);
      EXPECT_THAT(drawn.output, HasSubstr(named));
      const CommandResult plan = program.run("plan -q " + with);
      if (plan.status != 0) {
        EXPECT_FALSE(fits);
        EXPECT_EQ(plan.output, drawn.output);
      } else {
        EXPECT_EQ(program.json("plan " + with)["memory"]["fits"], fits) << with;
      }
    }
  }
}

// The levels that sluice makes are stored in chunks, which are decoded whole. Voxels of a raw file
// are not.
TEST(Plan, countsDecodedChunksOfCoarserLevelsInTheLeastMemory) {
  const Program program;
  ASSERT_EQ(program.run("synth shells -o v_90x80x70_uint8.raw --dims 90,80,70").status, 0);
  const std::string line =
      "v_90x80x70_uint8.raw --levels always --block 16 --device cpu --pages 64 --threshold 90 "
      "--size 128 --memory ";
  const auto plan = program.json("plan " + line + "64M");
  const auto least = plan["memory"]["least_bytes"].get<uint64_t>();
  EXPECT_EQ(program.run("render --force -o a.png " + line + std::to_string(least)).status, 0);
  EXPECT_EQ(program.run("render --force -o a.png " + line + std::to_string(least - 1)).status, 1);
}

TEST(Plan, refusesWhatRenderRefuses) {
  const Program program;
  for (const char* options :
       {"--culling toc --pixel-error 2", "--iso 100 --level 1", "--culling toc --max-bytes 1M",
        "--culling toc --keep-thin", "--iso 100 --mode mip", "--shadows --mode mip",
        "--shadows --no-shade", "--threshold 40 --modulate --shadows",
        "--occlusion-light --no-shade", "--depth-cueing 0.5 --mode mip",
        "--jitter 1 --mode average", "--culling toc --iso 100", "--culling toc --mode mip",
        "--occlusion cull --mode mip", "--culling toc --level 1",
        "--pages 1 --block 64 --algorithm conventional", "--channel 3", "--time 9",
        "--crop 5,0,0,5,5,5"}) {
    const std::string line = fmt::format("{} {}", kSmall, options);
    const CommandResult plan = program.run("plan " + line);
    EXPECT_NE(plan.status, 0) << line;
    const CommandResult drawn = program.run("render --force -o a.png " + line);
    EXPECT_EQ(plan.status, drawn.status) << line;
    EXPECT_EQ(plan.output, drawn.output) << line;
  }
}

TEST(Plan, saysTheChunksAndPagesThatARenderMoves) {
  const Program program;
  const auto plan =
      program.json(std::string("plan ") + kSmall + " --page 16x16x4 --block 16 --pages 4096");
  for (const char* algorithm : {"conventional", "clipped", "trimmed", "merged"}) {
    const CommandResult drawn = program.run(
        std::string("render ") + kSmall + " --page 16x16x4 --block 16 --pages 4096 -o a.png" +
        " --size 32 --device gl --report r.json --algorithm " + algorithm);
    ASSERT_EQ(drawn.status, 0) << drawn.output;
    const auto frame = nlohmann::json::parse(readFile(program.folder / "r.json"))["frames"][0];
    EXPECT_EQ(plan["algorithms"][algorithm]["chunks"], frame["chunks"]);
    EXPECT_EQ(plan["algorithms"][algorithm]["pages"], frame["pages_loaded"]);
    EXPECT_EQ(plan["algorithms"][algorithm]["bytes"], frame["uploaded_bytes"]);
    EXPECT_EQ(plan["algorithms"][algorithm]["binds"], frame["binds"]);
  }
  EXPECT_GT(plan["clusters"].get<int64_t>(), 0);
  EXPECT_GE(plan["seconds"].get<double>(), 0);
}

}  // namespace
}  // namespace sluice
