#include "src/base/threads/progress_meter.h"

#include <gtest/gtest.h>

#include <atomic>
#include <stdexcept>
#include <thread>
#include <utility>
#include <vector>

namespace sluice {
namespace {

TEST(ProgressMeter, tellsWhatIsDoneAndWhatIsToCome) {
  std::vector<std::pair<uint64_t, uint64_t>> told;
  ProgressMeter progress([&](uint64_t done, uint64_t total) { told.emplace_back(done, total); }, 8);
  progress.add(3);
  progress.expect(2);
  progress.add(7);
  EXPECT_EQ(told, (std::vector<std::pair<uint64_t, uint64_t>>{{3, 8}, {10, 10}}));
}

TEST(ProgressMeter, countsWhereNobodyWatches) {
  ProgressMeter nobody, null{ProgressWatch()};
  nobody.add(1);
  null.add(1);
}

TEST(ProgressMeter, tellsOneThreadAtATimeAndTheWholeInTheEnd) {
  uint64_t last = 0, last_total = 0;
  std::atomic<int> inside = 0;
  bool met = false;
  ProgressMeter progress([&](uint64_t done, uint64_t total) {
    met = met || ++inside > 1;
    EXPECT_GE(done, last);
    last = done;
    last_total = total;
    --inside;
  });
  std::vector<std::thread> threads;
  for (int t = 0; t < 8; ++t)
    threads.emplace_back([&] {
      for (int i = 0; i < 1000; ++i) {
        progress.expect(1);
        progress.add(1);
      }
    });
  for (std::thread& thread : threads) thread.join();
  EXPECT_FALSE(met);
  EXPECT_EQ(last, 8000U);
  EXPECT_EQ(last_total, 8000U);
}

TEST(ProgressMeter, whatTheWatcherThrowsEndsTheWork) {
  ProgressMeter progress([](uint64_t, uint64_t) { throw std::runtime_error("enough"); });
  EXPECT_THROW(progress.add(1), std::runtime_error);
  EXPECT_THROW(progress.add(1), std::runtime_error) << "the lock was given back";
}

}  // namespace
}  // namespace sluice
