#include "src/base/threads/worker_pool.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <functional>
#include <future>
#include <memory>
#include <new>
#include <numeric>
#include <set>
#include <stdexcept>
#include <system_error>

#include "tests/support/failing_memory.h"

namespace sluice {
namespace {

std::vector<int> timesCalled(WorkerPool& pool, int64_t count) {
  // Not atomic: each element is touched by one call, and seen by us after parallelFor returned.
  std::vector<int> calls(static_cast<size_t>(count), 0);
  pool.parallelFor(count, [&](int64_t i) { ++calls[static_cast<size_t>(i)]; });
  return calls;
}

TEST(WorkerPool, callsEachIndexOnce) {
  for (const int threads : {1, 2, 3, 16}) {
    WorkerPool pool(threads);
    EXPECT_EQ(pool.threads(), threads);
    for (const int64_t count : {1, 2, 5, 1000})
      EXPECT_EQ(timesCalled(pool, count), std::vector<int>(static_cast<size_t>(count), 1));
  }
}

TEST(WorkerPool, loopOfNothingCallsNothing) {
  WorkerPool pool(2);
  for (const int64_t count : {0, -1, -1000})
    pool.parallelFor(count, [](int64_t) { ADD_FAILURE() << "called"; });
}

TEST(WorkerPool, zeroMeansOneACore) {
  WorkerPool pool(0);
  EXPECT_EQ(pool.threads(), std::max(1, static_cast<int>(std::thread::hardware_concurrency())));
  EXPECT_EQ(pool.wantedThreads(), pool.threads());
}

TEST(WorkerPool, poolOfOneRunsLoopsOnTheCaller) {
  WorkerPool pool(1);
  const std::thread::id self = std::this_thread::get_id();
  pool.parallelFor(100, [&](int64_t) { EXPECT_EQ(std::this_thread::get_id(), self); });
}

TEST(WorkerPool, loopsRunOnAsManyThreadsAsThePoolHas) {
  constexpr int kThreads = 4;
  WorkerPool pool(kThreads);
  // Each call waits until all four are under way: fewer threads would never get there.
  std::mutex mutex;
  std::condition_variable all_here;
  std::set<std::thread::id> ids;
  pool.parallelFor(kThreads, [&](int64_t) {
    std::unique_lock lock(mutex);
    ids.insert(std::this_thread::get_id());
    all_here.notify_all();
    all_here.wait(lock, [&] { return ids.size() == kThreads; });
  });
  EXPECT_EQ(ids.size(), size_t{kThreads});
}

TEST(WorkerPool, threadsKnowWhichTheyAre) {
  constexpr int kThreads = 4;
  WorkerPool pool(kThreads);
  EXPECT_EQ(pool.self(), 0);
  std::mutex mutex;
  std::condition_variable all_here;
  std::set<int> selves;
  pool.parallelFor(kThreads, [&](int64_t) {
    std::unique_lock lock(mutex);
    selves.insert(pool.self());
    all_here.notify_all();
    all_here.wait(lock, [&] { return selves.size() == kThreads; });
  });
  EXPECT_EQ(selves, (std::set<int>{0, 1, 2, 3}));
}

TEST(WorkerPool, rethrowsTheFailureOnTheCaller) {
  for (const int threads : {1, 2, 8}) {
    WorkerPool pool(threads);
    for (const int64_t bad : {0, 50, 99}) {
      try {
        pool.parallelFor(100, [&](int64_t i) {
          if (i == bad) throw std::runtime_error("index " + std::to_string(i));
        });
        ADD_FAILURE() << "nothing thrown";
      } catch (const std::runtime_error& error) {
        EXPECT_EQ(error.what(), "index " + std::to_string(bad));
      }
    }
  }
}

TEST(WorkerPool, aFailureStopsTheHandingOut) {
  WorkerPool pool(1);
  int64_t calls = 0;
  EXPECT_THROW(pool.parallelFor(1000,
                                [&](int64_t i) {
                                  ++calls;
                                  if (i == 9) throw std::runtime_error("stop");
                                }),
               std::runtime_error);
  EXPECT_EQ(calls, 10);
}

TEST(WorkerPool, noCallIsUnderWayOnceTheFailureIsThrown) {
  WorkerPool pool(8);
  for (int trial = 0; trial < 50; ++trial) {
    std::atomic<int> under_way{0};
    EXPECT_THROW(pool.parallelFor(200,
                                  [&](int64_t i) {
                                    ++under_way;
                                    std::this_thread::yield();
                                    --under_way;
                                    if (i % 7 == 3) throw std::runtime_error("many fail");
                                  }),
                 std::runtime_error);
    EXPECT_EQ(under_way, 0);
  }
}

TEST(WorkerPool, isUsableAfterAFailure) {
  WorkerPool pool(4);
  EXPECT_THROW(pool.parallelFor(10, [](int64_t) { throw 1; }), int);
  EXPECT_EQ(timesCalled(pool, 100), std::vector<int>(100, 1));
}

TEST(WorkerPool, nestedLoopsDoNotDeadlock) {
  for (const int threads : {1, 2, 4}) {
    WorkerPool pool(threads);
    std::atomic<int64_t> sum{0};
    pool.parallelFor(8, [&](int64_t i) {
      pool.parallelFor(8, [&](int64_t j) {
        pool.parallelFor(4, [&](int64_t k) { sum += i * 100 + j * 10 + k; });
      });
    });
    EXPECT_EQ(sum, 28 * 100 * 32 + 28 * 10 * 32 + 6 * 64);
  }
}

TEST(WorkerPool, failureOfANestedLoopReachesTheOuterCaller) {
  WorkerPool pool(3);
  EXPECT_THROW(pool.parallelFor(6,
                                [&](int64_t i) {
                                  pool.parallelFor(6, [i](int64_t j) {
                                    if (i == 4 && j == 2) throw std::out_of_range("inner");
                                  });
                                }),
               std::out_of_range);
}

TEST(WorkerPool, takesLoopsFromManyThreadsAtOnce) {
  WorkerPool pool(3);
  std::vector<std::thread> callers;
  std::atomic<int64_t> sum{0};
  for (int caller = 0; caller < 8; ++caller)
    callers.emplace_back([&] {
      for (int round = 0; round < 20; ++round) pool.parallelFor(50, [&](int64_t i) { sum += i; });
    });
  for (std::thread& caller : callers) caller.join();
  EXPECT_EQ(sum, 8 * 20 * (49 * 50 / 2));
}

TEST(WorkerPool, submittedTasksRunInOrderOnAPoolOfOne) {
  std::vector<int> order;
  {
    WorkerPool pool(1);
    for (int i = 0; i < 100; ++i) pool.submit([&order, i] { order.push_back(i); });
  }
  std::vector<int> expected(100);
  std::iota(expected.begin(), expected.end(), 0);
  EXPECT_EQ(order, expected);
}

TEST(WorkerPool, submittedTasksRunWhileTheCallerDoesSomethingElse) {
  WorkerPool pool(1);
  std::promise<std::thread::id> ran_on;
  pool.submit([&] { ran_on.set_value(std::this_thread::get_id()); });
  EXPECT_NE(ran_on.get_future().get(), std::this_thread::get_id());
}

TEST(WorkerPool, theDestructorRunsWhatIsQueued) {
  std::atomic<int> ran{0};
  {
    WorkerPool pool(4);
    for (int i = 0; i < 500; ++i) pool.submit([&] { ++ran; });
  }
  EXPECT_EQ(ran, 500);
}

TEST(WorkerPool, aTaskMayRunALoop) {
  std::atomic<int> ran{0};
  {
    WorkerPool pool(2);
    for (int i = 0; i < 4; ++i) pool.submit([&] { pool.parallelFor(25, [&](int64_t) { ++ran; }); });
  }
  EXPECT_EQ(ran, 100);
}

// Gives `count` threads, then none.
ThreadStarter starterOf(int count) {
  return [left = count](const std::function<void()>& body) mutable {
    if (left-- <= 0) throw std::system_error(EAGAIN, std::generic_category());
    return startThread(body);
  };
}

TEST(WorkerPool, goesOnWithTheThreadsThatStarted) {
  for (const int started : {0, 1, 3}) {
    WorkerPool pool(16, starterOf(started));
    EXPECT_EQ(pool.threads(), started + 1);
    EXPECT_EQ(pool.wantedThreads(), 16);
    EXPECT_EQ(timesCalled(pool, 1000), std::vector<int>(1000, 1));
  }
}

TEST(WorkerPool, withoutAnyThreadTasksRunWhereTheyAreSubmitted) {
  WorkerPool pool(4, starterOf(0));
  std::thread::id ran_on;
  pool.submit([&] { ran_on = std::this_thread::get_id(); });
  EXPECT_EQ(ran_on, std::this_thread::get_id());
  std::atomic<int> ran{0};
  pool.submit([&] { pool.parallelFor(25, [&](int64_t) { ++ran; }); });
  EXPECT_EQ(ran, 25);
}

// Helpers in the queue refer to the loop's function: it has to live until they have ended.
TEST(WorkerPool, aLoopThatFindsNoMemoryForHelpersGoesOnWithoutThem) {
  WorkerPool pool(4);
  int64_t loops = 0;
  forEachAllocation([&](int64_t n) {
    std::atomic<int> ran{0};
    const auto body = std::make_unique<std::function<void(int64_t)>>([&](int64_t) { ++ran; });
    bool failed = false, threw = false;
    {
      const FailingMemory memory(n);
      try {
        pool.parallelFor(100, *body);
      } catch (const std::bad_alloc&) {
        threw = true;
      }
      failed = memory.failed();
    }
    EXPECT_EQ(ran, threw ? 0 : 100) << n;
    if (!threw) ++loops;
    return failed;
  });
  EXPECT_GT(loops, 1) << "else no helper lacked memory";
}

TEST(WorkerPool, aThreadThatFindsNoMemoryIsOneLess) {
  WorkerPool pool(4, [started = false](const std::function<void()>& body) mutable {
    if (std::exchange(started, true)) throw std::bad_alloc();
    return startThread(body);
  });
  EXPECT_EQ(pool.threads(), 2);
}

}  // namespace
}  // namespace sluice
