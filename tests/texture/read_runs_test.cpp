#include "src/texture/read_runs.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <set>

namespace sluice {
namespace {

using Ids = std::vector<int64_t>;

TEST(ReadRuns, blocksOfARowAreOneRun) {
  const auto runs = readRuns(Ids{1, 3, 9, 12, 12}, {}, 10, 100);
  ASSERT_EQ(runs.size(), 2U);
  EXPECT_EQ(runs[0].blocks, (Ids{1, 3, 9}));
  EXPECT_EQ(runs[1].blocks, (Ids{12}));
  EXPECT_EQ(runs[1].from, 3U);
  EXPECT_EQ(runs[1].to, 5U);
}

TEST(ReadRuns, whatIsWantedSoonComesAlongInItsRow) {
  const auto runs = readRuns(Ids{13}, Ids{5, 11, 13, 18, 25}, 10, 100);
  ASSERT_EQ(runs.size(), 1U);
  EXPECT_EQ(runs[0].blocks, (Ids{11, 13, 18}));
}

TEST(ReadRuns, limitsKeepRowsWholeWhereTwoFit) {
  const auto limits = [](size_t level_blocks, int64_t blocks_a_row) {
    const RunLimits l = runLimits(level_blocks, blocks_a_row, 5);
    return std::pair(l.blocks, l.runs);
  };
  EXPECT_EQ(limits(1000, 32), std::pair(size_t{100}, size_t{5})) << "half of it for all";
  EXPECT_EQ(limits(320, 32), std::pair(size_t{32}, size_t{5}));
  EXPECT_EQ(limits(319, 32), std::pair(size_t{32}, size_t{5}));
  EXPECT_EQ(limits(150, 32), std::pair(size_t{32}, size_t{4}));
  EXPECT_EQ(limits(74, 32), std::pair(size_t{32}, size_t{2}));
  EXPECT_EQ(limits(73, 32), std::pair(size_t{7}, size_t{5})) << "too few for two rows";
  EXPECT_EQ(limits(2, 32), std::pair(size_t{1}, size_t{5}));
}

TEST(ReadRuns, eachWantedBlockIsInOneRunAndNoRunIsTooLong) {
  std::mt19937 random(3);
  for (int i = 0; i < 500; ++i) {
    const auto blocks_a_row = static_cast<int64_t>(1 + random() % 12);
    const size_t most = 1 + random() % 6;
    Ids wanted(random() % 30), soon(random() % 30);
    for (Ids* ids : {&wanted, &soon}) {
      for (int64_t& id : *ids) id = static_cast<int64_t>(random() % 60);
      std::sort(ids->begin(), ids->end());
    }
    size_t next = 0;
    std::set<int64_t> read;
    for (const ReadRun& run : readRuns(wanted, soon, blocks_a_row, most)) {
      ASSERT_EQ(run.from, next);
      ASSERT_GT(run.to, run.from);
      next = run.to;
      ASSERT_LE(run.blocks.size(), most);
      ASSERT_EQ(run.blocks.front() / blocks_a_row, run.blocks.back() / blocks_a_row);
      for (size_t at = run.from; at < run.to; ++at)
        ASSERT_TRUE(std::binary_search(run.blocks.begin(), run.blocks.end(), wanted[at]));
      for (const int64_t block : run.blocks) {
        ASSERT_TRUE(read.insert(block).second) << "read twice";
        ASSERT_TRUE(std::binary_search(wanted.begin(), wanted.end(), block) ||
                    std::binary_search(soon.begin(), soon.end(), block));
      }
    }
    ASSERT_EQ(next, wanted.size());
  }
}

}  // namespace
}  // namespace sluice
