#include "src/base/threads/single_flight_cache.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <future>
#include <list>
#include <map>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

#include "tests/support/failing_memory.h"

namespace sluice {
namespace {

using testing::IsEmpty;
using Cache = SingleFlightCache<int, const int>;
constexpr uint64_t kBytes = 10;

Cache::Value get(Cache& cache, int key) {
  return cache.get(key, kBytes, [&] { return Cache::Loaded{std::make_shared<int>(key), kBytes}; });
}

TEST(SingleFlightCache, oneThreadLoadsAndTheOthersWait) {
  Cache cache(100, Held::kStays);
  std::promise<void> begun, go_on;
  std::atomic<int> loads{0};
  const auto load = [&] {
    ++loads;
    begun.set_value();
    go_on.get_future().wait();
    return Cache::Loaded{std::make_shared<int>(7), kBytes};
  };
  auto first = std::async(std::launch::async, [&] { return cache.get(1, kBytes, load); });
  begun.get_future().wait();
  std::vector<std::future<Cache::Value>> others;
  for (int i = 0; i < 3; ++i)
    others.push_back(std::async(std::launch::async, [&] { return cache.get(1, kBytes, load); }));
  while (cache.counters().coalesced < 3) std::this_thread::yield();
  EXPECT_EQ(*get(cache, 2), 2);  // others go on meanwhile
  go_on.set_value();
  const Cache::Value value = first.get();
  for (auto& other : others) EXPECT_EQ(other.get(), value);
  EXPECT_EQ(loads, 1);
  const CacheCounters c = cache.counters();
  EXPECT_EQ(c.requests, 5U);
  EXPECT_EQ(c.misses, 5U);
  EXPECT_EQ(c.loads, 2U);
  EXPECT_EQ(c.coalesced, 3U);
  EXPECT_THAT(c.brokenIdentity(), IsEmpty());
}

TEST(SingleFlightCache, aThreadMayLeaveWhatAnotherOneLoads) {
  Cache cache(100, Held::kStays);
  std::promise<void> begun, go_on;
  auto first = std::async(std::launch::async, [&] {
    return cache.get(1, kBytes, [&] {
      begun.set_value();
      go_on.get_future().wait();
      return Cache::Loaded{std::make_shared<int>(1), kBytes};
    });
  });
  begun.get_future().wait();
  const auto leave = [&](int key) {
    return cache.get(
        key, kBytes,
        [&] {
          return Cache::Loaded{std::make_shared<int>(key), kBytes};
        },
        IfLoading::kLeave);
  };
  EXPECT_EQ(leave(1), nullptr);
  EXPECT_EQ(*leave(2), 2) << "nobody loads it";
  go_on.set_value();
  first.get();
  EXPECT_EQ(*leave(1), 1);
  const CacheCounters c = cache.counters();
  EXPECT_EQ(c.requests, 3U);
  EXPECT_EQ(c.hits, 1U);
  EXPECT_EQ(c.coalesced, 0U);
  EXPECT_THAT(c.brokenIdentity(), IsEmpty());
}

// A run that goes on for ever does not grow: only the last keys are known again.
TEST(SingleFlightCache, remembersAsManyKeysAsItIsToldAtLeast) {
  constexpr int kRemembered = 8;
  Cache cache(kBytes, Held::kStays, kRemembered);  // room for one
  for (int key = 0; key < 5 * kRemembered; ++key) get(cache, key);
  EXPECT_EQ(cache.counters().redundant_loads, 0U);
  for (int key = 5 * kRemembered - 2; key >= 4 * kRemembered; --key) get(cache, key);
  EXPECT_EQ(cache.counters().redundant_loads, static_cast<uint64_t>(kRemembered) - 1);
  get(cache, 0);
  EXPECT_EQ(cache.counters().redundant_loads, static_cast<uint64_t>(kRemembered) - 1)
      << "too long ago";
  EXPECT_THAT(cache.counters().brokenIdentity(), IsEmpty());
}

TEST(SingleFlightCache, aFailureReachesAllWhoWaitAndIsNotKept) {
#ifdef __SANITIZE_THREAD__
  GTEST_SKIP() << "ThreadSanitizer does not see how the C++ library counts users of an exception";
#endif
  Cache cache(100, Held::kStays);
  std::promise<void> begun, go_on;
  const auto fail = [&]() -> Cache::Loaded {
    begun.set_value();
    go_on.get_future().wait();
    throw std::runtime_error("as asked");
  };
  const auto attempt = [&] {
    try {
      return std::to_string(*cache.get(1, kBytes, fail));
    } catch (const std::runtime_error& error) {
      return std::string(error.what());
    }
  };
  auto first = std::async(std::launch::async, attempt);
  begun.get_future().wait();
  auto second = std::async(std::launch::async, attempt);
  while (cache.counters().coalesced < 1) std::this_thread::yield();
  go_on.set_value();
  EXPECT_EQ(first.get(), "as asked");
  EXPECT_EQ(second.get(), "as asked");
  EXPECT_EQ(*get(cache, 1), 1);
  const CacheCounters c = cache.counters();
  EXPECT_EQ(c.failures, 1U);
  EXPECT_EQ(c.loads, 1U);
  EXPECT_EQ(c.redundant_loads, 0U);  // it had never been resident
  EXPECT_THAT(c.brokenIdentity(), IsEmpty());
}

TEST(SingleFlightCache, evictsLikeAPlainListThatIsKeptByLastUse) {
  std::mt19937 random(3);
  for (const size_t room : {1, 2, 5}) {
    Cache cache(room * kBytes, Held::kStays);
    std::list<int> kept;
    std::map<int, int> seen;
    uint64_t hits = 0, redundant = 0, evictions = 0;
    for (int request = 0; request < 3000; ++request) {
      const int key = static_cast<int>(random() % 9);
      EXPECT_EQ(*get(cache, key), key);
      const auto found = std::find(kept.begin(), kept.end(), key);
      if (found != kept.end()) {
        ++hits;
        kept.erase(found);
      } else {
        redundant += seen[key]++ > 0 ? 1 : 0;
        if (kept.size() == room) ++evictions, kept.pop_back();
      }
      kept.push_front(key);
    }
    const CacheCounters c = cache.counters();
    EXPECT_EQ(c.requests, 3000U);
    EXPECT_EQ(c.hits, hits);
    EXPECT_EQ(c.redundant_loads, redundant);
    EXPECT_EQ(c.evictions, evictions);
    EXPECT_EQ(c.peak_bytes, room * kBytes);
    EXPECT_THAT(c.brokenIdentity(), IsEmpty());
  }
}

TEST(SingleFlightCache, whatIsHeldStaysOrMayLeaveAsItsOwnerSays) {
  Cache stays(2 * kBytes, Held::kStays), leaves(2 * kBytes, Held::kMayLeave);
  for (Cache* cache : {&stays, &leaves}) {
    const Cache::Value held = get(*cache, 1);
    get(*cache, 2);
    get(*cache, 3);
    const uint64_t hits = cache->counters().hits;
    EXPECT_EQ(*get(*cache, 1), 1);
    EXPECT_EQ(cache->counters().hits - hits, cache == &stays ? 1U : 0U);
    EXPECT_EQ(*held, 1);
  }
}

TEST(SingleFlightCache, theBudgetGivesWayToWhatIsHeldAndComesBack) {
  Cache cache(kBytes, Held::kStays);
  std::vector<Cache::Value> held;
  for (int key = 0; key < 4; ++key) held.push_back(get(cache, key));
  EXPECT_EQ(cache.counters().current_bytes, 4 * kBytes);
  held.clear();
  get(cache, 4);
  EXPECT_EQ(cache.counters().current_bytes, kBytes);
  cache.setBudget(0);
  EXPECT_EQ(cache.counters().current_bytes, 0U);
}

TEST(SingleFlightCache, whatIsNotKeptIsForThoseWhoWaitAlone) {
  Cache cache(kBytes, Held::kMayLeave);
  const auto tooLarge = [] { return Cache::Loaded{std::make_shared<int>(5), 99, false}; };
  EXPECT_EQ(*cache.get(1, 0, tooLarge), 5);
  EXPECT_EQ(*cache.get(1, 0, tooLarge), 5);
  const CacheCounters c = cache.counters();
  EXPECT_EQ(c.misses, 2U);
  EXPECT_EQ(c.failures, 2U);
  EXPECT_EQ(c.peak_bytes, 0U);
  EXPECT_THAT(c.brokenIdentity(), IsEmpty());
}

TEST(SingleFlightCache, whereMemoryRunsOutNothingIsLeftHalfDone) {
  forEachAllocation([](int64_t n) {
    Cache cache(2 * kBytes, Held::kStays);
    get(cache, 1);
    bool failed = false;
    {
      const FailingMemory memory(n);
      try {
        get(cache, 1);
        get(cache, 2);
        get(cache, 3);
      } catch (const std::bad_alloc&) {
      }
      failed = memory.failed();
    }
    EXPECT_THAT(cache.counters().brokenIdentity(), IsEmpty());
    for (const int key : {1, 2, 3}) EXPECT_EQ(*get(cache, key), key);  // would wait for ever
    EXPECT_THAT(cache.counters().brokenIdentity(), IsEmpty());
    return failed;
  });
}

}  // namespace
}  // namespace sluice
