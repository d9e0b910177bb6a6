// Messages between ranks, and how all ranks end when one fails.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>

#include "src/base/error.h"
#include "src/parallel/communication/in_process.h"

namespace sluice {
namespace {

using testing::Each;
using testing::HasSubstr;

TEST(Team, everyMessageArrivesWhereItIsSent) {
  for (const int ranks : {1, 2, 5}) {
    const auto ends = runInProcess(ranks, [&](Team& team) {
      ASSERT_EQ(team.ranks(), ranks);
      std::vector<Message> to;
      for (int r = 0; r < ranks; ++r)
        to.push_back(asMessage(std::string(static_cast<size_t>(r), 'x') +
                               fmt::format("from {} to {}", team.rank(), r)));
      const std::vector<Message> from = team.exchange(to);
      for (int r = 0; r < ranks; ++r)
        EXPECT_EQ(asText(from[static_cast<size_t>(r)]),
                  std::string(static_cast<size_t>(team.rank()), 'x') +
                      fmt::format("from {} to {}", r, team.rank()));
      const std::vector<Message> all = team.gather(asMessage(fmt::format("{}", team.rank())));
      EXPECT_EQ(all.size(), team.isFirst() ? static_cast<size_t>(ranks) : 0U);
      EXPECT_EQ(team.fromFirst(team.isFirst() ? "said" : "not"), "said");
      EXPECT_EQ(team.ranksBeside(team.rank() == 0 ? "a" : "b"), team.rank() == 0 ? 1 : ranks - 1);
      team.wait();
    });
    EXPECT_THAT(ends, Each(std::string()));
  }
}

TEST(Team, aFailureEndsAllWithOneLineThatNamesTheRank) {
  const auto ends = runInProcess(4, [](Team& team) {
    team.wait();
    if (team.rank() == 2) fail("step_003.raw: shorter than it says");
    for (int i = 0; i < 3; ++i) team.wait();
  });
  EXPECT_THAT(ends, Each(std::string("rank 2 of 4: step_003.raw: shorter than it says")));
}

TEST(Team, whatAllFailOfIsSaidOnce) {
  const auto ends = runInProcess(3, [](Team&) { fail("bonsai.raw: no such file"); });
  EXPECT_THAT(ends, Each(std::string("bonsai.raw: no such file")));
  const auto two = runInProcess(3, [](Team& team) {
    if (team.rank() > 0) fail("disk {} full", team.rank());
    team.wait();
  });
  EXPECT_THAT(two, Each(std::string("rank 1 of 3: disk 1 full (and 1 more)")));
}

TEST(Team, moreThanARankHasRoomForIsAnErrorOfAll) {
  const auto ends = runInProcess(2, [](Team& team) {
    std::vector<Message> to(2, Message(1000));
    EXPECT_EQ(team.exchange(to, 1000)[0].size(), 1000U);
    team.exchange(to, team.rank() == 1 ? 999 : 5000);
  });
  EXPECT_THAT(ends, Each(HasSubstr("rank 1 of 2: other ranks' parts of the picture take 1000")));
}

TEST(Team, isInterruptedWhileItWaits) {
  StopSource stop;
  const auto ends = runInProcess(
      2,
      [&](Team& team) {
        if (team.isFirst()) {
          stop.requestStop();
          return;
        }
        team.wait();
      },
      stop.token());
  EXPECT_EQ(ends[0], "");
  EXPECT_EQ(ends[1], "interrupted");
}

}  // namespace
}  // namespace sluice
