#include <gtest/gtest.h>

#include "tests/tools/program.h"

namespace sluice {
namespace {

constexpr const char* kMachine = " --page 16x16x4 --block 16 --pages 64 --policy ";

// Design, point 5: the simulated I/O of a turn equals the real one, byte for byte.
TEST(Simulate, theRenderersTraceCostsExactlyWhatTheRendererUploaded) {
  const Program program;
  for (const std::string policy : {"lru", "arc", "sieve", "fifo"}) {
    const CommandResult drawn =
        program.run(std::string("render ") + kSmall + kMachine + policy +
                    " -o t.png --frames 5 --size 32 --trace t.bin --report r.json");
    ASSERT_EQ(drawn.status, 0) << drawn.output;
    const auto report = nlohmann::json::parse(readFile(program.folder / "r.json"));
    const auto rows = program.json("simulate t.bin --sizes 64 --pages 64 --policies " + policy +
                                   " --policy " + policy)["rows"];
    ASSERT_EQ(rows.size(), 1U);
    const auto& cache = report["levels"]["texture_cache"];
    EXPECT_EQ(rows[0]["bytes_moved"], cache["uploaded_bytes"]) << policy;
    EXPECT_GT(rows[0]["bytes_moved"].get<int64_t>(), 0);
    EXPECT_EQ(rows[0]["requests"].get<int64_t>(),
              rows[0]["hits"].get<int64_t>() + rows[0]["misses"].get<int64_t>());
  }
}

TEST(Simulate, aPlannedTurnIsTheTraceOfTheDrawnOne) {
  const Program program;
  const std::string common =
      std::string(kSmall) + kMachine + "lru --frames 4 --azimuth 15 --elevation 25 ";
  ASSERT_EQ(program.run("render " + common + "-o t.png --size 32 --trace drawn.txt").status, 0);
  ASSERT_EQ(
      program.run("simulate " + common + "--sizes 64 --policies lru --export planned.txt").status,
      0);
  EXPECT_EQ(readFile(program.folder / "drawn.txt"), readFile(program.folder / "planned.txt"));
}

TEST(Simulate, writesItsTableAndAReportThatStandsAlone) {
  const Program program;
  ASSERT_EQ(program
                .run(std::string("simulate ") + kSmall + kMachine +
                     "lru --frames 3 --csv t.csv --html r.html --prefetch next-cluster")
                .status,
            0);
  EXPECT_EQ(readFile(program.folder / "t.csv").rfind("policy,pages,requests", 0), 0U);
  const std::string page = readFile(program.folder / "r.html");
  EXPECT_NE(page.find("<svg"), std::string::npos);
  for (const char* outside : {"http://", "https://", "src=", "@import"})
    if (std::string(outside).rfind("http", 0) != 0) {
      EXPECT_EQ(page.find(outside), std::string::npos);
    }
}

TEST(Plan, saysTheChunksAndPagesThatARenderMoves) {
  const Program program;
  const auto plan =
      program.json(std::string("plan ") + kSmall + " --page 16x16x4 --block 16 --pages 4096");
  for (const char* algorithm : {"conventional", "clipped", "trimmed", "merged"}) {
    const CommandResult drawn = program.run(std::string("render ") + kSmall +
                                            " --page 16x16x4 --block 16 --pages 4096 -o a.png" +
                                            " --size 32 --report r.json --algorithm " + algorithm);
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

}  // namespace
}  // namespace sluice
