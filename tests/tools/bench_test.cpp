// The benches' reports.
#include <gtest/gtest.h>

#include <string>

#include "tests/tools/program.h"

namespace sluice {
namespace {

TEST(Bench, printsThePapersTableForEachVolume) {
  const Program program;
  const auto report = program.json(
      "bench algorithms synth:shells,dims=40x40x40@100 synth:slab,dims=40x40x40 "
      "--threshold 20 --size 32 --frames 1 --page 16x16x4 --block 16 --pages 64");
  ASSERT_EQ(report["rows"].size(), 2U);
  for (const auto& row : report["rows"]) {
    EXPECT_GT(row["empty_percent"].get<double>(), 0);
    for (const char* key : {"seconds", "chunks", "pages", "binds"})
      for (const char* algorithm : {"conventional", "clipped", "trimmed", "merged"})
        EXPECT_GT(row[key][algorithm].get<double>(), 0) << key << algorithm;
    EXPECT_TRUE(row.contains("saved_percent"));
    EXPECT_TRUE(row.contains("processing_seconds"));
  }
  // A slab of 5 % of the voxels, rounded to planes: 2 of 40.
  EXPECT_DOUBLE_EQ(report["rows"][1]["empty_percent"].get<double>(), 95);
}

TEST(Bench, measuresTheLimitAndARender) {
  const Program program;
  EXPECT_GT(program.json("bench limit --frames 1")["samples_per_second"].get<double>(), 0);
  const auto report = program.json(std::string("bench render ") + kSmall + " --size 48 --frames 2");
  EXPECT_GT(report["frame_seconds"]["median"].get<double>(), 0);
  EXPECT_GE(report["frame_seconds"]["max"], report["frame_seconds"]["min"]);
  EXPECT_GT(report["samples_object"].get<double>(), 0);
  EXPECT_GT(report["share_of_limit"].get<double>(), 0);
}

TEST(Bench, saysWhatItsRowsDoNotShow) {
  const Program program;
  const std::string maximum =
      program.run(std::string("bench quality ") + kSmall + " --size 24 --frames 1 --mode mip")
          .output;
  EXPECT_NE(maximum.find("rows of integrated samples are those of plain ones"), std::string::npos);
  for (const char* bench : {"skipping", "occlusion"}) {
    const CommandResult refused = program.run(std::string("bench ") + bench + " " + kSmall +
                                              "@90 --size 24 --frames 1 --shadows");
    EXPECT_EQ(refused.status, 2);
    EXPECT_NE(refused.output.find("--shadows and --occlusion-light do not follow; leave them out"),
              std::string::npos);
  }
}

TEST(Bench, skippingComparesWholeBlocksWithBoxes) {
  const Program program;
  const auto report =
      program.json(std::string("bench skipping ") + kSmall + "@90 --size 48x48 --frames 1");
  EXPECT_EQ(report["command"], "bench skipping");
  const auto& row = report["rows"][0];
  EXPECT_EQ(row["volume"], kSmall);
  EXPECT_EQ(row["threshold"], 90);
  EXPECT_DOUBLE_EQ(row["speedup"], row["ess_fps"].get<double>() / row["basic_fps"].get<double>());
  EXPECT_EQ(report["mean_speedup"], row["speedup"]);
  EXPECT_LT(row["ess_samples"].get<int64_t>(), row["basic_samples"].get<int64_t>());
}

TEST(Bench, occlusionComparesThePapersFiveWays) {
  const Program program;
  const auto report = program.json(std::string("bench occlusion ") + kSmall +
                                   "@90 --size 96x96 --frames 1 --adapt-frames 2");
  EXPECT_EQ(report["command"], "bench occlusion");
  const auto& row = report["rows"][0];
  const auto& fps = row["fps"];
  for (const char* way : {"basic", "ess", "ess_cc", "ess_m", "ess_c"})
    EXPECT_GT(fps[way].get<double>(), 0) << way;
  EXPECT_DOUBLE_EQ(row["speedup"]["cc"], fps["ess_cc"].get<double>() / fps["ess"].get<double>());
  const auto& samples = row["samples"];
  EXPECT_EQ(samples["ess_m"], samples["ess"]) << "maps alone leave out nothing";
  EXPECT_LE(samples["ess_c"], samples["ess"]);
  EXPECT_LT(samples["ess_cc"], samples["ess_c"]);
  EXPECT_NEAR(row["skipped_percent"].get<double>(),
              100 - 100 * samples["ess_cc"].get<double>() / samples["ess"].get<double>(), 1e-9);
  EXPECT_EQ(report["mean"]["skipped_percent"], row["skipped_percent"]);
  ASSERT_EQ(row["updates"].size(), 4);
  EXPECT_EQ(row["updates"][0]["wanted"].size(), 2);
  EXPECT_EQ(row["updates"][0]["made"].size(), 2);
  EXPECT_EQ(row["updates"][0]["wanted"][0], 3);
}

TEST(Bench, occlusionBeginsWithTheUpdatesThatAreAskedFor) {
  const Program program;
  const auto report =
      program.json(std::string("bench occlusion ") + kSmall +
                   "@90 --size 96x96 --frames 1 --adapt-frames 1 --updates 9 --block 16");
  const auto& row = report["rows"][0];
  EXPECT_EQ(row["map_updates"]["wanted"], 9) << "Li 2003, section 4.4";
  EXPECT_GT(row["map_updates"]["made"], 3);
  EXPECT_LE(row["map_updates"]["made"], 9);
  for (const auto& view : row["updates"]) EXPECT_EQ(view["wanted"][0], 9);
  EXPECT_EQ(program.run(std::string("bench occlusion ") + kSmall + " --updates 0").status, 2);
}

TEST(Bench, aChangedThresholdCopiesWhatItChanges) {
  const Program program;
  const auto report = program.json(
      "bench threshold synth:noise,dims=64x48x40,share=0.3 --threshold 60 --size 40x40 --changes 3 "
      "--block 16 --gl osmesa");
  EXPECT_EQ(report["bytes_copied"], report["bytes_changed"]);
  EXPECT_GT(report["bytes_copied"].get<int64_t>(), 0);
  for (const char* kind : {"small", "large", "walk", "band"})
    for (const auto& measured : {report["change_seconds"][kind], report["out_of_core"][kind]}) {
      EXPECT_GT(measured["p50"].get<double>(), 0);
      EXPECT_LE(measured["p50"].get<double>(), measured["p95"].get<double>());
      EXPECT_LE(measured["p95"].get<double>(), measured["max"].get<double>());
      EXPECT_GT(measured["again_p50"].get<double>(), 0);
    }
  for (const char* name :
       {"steady_frame_seconds", "classify_seconds", "plan_seconds", "rebuild_seconds"})
    EXPECT_GT(report[name].get<double>(), 0) << name;
}

TEST(Bench, packingNamesEachCodec) {
  const Program program;
  const auto report = program.json("bench packing synth:shells,dims=80x64x64");
  EXPECT_GE(report["rows"].size(), 4U);
  for (const auto& row : report["rows"]) EXPECT_GE(row["ratio"].get<double>(), 1) << row["codec"];
}

}  // namespace
}  // namespace sluice
