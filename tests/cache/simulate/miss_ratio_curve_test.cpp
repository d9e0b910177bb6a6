#include "cache/simulate/miss_ratio_curve.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <list>

#include "cache/policies/random.h"
#include "cache/simulate/simulator.h"

namespace sluice {
namespace {

std::vector<Key> skewedKeys(uint64_t seed, size_t requests, uint32_t distinct) {
  Random random(seed);
  std::vector<Key> keys(requests);
  // The product of two even draws: many requests to few keys, a long tail.
  for (Key& key : keys)
    key = static_cast<Key>(uint64_t{random.below(distinct)} * random.below(distinct) / distinct);
  return keys;
}

TEST(StackDistances, areThoseOfAListSearchedFromTheFront) {
  StackDistances<UnitRank> unit(0);
  StackDistances<WeightRank> weighted(0);
  std::list<Key> stack;  // most recent first
  const auto weightOf = [](Key key) { return 1 + key % 5; };
  // Far more requests than positions, so that they are packed many times.
  for (const Key key : skewedKeys(4, 30000, 90)) {
    uint64_t depth = 0, weight = 0;
    auto found = stack.begin();
    for (; found != stack.end(); ++found) {
      ++depth;
      weight += weightOf(*found);
      if (*found == key) break;
    }
    const bool cold = found == stack.end();
    ASSERT_EQ(unit.request(key, 1), cold ? unit.kCold : depth);
    ASSERT_EQ(weighted.request(key, weightOf(key)), cold ? weighted.kCold : weight);
    if (!cold) stack.erase(found);
    stack.push_front(key);
  }
}

TEST(StackDistances, holdBeyondOneBlockOfEveryLevel) {
  // A scan of n keys, again and again: each distance is n. 40 000 crosses words, lines and supers.
  constexpr Key kKeys = 40000;
  StackDistances<UnitRank> distances(kKeys);
  for (int round = 0; round < 8; ++round) {
    for (Key key = 0; key < kKeys; ++key)
      ASSERT_EQ(distances.request(key, 1), round == 0 ? distances.kCold : kKeys);
  }
}

TEST(StackDistances, forgetsAKey) {
  StackDistances<WeightRank> distances(0);
  distances.request(0, 2);
  distances.request(1, 3);
  distances.forget(1);
  EXPECT_EQ(distances.request(0, 2), 2u);
  EXPECT_EQ(distances.request(1, 3), distances.kCold);
}

TEST(MissRatioCurve, equalsTheSimulationAtEachSizeOnSinglePages) {
  for (uint64_t seed = 1; seed <= 3; ++seed) {
    const PreparedTrace trace = prepareUnit(skewedKeys(seed, 5000, 150));
    const MissRatioCurve curve = lruCurve(trace);
    for (uint64_t pages = 1; pages <= 160; ++pages)
      ASSERT_EQ(curve.missesAt(pages), simulate(trace, {PolicyKind::kLru, pages}).misses) << pages;
    EXPECT_EQ(curve.missesAt(0), 5000);
  }
}

TEST(MissRatioCurve, equalsTheSimulationFromTheHeaviestChunkOn) {
  Trace records;
  for (const Key key : skewedKeys(6, 4000, 100))
    records.records.push_back({.chunk = key, .pages = 1 + key % 9, .bytes = {}});
  const PreparedTrace trace = prepare(records);
  const MissRatioCurve curve = lruCurve(trace);
  ASSERT_EQ(trace.heaviest, 9u);
  for (uint64_t pages = 9; pages <= 520; ++pages)
    ASSERT_EQ(curve.missesAt(pages), simulate(trace, {PolicyKind::kLru, pages}).misses) << pages;
}

TEST(MissRatioCurve, ofACyclicScanIsOneStep) {
  std::vector<Key> keys;
  for (int i = 0; i < 1000; ++i) keys.push_back(static_cast<Key>(i % 50));
  const MissRatioCurve curve = lruCurve(prepareUnit(keys));
  EXPECT_EQ(curve.missRatioAt(49), 1);
  EXPECT_EQ(curve.missesAt(50), 50);
  EXPECT_EQ(curve.steps.size(), 2u);
}

TEST(MissRatioCurve, ofNothingMissesEverything) {
  EXPECT_EQ(lruCurve(prepareUnit({})).missRatioAt(10), 1);
}

double meanError(const MissRatioCurve& a, const MissRatioCurve& b, uint64_t sizes) {
  double sum = 0;
  for (uint64_t pages = 1; pages <= sizes; ++pages)
    sum += std::abs(a.missRatioAt(pages) - b.missRatioAt(pages));
  return sum / static_cast<double>(sizes);
}

TEST(Shards, staysWithinItsStatedError) {
  constexpr uint32_t kDistinct = 20000;
  const std::vector<Key> keys = skewedKeys(8, 400000, kDistinct);
  const MissRatioCurve exact = lruCurve(prepareUnit(keys));
  for (uint64_t seed = 0; seed < 4; ++seed) {
    ShardsEstimator by_rate = ShardsEstimator::fixedRate(0.05, seed);
    ShardsEstimator by_size = ShardsEstimator::fixedSize(1000, seed);
    for (const Key key : keys) {
      by_rate.request(key, 1);
      by_size.request(key, 1);
    }
    EXPECT_LE(by_size.sampledChunks(), 1000u);
    EXPECT_LT(by_size.rate(), 1);
    for (const MissRatioCurve& curve : {by_rate.curve(), by_size.curve()}) {
      EXPECT_GT(curve.stated_error, 0);
      EXPECT_LT(curve.stated_error, 0.07);
      EXPECT_LE(meanError(curve, exact, kDistinct), curve.stated_error) << seed;
    }
  }
}

TEST(Shards, ofEverythingIsExact) {
  const std::vector<Key> keys = skewedKeys(8, 20000, 500);
  const MissRatioCurve exact = lruCurve(prepareUnit(keys));
  ShardsEstimator all = ShardsEstimator::fixedRate(1);
  for (const Key key : keys) all.request(key, 1);
  const MissRatioCurve curve = all.curve();
  EXPECT_EQ(curve.stated_error, 0);
  for (uint64_t pages = 1; pages <= 500; ++pages)
    EXPECT_NEAR(curve.missesAt(pages), exact.missesAt(pages), 1e-6);
}

}  // namespace
}  // namespace sluice
