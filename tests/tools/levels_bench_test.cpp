// The benches of levels of resolution.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/tools/program.h"

namespace sluice {
namespace {

TEST(LevelsBench, benchCutPlansAVolumeThatDoesNotExist) {
  const nlohmann::json report = Program().json("bench cut --dims 900,700,500 --frames 2");
  EXPECT_EQ(report["command"], "bench cut");
  EXPECT_GE(report["levels"], 3);
  EXPECT_GT(report["volume_blocks"], 1000);
  // The same volume: the coarser the voxels may be, the fewer blocks are chosen.
  EXPECT_GT(report["first"]["blocks"], 0);
  EXPECT_GT(report["close_view"]["blocks"], report["view"]["blocks"]);
  for (const char* kind : {"first", "threshold", "view", "close_view"})
    for (const char* time : {"choose_seconds", "seconds", "processor_seconds"})
      EXPECT_GE(report[kind][time], 0) << kind << ' ' << time;
  EXPECT_EQ(Program().run("bench cut --dims 900,700").status, 2);
}

TEST(LevelsBench, aBenchComparesPixelErrorsWithTheTruth) {
  const nlohmann::json report = Program().json(
      "bench levels "
      "synth:shells,dims=160x140x120,levels=4"
      " --threshold 60 --size 48x48 --frames 1");
  ASSERT_EQ(report["rows"].size(), 5U);
  for (const nlohmann::json& row : report["rows"]) {
    EXPECT_GT(row["ssim"], 0.8);
    EXPECT_LE(row["ssim"], 1.0);
    // Beyond a pixel the shells are thinner than the voxels that are drawn.
    const nlohmann::json& error = row["pixel_error"];
    EXPECT_LT(row["mean_opacity_error"], error.is_null() || error <= 1 ? 0.1 : 0.2) << row;
    EXPECT_GE(row["max_error"], row["mean_error"]);
    EXPECT_GT(row["detail"], 0);
    EXPECT_GT(row["truth_detail"], 0);
    EXPECT_EQ(row["truth_detail"], report["rows"][0]["truth_detail"]);
  }
  // Level 0 is the last.
  EXPECT_LT(report["rows"][2]["read_bytes"], report["rows"][4]["read_bytes"]);
  EXPECT_LT(report["rows"][2]["samples"], report["rows"][4]["samples"]);
  EXPECT_THAT(Program().run("bench levels synth:shells,dims=40x40x40").output,
              testing::HasSubstr("has one level"));
}

// Slices lie half a voxel of the level apart, as in render. A voxel apart they give 0.976.
TEST(LevelsBench, aBenchDrawsLitLevelsAsRenderDoes) {
  const nlohmann::json report = Program().json(
      "bench levels synth:phantom,dims=192x192x192,levels=3 --size 112x112 --frames 1 --shade "
      "--map plaster --range 16.2,230 --opacities "
      "16.2:0,22.7:0.0114,37.6:0.0137,59:0.035,91:0.052,123.1:0.0754,155.2:0.101,187.2:0.142,"
      "230:0.5");
  const nlohmann::json& row = report["rows"][1];
  EXPECT_EQ(row["pixel_error"], 1);
  EXPECT_EQ(row["cut"]["levels"][0]["level"], 1);
  EXPECT_GT(row["ssim"], 0.985);
}

}  // namespace
}  // namespace sluice
