// `plan` compared with `render` of the same options and with itself.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "tests/tools/program.h"

namespace sluice {
namespace {

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

TEST(Plan, refusesWhatRenderRefuses) {
  const Program program;
  for (const char* options :
       {"--iso 100 --pixel-error 2", "--iso 100 --level 1", "--iso 100 --max-bytes 1M",
        "--iso 100 --keep-thin", "--iso 100 --mode mip", "--shadows --mode mip",
        "--shadows --no-shade", "--occlusion-light --no-shade", "--depth-cueing 0.5 --mode mip",
        "--jitter 1 --mode average", "--culling toc --iso 100", "--culling toc --mode mip",
        "--culling toc --level 1", "--pages 1 --block 64 --algorithm conventional", "--channel 3",
        "--time 9", "--crop 5,0,0,5,5,5"}) {
    const std::string line = fmt::format("{} {}", kSmall, options);
    const CommandResult plan = program.run("plan " + line);
    EXPECT_NE(plan.status, 0) << line;
    const CommandResult drawn = program.run("render --force -o a.png " + line);
    EXPECT_EQ(plan.status, drawn.status) << line;
    EXPECT_EQ(plan.output, drawn.output) << line;
  }
}

}  // namespace
}  // namespace sluice
