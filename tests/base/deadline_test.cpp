#include "src/base/threads/deadline.h"

#include <gtest/gtest.h>

#include <thread>

namespace sluice {
namespace {

using Clock = std::chrono::steady_clock;

void waitFor(const StopToken& token) {
  while (!token.isStopRequested()) std::this_thread::yield();
}

TEST(Deadline, theTokenStopsWhenTheTimeIsOver) {
  const auto until = Clock::now() + std::chrono::milliseconds(20);
  const Deadline deadline(until, {});
  const StopToken token = deadline.token();
  waitFor(token);
  EXPECT_GE(Clock::now(), until);
  EXPECT_TRUE(deadline.isOver());
  EXPECT_FALSE(deadline.isStopped());
  EXPECT_EQ(deadline.secondsLeft(), 0.0);
}

TEST(Deadline, theTokenFollowsAnotherOne) {
  StopSource source;
  const Deadline deadline(Clock::now() + std::chrono::hours(1), source.token());
  const StopToken token = deadline.token();
  EXPECT_FALSE(token.isStopRequested());
  source.requestStop();
  waitFor(token);
  EXPECT_FALSE(deadline.isOver());
  EXPECT_TRUE(deadline.isStopped());
  EXPECT_GT(*deadline.secondsLeft(), 0.0);
}

TEST(Deadline, withoutALimitTheTokenIsTheOther) {
  StopSource source;
  const Deadline deadline(std::nullopt, source.token());
  EXPECT_FALSE(deadline.token().isStopRequested());
  EXPECT_FALSE(deadline.isOver());
  EXPECT_EQ(deadline.secondsLeft(), std::nullopt);
  source.requestStop();
  EXPECT_TRUE(deadline.token().isStopRequested());
}

TEST(Deadline, anEarlyEndWaitsForNothing) {
  StopToken token;
  {
    const Deadline deadline(Clock::now() + std::chrono::hours(1), {});
    token = deadline.token();
  }
  EXPECT_FALSE(token.isStopRequested());
}

}  // namespace
}  // namespace sluice
