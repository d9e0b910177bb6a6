#include "src/base/values/strong_index.h"

#include <gtest/gtest.h>

#include <type_traits>
#include <unordered_set>

namespace sluice {
namespace {

using Apple = StrongIndex<struct AppleTag>;
using Pear = StrongIndex<struct PearTag>;
using Apples = IndexedVector<Apple, int>;

// The test is that mixed indices do not compile.
template <class List, class Index>
concept Opens = requires(List list, Index index) {
  list[index];
};
static_assert(Opens<Apples, Apple>);
static_assert(Opens<const Apples, Apple>);
static_assert(!Opens<Apples, Pear>);
static_assert(!Opens<Apples, int>);
static_assert(!Opens<Apples, size_t>);
static_assert(!std::is_convertible_v<int64_t, Apple>);
static_assert(!std::is_convertible_v<Apple, int64_t>);
static_assert(!std::is_constructible_v<Apple, Pear>);
static_assert(!std::equality_comparable_with<Apple, Pear>);
static_assert(!std::equality_comparable_with<Apple, int64_t>);
static_assert(sizeof(Apple) == sizeof(int64_t));

TEST(StrongIndex, ordersAndHashesAsItsNumber) {
  EXPECT_LT(Apple(int64_t{2}), Apple(int64_t{3}));
  EXPECT_EQ(Apple(), Apple(int64_t{0}));
  Apple apple(int64_t{7});
  ++apple;
  EXPECT_EQ(apple.value(), 8);
  const std::unordered_set<Apple> apples{Apple(int64_t{1}), Apple(int64_t{2}), Apple(int64_t{1})};
  EXPECT_EQ(apples.size(), 2U);
}

TEST(IndexedVector, isOpenedByItsIndexAlone) {
  Apples apples{10, 20, 30};
  EXPECT_EQ(apples[Apple(int64_t{1})], 20);
  apples[Apple(int64_t{2})] = 5;
  EXPECT_EQ(apples.endIndex(), Apple(int64_t{3}));
  int sum = 0;
  for (const Apple apple : apples.indices()) sum += apples[apple];
  EXPECT_EQ(sum, 35);
  EXPECT_TRUE(Apples().indices().begin() == Apples().indices().end());
  IndexedVector<Apple, bool> flags(3);
  flags[Apple(int64_t{1})] = true;
  EXPECT_TRUE(flags[Apple(int64_t{1})]);
}

}  // namespace
}  // namespace sluice
