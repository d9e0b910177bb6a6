#include "io/zarr/reading/zarr_chunk_cache.h"

#include <gtest/gtest.h>

#include <map>
#include <random>
#include <thread>
#include <vector>

#include "src/base/error.h"

namespace sluice {
namespace {

constexpr uint64_t kChunk = 1000;

// Decodes a chunk into its number, and counts for itself.
struct Decoder {
  ZarrChunkCache::Chunk operator()(int64_t chunk, ChunkMemory& memory) {
    {
      const std::lock_guard lock(mutex);
      ++decoded[chunk];
      EXPECT_EQ(++under_way[chunk], 1) << "two threads decode " << chunk;
    }
    const CountedBytes stored(kChunk, memory);
    std::this_thread::yield();
    auto bytes = std::make_shared<CountedBytes>(kChunk, memory);
    bytes->span()[0] = static_cast<std::byte>(chunk);
    const std::lock_guard lock(mutex);
    --under_way[chunk];
    if (chunk == failing) throw Error("damaged");
    return bytes;
  }
  std::mutex mutex;
  std::map<int64_t, int> decoded, under_way;  // guarded by mutex
  int64_t failing = -1;
};

// A cache of one array.
struct OneArray : ZarrChunkCache {
  OneArray(uint64_t budget_bytes, Decoder& decoder) : ZarrChunkCache(budget_bytes) {
    addArray(kChunk, std::ref(decoder));
  }
  Chunk get(int64_t chunk) { return ZarrChunkCache::get({0, chunk}); }
};

TEST(ZarrChunkCache, keepsWhatWasUsedLast) {
  Decoder decoder;
  OneArray cache(4 * kChunk, decoder);
  // Room for two in addition to the one that is decoded, which takes two.
  for (const int64_t chunk : {1, 2, 1, 3, 1, 4, 1, 2}) cache.get(chunk);
  EXPECT_EQ(decoder.decoded[1], 1);
  EXPECT_EQ(decoder.decoded[2], 2);
  EXPECT_LE(cache.held().peak(), 4 * kChunk);
}

TEST(ZarrChunkCache, aFailureReachesTheCallerAndIsForgotten) {
  Decoder decoder;
  decoder.failing = 5;
  OneArray cache(4 * kChunk, decoder);
  EXPECT_THROW(cache.get(5), Error);
  EXPECT_THROW(cache.get(5), Error);
  EXPECT_LE(cache.held().now(), 2 * kChunk);  // kept for the next
  decoder.failing = -1;
  EXPECT_EQ(cache.get(5)->span()[0], std::byte{5});
}

// A chunk of one byte takes hundreds besides: their number is bounded by the budget, too.
TEST(ZarrChunkCache, tinyChunksCountWithWhatKeepsThem) {
  constexpr uint64_t kBudget = 64 << 10;
  int decoded = 0;
  ZarrChunkCache cache(kBudget);
  cache.addArray(1, [&](int64_t, ChunkMemory& memory) {
    ++decoded;
    return std::make_shared<CountedBytes>(1, memory);
  });
  for (int64_t chunk = 0; chunk < 10'000; ++chunk) cache.get({0, chunk});
  EXPECT_EQ(decoded, 10'000);
  for (int64_t chunk = 9'999; chunk >= 0; --chunk) cache.get({0, chunk});
  EXPECT_GE(decoded, 20'000 - static_cast<int>(kBudget) / 512);
  EXPECT_LT(decoded, 20'000);
}

TEST(ZarrChunkCache, aChunkInUseStays) {
  Decoder decoder;
  OneArray cache(0, decoder);
  const auto kept = cache.get(7);
  for (int64_t chunk = 8; chunk < 20; ++chunk) cache.get(chunk);
  EXPECT_EQ(kept->span()[0], std::byte{7});
  EXPECT_EQ(cache.held().now(), 2 * kChunk);  // it and the last one
}

// Levels of a store are not used evenly: the one in use may have the whole budget.
TEST(ZarrChunkCache, arraysShareTheBudgetAndNoChunks) {
  Decoder first, second;
  ZarrChunkCache cache(8 * kChunk);
  const int a = cache.addArray(kChunk, std::ref(first)),
            b = cache.addArray(kChunk, std::ref(second));
  for (int turn = 0; turn < 2; ++turn)
    for (int64_t chunk = 0; chunk < 6; ++chunk) cache.get({a, chunk});
  for (const auto& [chunk, times] : first.decoded) EXPECT_EQ(times, 1) << chunk;
  for (int64_t chunk = 0; chunk < 6; ++chunk) cache.get({b, chunk});
  EXPECT_EQ(second.decoded.size(), 6U);
  cache.get({a, 0});
  EXPECT_EQ(first.decoded[0], 2) << "the other array's chunks were used later";
  EXPECT_LE(cache.held().peak(), 8 * kChunk);
}

TEST(ZarrChunkCache, threadsShareOneDecodingWithinTheBudget) {
  constexpr int kThreads = 8;
  for (const uint64_t budget : {uint64_t{0}, 10 * kChunk, 40 * kChunk}) {
    Decoder decoder;
    OneArray cache(budget, decoder);
    {
      std::vector<std::jthread> threads;
      for (unsigned seed = 0; seed < kThreads; ++seed)
        threads.emplace_back([&cache, seed] {
          std::mt19937 random(seed);
          for (int i = 0; i < 300; ++i) {
            const auto chunk = static_cast<int64_t>(random() % 30);
            ASSERT_EQ(cache.get(chunk)->span()[0], static_cast<std::byte>(chunk));
          }
        });
    }
    EXPECT_LE(cache.held().peak(), std::max(budget, 2 * kThreads * kChunk) + kThreads * kChunk);
  }
}

}  // namespace
}  // namespace sluice
