#include "cache/model/texture_cache.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

#include "cache/model/page_geometry.h"
#include "cache/policies/random.h"

namespace sluice {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

TextureCache makeCache(uint64_t pages, PolicyKind kind = PolicyKind::kLru) {
  return {pages, 4096, makePolicy(kind, pages)};
}

TEST(TextureCache, givesTheLowestFreePagesAndTakesThemBack) {
  TextureCache cache = makeCache(8);
  EXPECT_THAT(cache.request(100, 3, 5000).pages, ElementsAre(0, 1, 2));
  EXPECT_THAT(cache.request(200, 4, 9000).pages, ElementsAre(3, 4, 5, 6));
  const TextureCache::Answer hit = cache.request(100, 3, 5000);
  EXPECT_EQ(hit.outcome, Outcome::kHit);
  EXPECT_THAT(hit.pages, ElementsAre(0, 1, 2));
  // Two pages and one free: 200 is the oldest and goes.
  const TextureCache::Answer load = cache.request(300, 2, 7000);
  EXPECT_EQ(load.outcome, Outcome::kLoaded);
  EXPECT_FALSE(load.was_resident_before);
  EXPECT_THAT(load.evicted, ElementsAre(200));
  EXPECT_THAT(load.pages, ElementsAre(3, 4));
  EXPECT_THAT(cache.pageMap(), ElementsAre(100, 100, 100, 300, 300, TextureCache::kNoChunk,
                                           TextureCache::kNoChunk, TextureCache::kNoChunk));
  EXPECT_TRUE(cache.request(200, 4, 9000).was_resident_before);
  const CacheCounters& c = cache.counters();
  EXPECT_EQ(c.requests, 5u);
  EXPECT_EQ(c.hits, 1u);
  EXPECT_EQ(c.loads, 4u);
  EXPECT_EQ(c.redundant_loads, 1u);
  EXPECT_EQ(c.evictions, 2u);
  EXPECT_EQ(c.uploaded_bytes, 5000u + 9000 + 7000 + 9000);
  EXPECT_EQ(cache.pagesLoaded(), 13u);
  EXPECT_EQ(c.brokenIdentity(), "");
}

// Nothing is kept of thresholds seen long ago, so that an hour of sliding takes no more memory than
// a minute.
TEST(TextureCache, forgetsWhatCanNoLongerBeAskedFor) {
  for (const PolicyKind kind : onlinePolicies()) {
    TextureCache cache = makeCache(8, kind), endless = makeCache(8, kind);
    for (ChunkId chunk = 0; chunk < 1000; ++chunk) {
      const auto answer = cache.request(chunk, 3, 1);
      EXPECT_FALSE(answer.was_resident_before);
      endless.request(chunk, 3, 1);
      cache.forgetUnused([chunk](ChunkId other) { return other + 2 > chunk; });
      EXPECT_LE(cache.known(), 4U) << name(kind);
    }
    EXPECT_EQ(endless.known(), 1000U);
    EXPECT_EQ(cache.counters().brokenIdentity(), "");
    EXPECT_LE(cache.residents().size(), 2U);
    for (const ChunkId chunk : cache.residents()) {
      EXPECT_TRUE(cache.contains(chunk));
      EXPECT_EQ(cache.request(chunk, 3, 1).outcome, Outcome::kHit);
    }
    EXPECT_FALSE(cache.contains(3));
    EXPECT_FALSE(cache.request(3, 3, 1).was_resident_before) << "no longer known";
  }
}

TEST(TextureCache, refusesWhatDoesNotFitBesideThePinned) {
  TextureCache cache = makeCache(4);
  cache.request(1, 3, 1);
  EXPECT_TRUE(cache.pin(1));
  EXPECT_FALSE(cache.pin(2));
  const TextureCache::Answer answer = cache.request(2, 2, 1);
  EXPECT_EQ(answer.outcome, Outcome::kDoesNotFit);
  EXPECT_THAT(answer.pages, IsEmpty());
  EXPECT_EQ(cache.counters().failures, 1u);
  cache.unpinAll();
  EXPECT_THAT(cache.request(2, 2, 1).evicted, ElementsAre(1));
  EXPECT_EQ(cache.counters().brokenIdentity(), "");
}

TEST(TextureCache, erasesWhatBecameInvalid) {
  TextureCache cache = makeCache(4);
  cache.request(1, 4, 1);
  EXPECT_TRUE(cache.erase(1));
  EXPECT_FALSE(cache.erase(1));
  EXPECT_FALSE(cache.contains(1));
  EXPECT_THAT(cache.request(2, 4, 1).evicted, IsEmpty());
  EXPECT_EQ(cache.counters().evictions, 1u);
  EXPECT_EQ(cache.counters().brokenIdentity(), "");
}

TEST(TextureCache, identitiesAndPagesHoldUnderEveryPolicy) {
  for (const PolicyKind kind : onlinePolicies()) {
    TextureCache cache = makeCache(64, kind);
    Random random(11);
    // The second observer: pages according to the answers, kept by the test.
    std::set<uint32_t> taken;
    std::vector<std::vector<uint32_t>> pages_of(40);
    uint64_t uploaded_bytes = 0;
    for (int i = 0; i < 3000; ++i) {
      const uint64_t chunk = random.below(40);
      const auto pages = static_cast<uint32_t>(1 + chunk % 9);
      if (i % 10 == 0) cache.unpinAll();
      const TextureCache::Answer answer = cache.request(chunk, pages, pages * 4000);
      for (const ChunkId gone : answer.evicted) {
        for (const uint32_t page : pages_of[gone]) taken.erase(page);
        pages_of[gone].clear();
      }
      if (answer.outcome == Outcome::kLoaded) {
        uploaded_bytes += pages * 4000;
        pages_of[chunk].assign(answer.pages.begin(), answer.pages.end());
        for (const uint32_t page : answer.pages) ASSERT_TRUE(taken.insert(page).second);
      }
      if (answer.outcome != Outcome::kDoesNotFit) cache.pin(chunk);
      ASSERT_EQ(taken.size(), cache.usedPages());
      ASSERT_EQ(cache.counters().brokenIdentity(), "") << name(kind);
      if (i == 1500) cache.resetCounters(), uploaded_bytes = 0;
    }
    EXPECT_EQ(cache.counters().uploaded_bytes, uploaded_bytes);
    EXPECT_GT(cache.counters().evictions, 0u);
  }
}

// A volume of black blocks, 4 to a cluster, drawn cluster by cluster in the same order each frame.
void drawBlackVolume(TextureCache& cache, uint64_t blocks, const PageGeometry& geometry) {
  const auto pages = static_cast<uint32_t>(geometry.pagesOf({64, 64, 64}));
  for (uint64_t block = 0; block < blocks; ++block) {
    if (block % 4 == 0) cache.unpinAll();
    ASSERT_NE(cache.request(block, pages, 64 * 64 * 64).outcome, Outcome::kDoesNotFit);
    cache.pin(block);
  }
}

TEST(TextureCache, blackVolumeCostsAllItsPagesEachFrameWhenOneClusterFits) {
  const PageGeometry octane;
  constexpr uint64_t kBlocks = 24;
  for (const PolicyKind kind : {PolicyKind::kLru, PolicyKind::kFifo, PolicyKind::kClock}) {
    TextureCache cache = makeCache(256, kind);
    for (int frame = 0; frame < 3; ++frame) {
      cache.resetCounters();
      drawBlackVolume(cache, kBlocks, octane);
      EXPECT_EQ(cache.pagesLoaded(), kBlocks * 64) << name(kind);
      EXPECT_EQ(cache.counters().uploaded_bytes, kBlocks * 64 * 64 * 64);
      EXPECT_EQ(cache.counters().hits, 0u);
    }
  }
}

TEST(TextureCache, blackVolumeThatFitsCostsNothingFromTheSecondFrameOn) {
  constexpr uint64_t kBlocks = 24;
  for (const PolicyKind kind : onlinePolicies()) {
    TextureCache cache = makeCache(kBlocks * 64, kind);
    drawBlackVolume(cache, kBlocks, PageGeometry{});
    EXPECT_EQ(cache.pagesLoaded(), kBlocks * 64);
    cache.resetCounters();
    drawBlackVolume(cache, kBlocks, PageGeometry{});
    EXPECT_EQ(cache.pagesLoaded(), 0u) << name(kind);
    EXPECT_EQ(cache.counters().hits, kBlocks);
  }
}

}  // namespace
}  // namespace sluice
