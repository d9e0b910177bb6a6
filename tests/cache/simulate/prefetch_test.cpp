#include "cache/simulate/prefetch.h"

#include <gtest/gtest.h>

namespace sluice {
namespace {

// `clusters` clusters of 4 chunks of one page, in the same order in each of `frames` frames.
Trace turntable(uint32_t clusters, uint32_t frames, bool time_varying = false) {
  Trace trace;
  for (uint32_t frame = 0; frame < frames; ++frame) {
    for (uint32_t cluster = 0; cluster < clusters; ++cluster) {
      for (uint32_t i = 0; i < 4; ++i) {
        const uint64_t chunk = cluster * 4 + i + (time_varying ? frame * 1000 : 0);
        trace.records.push_back({chunk, 1, cluster, frame, {}});
      }
    }
  }
  return trace;
}

TEST(Prefetch, nextClusterCoversAllButTheFirstWhenTwoClustersFit) {
  const PrefetchResult r = simulatePrefetch(turntable(10, 3), {.pages = 8});
  EXPECT_EQ(r.requests, 120u);
  EXPECT_EQ(r.misses_without, 120u);
  EXPECT_EQ(r.misses, 3u * 4);  // each frame's first cluster
  EXPECT_EQ(r.prefetched, 3u * 36);
  EXPECT_EQ(r.accuracy(), 1);
  EXPECT_DOUBLE_EQ(r.coverage(), 0.9);
  EXPECT_EQ(r.polluted, 0u);
}

TEST(Prefetch, nothingFitsBesideOnePinnedCluster) {
  const PrefetchResult r = simulatePrefetch(turntable(10, 3), {.pages = 4});
  EXPECT_EQ(r.prefetched, 0u);
  EXPECT_EQ(r.misses, r.misses_without);
  EXPECT_EQ(r.accuracy(), std::nullopt);
  EXPECT_EQ(r.coverage(), 0);
}

TEST(Prefetch, lastOrderKnowsNothingInTheFirstFrame) {
  const PrefetchResult r =
      simulatePrefetch(turntable(10, 3), {.model = PrefetchModel::kLastOrder, .pages = 8});
  EXPECT_EQ(r.prefetched, 2u * 36);
  EXPECT_EQ(r.misses, 40u + 2 * 4);
  EXPECT_EQ(r.accuracy(), 1);
}

TEST(Prefetch, lastOrderIsWrongWhenTheOrderTurnsRound) {
  Trace trace = turntable(10, 1);
  Trace back = turntable(10, 1);
  for (uint32_t cluster = 10; cluster-- > 0;) {
    for (uint32_t i = 0; i < 4; ++i) {
      TraceRecord r = back.records[cluster * 4 + i];
      r.frame = 1;
      trace.records.push_back(r);
    }
  }
  const PrefetchResult r =
      simulatePrefetch(trace, {.model = PrefetchModel::kLastOrder, .pages = 8});
  // Cluster 9 has no successor; after each other one its old successor, just drawn, is still there.
  EXPECT_EQ(r.used, 0u);
  EXPECT_EQ(r.polluted, 0u);
}

TEST(Prefetch, nextTimeStepNeedsRoomForAWholeFrame) {
  const Trace trace = turntable(10, 3, true);
  PrefetchConfig config{.model = PrefetchModel::kNextTimeStep, .pages = 80};
  const PrefetchResult roomy = simulatePrefetch(trace, config);
  EXPECT_EQ(roomy.misses, 40u);  // the first step
  EXPECT_EQ(roomy.accuracy(), 1);
  config.pages = 8;
  const PrefetchResult tight = simulatePrefetch(trace, config);
  EXPECT_EQ(tight.used, 0u);
  EXPECT_EQ(tight.prefetched, 2u * 40);
  EXPECT_EQ(tight.accuracy(), 0);
}

TEST(Prefetch, pollutionCountsWhatWouldHaveStayed) {
  // Three pages: 10 is loaded ahead in addition to 0, 20 cannot be (0 is pinned and takes two), so
  // that 20 and then 0 again are missed with prefetching as without.
  Trace none;
  none.records = {
      {0, 2, 0, 0, {}}, {10, 1, 1, 0, {}}, {0, 2, 2, 0, {}}, {20, 2, 3, 0, {}}, {0, 2, 4, 0, {}}};
  const PrefetchResult clean = simulatePrefetch(none, {.pages = 3});
  EXPECT_EQ(clean.misses_without, 7u);
  EXPECT_EQ(clean.misses, 6u);
  EXPECT_EQ(clean.polluted, 0u);
  // 30 is drawn, then 40 (ahead) takes the place of 0, which is asked for in the same visit as 40.
  Trace polluted;
  polluted.records = {{0, 1, 0, 0, {}}, {30, 1, 1, 0, {}}, {0, 1, 2, 0, {}}, {40, 1, 2, 0, {}}};
  const PrefetchResult r = simulatePrefetch(polluted, {.pages = 2});
  EXPECT_EQ(r.prefetched, 2u);  // 30 after 0, 40 after 30 (evicts 0)
  EXPECT_EQ(r.polluted, 1u);    // 0, which evicts 30
  EXPECT_EQ(r.used, 2u);
}

}  // namespace
}  // namespace sluice
