#include "src/base/values/number_set.h"

#include <gtest/gtest.h>

#include <random>
#include <set>

namespace sluice {
namespace {

TEST(NumberSet, isEmptyAtFirst) {
  EXPECT_TRUE(NumberSet(0).numbers().empty());
  EXPECT_TRUE(NumberSet(1000).numbers().empty());
}

TEST(NumberSet, givesEachNumberOnceInAscendingOrder) {
  std::mt19937 random(1);
  for (const int64_t end : {1, 63, 64, 65, 128, 1000}) {
    NumberSet set(end);
    std::set<int64_t> expected;
    std::uniform_int_distribution<int64_t> any(0, end - 1);
    for (int i = 0; i < 40; ++i) {
      const int64_t number = any(random);
      set.add(number);
      expected.insert(number);
    }
    EXPECT_EQ(set.numbers(), std::vector<int64_t>(expected.begin(), expected.end())) << end;
  }
}

TEST(NumberSet, addsRangesThatBeginAndEndAnywhere) {
  constexpr int64_t kEnd = 200;
  for (int64_t first = 0; first <= kEnd; first += 7)
    for (int64_t end = 0; end <= kEnd; ++end) {
      NumberSet set(kEnd);
      set.add(first, end);
      std::vector<int64_t> expected;
      for (int64_t number = first; number < end; ++number) expected.push_back(number);
      ASSERT_EQ(set.numbers(), expected) << first << " to " << end;
    }
}

}  // namespace
}  // namespace sluice
