#include "src/base/threads/stop_token.h"

#include <gtest/gtest.h>

#include <thread>

namespace sluice {
namespace {

TEST(StopToken, withoutASourceNeverStops) {
  const StopToken token;
  EXPECT_FALSE(token.isStopRequested());
  token.throwIfStopped();
}

TEST(StopToken, copiesStopWithTheirSource) {
  StopSource source;
  const StopToken token = source.token();
  const StopToken copy = token;
  token.throwIfStopped();
  source.requestStop();
  EXPECT_TRUE(token.isStopRequested());
  EXPECT_THROW(copy.throwIfStopped(), Interrupted);
  EXPECT_TRUE(source.token().isStopRequested()) << "those made later too";
}

TEST(StopToken, outlivesItsSource) {
  StopToken token;
  {
    StopSource source;
    token = source.token();
    source.requestStop();
  }
  EXPECT_TRUE(token.isStopRequested());
}

TEST(StopToken, followsAFlagOfSomeoneElse) {
  std::atomic<bool> flag{false};
  const StopToken token(flag);
  EXPECT_FALSE(token.isStopRequested());
  flag = true;
  EXPECT_TRUE(token.isStopRequested());
}

TEST(StopToken, endsALoopOnAnotherThread) {
  StopSource source;
  std::atomic<bool> has_begun{false}, has_ended{false};
  std::thread worker([&, stop = source.token()] {
    try {
      for (;;) {
        stop.throwIfStopped();
        has_begun = true;
      }
    } catch (const Interrupted&) {
      has_ended = true;
    }
  });
  while (!has_begun) std::this_thread::yield();
  source.requestStop();
  worker.join();
  EXPECT_TRUE(has_ended);
}

}  // namespace
}  // namespace sluice
