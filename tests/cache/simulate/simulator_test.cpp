#include "cache/simulate/simulator.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "cache/model/texture_cache.h"
#include "cache/policies/random.h"
#include "cache/simulate/bench_simulate.h"
#include "cache/simulate/lru_replay.h"

namespace sluice::simulator_test {
namespace {

// Chunks of 1 to `heaviest` pages, most of the requests to few of them, a cluster each 8 requests.
Trace randomTrace(uint64_t seed, size_t requests, uint32_t chunks, uint32_t heaviest) {
  Random random(seed);
  Trace trace;
  for (size_t i = 0; i < requests; ++i) {
    TraceRecord r;
    r.chunk = 1000 + (random.below(2) == 0 ? random.below(1 + chunks / 8) : random.below(chunks));
    r.pages = static_cast<uint32_t>(1 + mixBits(r.chunk) % heaviest);
    r.cluster = static_cast<uint32_t>(i / 8 % 10);
    r.frame = static_cast<uint32_t>(i / 80);
    r.bytes.moved = r.pages * trace.page_bytes;
    r.bytes.needed = r.bytes.moved / 2;
    r.bytes.extended = r.bytes.moved / 8;
    r.bytes.empty = r.bytes.moved / 16;
    trace.records.push_back(r);
  }
  return trace;
}

TEST(Simulator, identitiesHoldForEveryPolicyAndSize) {
  const Trace trace = randomTrace(3, 2000, 80, 7);
  const std::vector<uint64_t> sizes{1, 5, 16, 64, 150, 1000};
  const PreparedTrace chunks = prepare(trace);
  for (const PreparedTrace& prepared : {chunks, splitIntoPages(chunks)}) {
    for (const SimulationRow& row : simulateTable(prepared, allPolicies(), sizes, {})) {
      EXPECT_EQ(brokenIdentity(row), "") << name(row.policy) << ' ' << row.pages;
      if (row.pages == 1000) {
        // Everything fits: each chunk is loaded once, and the costs are its bytes.
        EXPECT_EQ(row.misses, prepared.distinct_pages);
        EXPECT_EQ(row.bytes.moved, prepared.distinct_pages * 4096);
        EXPECT_EQ(row.bytes.needed, prepared.distinct_pages * 2048);
        EXPECT_EQ(row.bytes.rounding(), prepared.distinct_pages * (4096 - 2048 - 512 - 256));
        EXPECT_EQ(row.capacity, 0);
      }
    }
  }
}

TEST(Simulator, beladyIsNeverBeatenOnSinglePages) {
  for (uint64_t seed = 1; seed <= 5; ++seed) {
    const PreparedTrace trace = prepare(randomTrace(seed, 1500, 60, 1));
    std::vector<uint64_t> sizes;
    for (uint64_t pages = 1; pages <= 61; ++pages) sizes.push_back(pages);
    uint64_t best = 0;
    for (const uint64_t pages : sizes) {
      best = simulate(trace, {PolicyKind::kBelady, pages}).misses;
      EXPECT_EQ(simulate(trace, {PolicyKind::kBeladyPages, pages}).misses, best);
      for (const PolicyKind kind : onlinePolicies())
        EXPECT_GE(simulate(trace, {kind, pages}).misses, best) << name(kind) << ' ' << pages;
    }
    EXPECT_EQ(best, trace.distinct_pages);
  }
}

TEST(Simulator, beladyByPageIsNeverBeatenOnChunksOfAnySize) {
  for (uint64_t seed = 1; seed <= 4; ++seed) {
    const PreparedTrace trace = prepare(randomTrace(seed, 1500, 60, 12));
    for (uint64_t pages = 1; pages <= 400; pages += 9) {
      const SimulationRow best = simulate(trace, {PolicyKind::kBeladyPages, pages});
      for (const PolicyKind kind : allPolicies()) {
        const SimulationRow row = simulate(trace, {kind, pages});
        EXPECT_GE(row.misses, best.misses) << name(kind) << ' ' << pages;
        EXPECT_GE(row.bytes.moved, best.bytes.moved) << name(kind) << ' ' << pages;
      }
    }
  }
}

// The least number of misses by trying every choice of victims, for unit pages.
uint64_t bruteForceMisses(const std::vector<Key>& keys, size_t at, std::vector<Key> cache,
                          size_t capacity) {
  uint64_t misses = 0;
  for (; at < keys.size(); ++at) {
    if (std::find(cache.begin(), cache.end(), keys[at]) != cache.end()) continue;
    ++misses;
    if (cache.size() < capacity) {
      cache.push_back(keys[at]);
      continue;
    }
    uint64_t best = UINT64_MAX;
    for (Key& victim : cache) {
      const Key kept = std::exchange(victim, keys[at]);
      best = std::min(best, bruteForceMisses(keys, at + 1, cache, capacity));
      victim = kept;
    }
    return misses + best;
  }
  return misses;
}

TEST(Simulator, beladyIsAsGoodAsTheBestOfAllChoices) {
  for (uint64_t seed = 0; seed < 20; ++seed) {
    Random random(seed);
    std::vector<Key> keys(14);
    for (Key& key : keys) key = random.below(6);
    const PreparedTrace trace = prepareUnit(keys);
    for (const uint64_t pages : {2, 3})
      EXPECT_EQ(simulate(trace, {PolicyKind::kBelady, pages}).misses,
                bruteForceMisses(keys, 0, {}, pages));
  }
}

TEST(Simulator, cyclicScanHitsNothingUnderLruUntilItFits) {
  std::vector<Key> keys;
  for (int round = 0; round < 10; ++round) {
    for (Key key = 0; key < 20; ++key) keys.push_back(key);
  }
  const PreparedTrace trace = prepareUnit(keys);
  for (uint64_t pages = 1; pages < 20; ++pages) {
    EXPECT_EQ(simulate(trace, {PolicyKind::kLru, pages}).hits, 0u);
    EXPECT_EQ(simulate(trace, {PolicyKind::kFifo, pages}).hits, 0u);
    // The optimum keeps pages - 1 of the 19 others each 19 requests: closed form for pages = 19.
    const uint64_t best = simulate(trace, {PolicyKind::kBelady, pages}).misses;
    if (pages == 19) {
      EXPECT_EQ(best, 20u + 9);
    }
  }
  EXPECT_EQ(simulate(trace, {PolicyKind::kLru, 20}).misses, 20u);
}

TEST(Simulator, logAndListAreTheSameLru) {
  for (const uint32_t heaviest : {1u, 6u}) {
    const PreparedTrace trace = prepare(randomTrace(9, 30000, 500, heaviest));
    for (const uint64_t pages : {1, 3, 40, 200, 1200, 4000}) {
      LruReplay log(trace, pages);
      const auto list = makePolicy(PolicyKind::kLru, pages);
      std::vector<Key> evicted;
      for (const Key key : trace.keys) {
        ASSERT_EQ(log.request(key), list->request(key, trace.weightOf(key), evicted));
        ASSERT_EQ(log.evictions(), evicted.size());
      }
    }
  }
}

TEST(Simulator, replaysWhatTheTextureCacheDecided) {
  // The model that decides and the simulator that replays its trace count the same.
  const Trace trace = randomTrace(21, 4000, 60, 5);
  for (const PolicyKind kind : onlinePolicies()) {
    TextureCache cache(64, trace.page_bytes, makePolicy(kind, 64, 1));
    const TraceRecord* last = nullptr;
    for (const TraceRecord& r : trace.records) {
      if (last != nullptr && (last->cluster != r.cluster || last->frame != r.frame))
        cache.unpinAll();
      cache.request(r.chunk, r.pages, r.bytes.moved);
      cache.pin(r.chunk);
      last = &r;
    }
    SimulationConfig config{kind, 64};
    config.pin_clusters = true;
    const SimulationRow row = simulate(prepare(trace), config);
    EXPECT_EQ(row.bytes.moved, cache.counters().uploaded_bytes) << name(kind);
    EXPECT_EQ(row.pages_loaded, cache.pagesLoaded());
    EXPECT_EQ(row.chunks.requests, cache.counters().requests);
    EXPECT_EQ(row.chunks.hits, cache.counters().hits);
    EXPECT_EQ(row.chunks.evictions, cache.counters().evictions);
    EXPECT_EQ(row.chunks.redundant_loads, cache.counters().redundant_loads);
    EXPECT_EQ(row.chunks.failures, cache.counters().failures);
  }
}

TEST(Simulator, splitsMissesByClass) {
  // A B C A B C with two pages: LRU misses all six, three of them first touches. The optimum misses
  // four: B goes for C, A hits, C goes for B, C... so two fewer than LRU are negative conflicts.
  const PreparedTrace trace = prepareUnit({0, 1, 2, 0, 1, 2});
  const SimulationRow lru = simulate(trace, {PolicyKind::kLru, 2});
  EXPECT_EQ(lru.misses, 6u);
  EXPECT_EQ(lru.compulsory, 3);
  EXPECT_EQ(lru.capacity, 3);
  EXPECT_EQ(lru.conflict, 0);
  const SimulationRow best = simulate(trace, {PolicyKind::kBelady, 2});
  EXPECT_EQ(best.misses, 4u);
  EXPECT_EQ(best.conflict, -2);
}

TEST(Simulator, costsAddUpInTheModel) {
  const PreparedTrace trace = prepareUnit({0, 1, 0, 1});
  SimulationConfig config{PolicyKind::kLru, 2};
  config.costs = {4096.0, 0.5, 0.25};  // a page takes a second
  // Two pages moved, two of them overhead, four binds.
  EXPECT_DOUBLE_EQ(simulate(trace, config).modelled_seconds, 2 + 2 * 0.5 + 4 * 0.25);
}

TEST(Simulator, chunkLargerThanTheCacheFailsAndCostsItsBytesEachTime) {
  Trace trace;
  trace.records = {{7, 5, 0, 0, {5 * 4096, 100, 20, 3}},
                   {7, 5, 0, 0, {5 * 4096, 100, 20, 3}},
                   {8, 2, 1, 0, {2 * 4096, 2 * 4096, 0, 0}}};
  for (const PolicyKind kind : allPolicies()) {
    SimulationConfig config{kind, 4};
    config.costs = {4096.0, 0.5, 0.25};  // a page takes a second
    const SimulationRow row = simulate(prepare(trace), config);
    EXPECT_EQ(row.misses, 12u);
    EXPECT_EQ(row.failures, 2u) << name(kind);
    EXPECT_EQ(row.failed_bytes, 10u * 4096);
    EXPECT_EQ(row.bytes, (LoadBytes{12 * 4096, 200 + 2 * 4096, 40, 6}));
    EXPECT_EQ(row.pages_loaded, 2u);
    EXPECT_DOUBLE_EQ(row.modelled_seconds, 12 + 12 * 0.5 + 3 * 0.25);
    EXPECT_EQ(brokenIdentity(row), "");
    EXPECT_NE(toCsv({&row, 1}).find(",2,40960,"), std::string::npos) << toCsv({&row, 1});
    const nlohmann::json json = rowsJson({&row, 1}).front();
    EXPECT_EQ(json["failures"], 2);
    EXPECT_EQ(json["bytes_failed"], 40960);
  }
}

TEST(Simulator, pinsOnlyWhatCarriesClusters) {
  // Twelve chunks of one cluster in a cache of eight: pinned, the last four never fit.
  Trace trace;
  for (int round = 0; round < 3; ++round)
    for (uint64_t chunk = 0; chunk < 12; ++chunk)
      trace.records.push_back({chunk, 1, 0, 0, {4096, 4096, 0, 0}});
  SimulationConfig config{PolicyKind::kLru, 8};
  config.pin_clusters = true;
  const SimulationRow pinned = simulate(prepare(trace), config);
  EXPECT_EQ(pinned.failures, 12u);
  EXPECT_EQ(pinned.hits, 16u);
  trace.carries_clusters = false;
  for (const PolicyKind kind : allPolicies()) {
    config.policy = kind;
    const SimulationRow free = simulate(prepare(trace), config);
    EXPECT_EQ(free.failures, 0u);
    EXPECT_EQ(free.misses, simulate(prepare(trace), {kind, 8}).misses);
  }
  config.policy = PolicyKind::kLru;
  EXPECT_EQ(simulate(prepare(trace), config).hits, 0u);
}

// A request of 2^31 pages costs as much as one of a page: page by page it would take hours.
TEST(Simulator, aRequestOfTwoToThe31PagesIsOneRequest) {
  constexpr uint32_t kPages = 1u << 31;
  constexpr uint64_t kBytes = uint64_t{1} << 40;
  Trace trace;
  for (uint32_t i = 0; i < 20000; ++i)
    trace.records.push_back({i % 3, kPages, i, 0, {kBytes, kBytes / 2, 0, 3}});
  const PreparedTrace prepared = prepare(trace);
  for (const PolicyKind kind : allPolicies()) {
    const SimulationRow row = simulate(prepared, {kind, uint64_t{kPages} * 2 + 1000});
    EXPECT_EQ(brokenIdentity(row), "") << name(kind);
    EXPECT_GE(row.misses, 3 * uint64_t{kPages});
    EXPECT_EQ(row.requests, 20000 * uint64_t{kPages});
  }
}

TEST(Simulator, aPartOfAChunkMovesItsShare) {
  // The optimum by byte keeps three of the five pages of chunk 0 while chunk 1 has two.
  Trace trace;
  trace.records = {{0, 5, 0, 0, {5 * 4096, 1001, 0, 0}},
                   {1, 2, 1, 0, {2 * 4096, 2 * 4096, 0, 0}},
                   {0, 5, 2, 0, {5 * 4096, 1001, 0, 0}}};
  const SimulationRow row = simulate(prepare(trace), {PolicyKind::kBeladyPages, 5});
  EXPECT_EQ(row.pages_loaded, 5u + 2 + 2);
  EXPECT_EQ(row.bytes.needed, 1001u + 2 * 4096 + 400);
  EXPECT_EQ(row.chunks.evictions, 2u + 2);
}

TEST(Simulator, emptyTraceHasEmptyRows) {
  for (const PolicyKind kind : allPolicies()) {
    const SimulationRow row = simulate(prepare({}), {kind, 4});
    EXPECT_EQ(row.requests, 0u);
    EXPECT_EQ(brokenIdentity(row), "");
  }
}

TEST(Simulator, printsRowsUnderTheNamesScriptsRelyOn) {
  const SimulationRow row = simulate(prepareUnit({0, 1, 0}), {PolicyKind::kS3Fifo, 2});
  EXPECT_TRUE(toCsv({&row, 1}).starts_with(
      "policy,pages,requests,hits,misses,compulsory,capacity,conflict,bytes_moved,bytes_needed,"));
  EXPECT_NE(toCsv({&row, 1}).find("\ns3-fifo,2,3,1,2,2,0,0,8192,8192,"), std::string::npos);
  const nlohmann::json json = rowsJson({&row, 1}).front();
  EXPECT_EQ(json["policy"], "s3-fifo");
  EXPECT_EQ(json["pages"], 2);
  EXPECT_EQ(json["requests"], 3);
  EXPECT_EQ(json["bytes_moved"], 8192);
  EXPECT_TRUE(json["modelled_seconds"].is_number());
  EXPECT_TRUE(json["planned_pages"].is_null());
}

TEST(BenchSimulate, measuresTwoThingsThatAgree) {
  const SimulateBenchResult result = benchSimulate({20000, 1000, 500, 1, 1});
  EXPECT_GT(result.lru, 0);
  EXPECT_GT(result.curve, 0);
  EXPECT_EQ(result.lru_misses, result.curve_misses);
  EXPECT_GT(result.lru_misses, 1000u);
}

}  // namespace
}  // namespace sluice::simulator_test
