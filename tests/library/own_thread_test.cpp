#include "src/library/own_thread.h"

#include <gtest/gtest.h>

#include <set>
#include <stdexcept>
#include <thread>
#include <vector>

#include "src/base/error.h"

namespace sluice {
namespace {

TEST(OwnThread, runsEveryCallOnOneThreadThatIsNotTheCallers) {
  OwnThread own;
  std::set<std::thread::id> seen;
  for (int i = 0; i < 3; ++i) own.run([&] { seen.insert(std::this_thread::get_id()); });
  EXPECT_EQ(seen.size(), 1U);
  EXPECT_FALSE(seen.contains(std::this_thread::get_id()));
}

TEST(OwnThread, throwsWhatTheCallThrowsAndGoesOn) {
  OwnThread own;
  EXPECT_THROW(own.run([] { throw std::out_of_range("no"); }), std::out_of_range);
  int calls = 0;
  own.run([&] { ++calls; });
  EXPECT_EQ(calls, 1);
}

TEST(OwnThread, callsFromWithinAreRefusedInsteadOfWaitingForThemselves) {
  OwnThread own;
  EXPECT_THROW(own.run([&] { own.run([] {}); }), Error);
  own.run([] {});
}

TEST(OwnThread, callsOfSeveralThreadsTakeTurns) {
  OwnThread own;
  int inside = 0, most = 0, calls = 0;
  std::vector<std::jthread> threads;
  for (int t = 0; t < 4; ++t)
    threads.emplace_back([&] {
      for (int i = 0; i < 200; ++i)
        own.run([&] {
          most = std::max(most, ++inside);
          ++calls;
          --inside;
        });
    });
  threads.clear();
  EXPECT_EQ(most, 1);
  EXPECT_EQ(calls, 800);
}

}  // namespace
}  // namespace sluice
