// Curves of the miss ratio over the cache's size.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <string>

#include "tests/tools/program.h"
#include "tests/tools/skewed_trace.h"

namespace sluice {
namespace {

TEST(Simulate, curvesAreThoseOfTheRows) {
  const Program program;
  std::ofstream(program.folder / "t.csv") << skewedCsv(3000);
  const auto report = program.json("simulate t.csv --sizes 16,64,200 --policies lru,gdsf");
  ASSERT_EQ(report["curves"].size(), 3U);
  const auto& exact = report["curves"][0];
  EXPECT_EQ(exact["kind"], "exact");
  EXPECT_EQ(exact["stated_error"], 0);
  for (const auto& row : report["rows"]) {
    const size_t which = row["policy"] == "lru" ? 1 : 2;
    const auto& curve = report["curves"][which];
    EXPECT_EQ(curve["policy"], row["policy"]);
    const auto& pages = curve["pages"];
    const auto at = std::find(pages.begin(), pages.end(), row["pages"]) - pages.begin();
    EXPECT_EQ(curve["miss_ratio"][static_cast<size_t>(at)], row["miss_ratio"]);
  }
}

// The estimate of every tenth chunk against the exact ratios at the same sizes.
TEST(Simulate, aSampledCurveKeepsWithinItsError) {
  const Program program;
  std::ofstream(program.folder / "t.csv") << skewedCsv(60'000);
  const auto report = program.json("simulate t.csv --sample 0.1");
  EXPECT_TRUE(report["rows"].empty());
  ASSERT_EQ(report["curves"].size(), 1U);
  const auto& sampled = report["curves"][0];
  EXPECT_EQ(sampled["kind"], "sampled");
  EXPECT_NEAR(sampled["sampling_rate"].get<double>(), 0.1, 1e-6);
  EXPECT_NEAR(sampled["sampled_chunks"].get<double>(), 200, 60);
  const double error = sampled["stated_error"].get<double>();
  EXPECT_LT(error, 0.2);
  const auto rows = program.json(
      "simulate t.csv --policies lru --sizes 50,100,200,400,600,800,1200,1600,1900")["rows"];
  double off = 0;
  for (const auto& row : rows) {
    double ratio = 1;
    for (size_t i = 0; i < sampled["pages"].size() && sampled["pages"][i] <= row["pages"]; ++i)
      ratio = sampled["miss_ratio"][i].get<double>();
    off += std::abs(ratio - row["miss_ratio"].get<double>()) / static_cast<double>(rows.size());
  }
  EXPECT_LT(off, error);
  const std::string table = program.run("simulate t.csv --sample 0.1 --sizes 64").output;
  EXPECT_NE(table.find("Expected error: at most 0."), std::string::npos) << table;
  EXPECT_NE(program.run("simulate t.csv --sample 0.00001 2>&1").output.find("took none"),
            std::string::npos);
}

}  // namespace
}  // namespace sluice
