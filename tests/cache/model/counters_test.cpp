#include "src/base/threads/counters.h"

#include <gtest/gtest.h>

namespace sluice {
namespace {

TEST(CacheCounters, identitiesHoldThroughLoadsEvictionsAndReset) {
  CacheCounters c;
  c.budget_bytes = 30;
  c.countMiss();
  c.countLoad(10, false);
  c.countMiss();
  c.countLoad(20, false);
  c.countHit();
  c.countMiss();
  c.countCoalesced();
  c.countMiss();
  c.countFailure();
  c.countEviction(10);
  EXPECT_EQ(c.brokenIdentity(), "");
  EXPECT_EQ(c.requests, 5u);
  EXPECT_EQ(c.current_bytes, 20u);
  EXPECT_EQ(c.peak_bytes, 30u);
  c.reset();
  EXPECT_EQ(c.brokenIdentity(), "");
  EXPECT_EQ(c.requests, 0u);
  EXPECT_EQ(c.resident, 1u);
  EXPECT_EQ(c.peak_bytes, 30u);
  c.countEviction(20);
  EXPECT_EQ(c.brokenIdentity(), "");
  EXPECT_EQ(c.resident, 0u);
}

TEST(CacheCounters, namesTheIdentityThatDoesNotHold) {
  CacheCounters miscounted;
  miscounted.countMiss();
  EXPECT_EQ(miscounted.brokenIdentity(), "misses 1 != loads 0 + coalesced 0 + failures 0");
  CacheCounters over_budget;
  over_budget.budget_bytes = 9;
  over_budget.countMiss();
  over_budget.countLoad(10, false);
  EXPECT_EQ(over_budget.brokenIdentity(), "peak 10 B > budget 9 B");
}

}  // namespace
}  // namespace sluice
