// The detail kept of a block's cubes is never more than they hide, and all of it if they have few
// values. Bytes from anywhere are validated before they are read.
#include "src/visibility/plenoptic/part_detail.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

namespace sluice {
namespace {

std::vector<uint8_t> randomCubes(const PartGrid& grid, int values, std::mt19937& random) {
  std::vector<uint8_t> some, cubes(static_cast<size_t>(volume(grid.count())));
  for (int i = 0; i < values; ++i) some.push_back(static_cast<uint8_t>(random() % 256));
  for (uint8_t& cube : cubes) cube = some[random() % some.size()];
  return cubes;
}

TEST(PartDetail, keepsNoMoreThanCubesHaveAndMoreWithMoreBits) {
  std::mt19937 random(1);
  for (int i = 0; i < 60; ++i) {
    const PartGrid grid{{9 + i % 9, 15, 31}, 1 + i % 3};
    const auto cubes = randomCubes(grid, 2 + i, random);
    int64_t last = -1;
    for (int bits = 0; bits <= kMostDetailBits; ++bits) {
      const DetailedParts kept = detailedParts(grid, cubes, bits);
      ASSERT_TRUE(detailFits(kept.parts, kept.detail));
      EXPECT_EQ(kept.detail.empty(), bits == 0);
      const auto known = cubesOf(grid, kept.parts, kept.detail);
      ASSERT_EQ(known.size(), cubes.size());
      int64_t sum = 0;
      for (size_t k = 0; k < cubes.size(); ++k) {
        ASSERT_LE(known[k], cubes[k]);
        sum += known[k];
      }
      EXPECT_GE(sum, last);
      last = sum;
    }
  }
}

TEST(PartDetail, fewValuesAreKeptAsTheyAre) {
  std::mt19937 random(2);
  const PartGrid grid{{31, 30, 29}, 1};
  for (const auto& [bits, values] : {std::pair{1, 2}, {2, 3}}) {
    std::vector<uint8_t> cubes(static_cast<size_t>(volume(grid.count())));
    for (uint8_t& cube : cubes)
      cube = static_cast<uint8_t>(140 + 30 * (random() % static_cast<unsigned>(values)));
    const DetailedParts kept = detailedParts(grid, cubes, bits);
    EXPECT_EQ(cubesOf(grid, kept.parts, kept.detail), cubes);
    EXPECT_EQ(detailedParts(grid, cubes, bits).detail, kept.detail);
  }
}

TEST(PartDetail, cubesThatAreAlikeNeedNoDetail) {
  const PartGrid grid{{31, 31, 31}, 1};
  const std::vector<uint8_t> cubes(static_cast<size_t>(volume(grid.count())), 77);
  const DetailedParts kept = detailedParts(grid, cubes, 2);
  EXPECT_EQ(kept.parts, std::vector<uint8_t>(512, 77));
  EXPECT_TRUE(kept.detail.empty());
}

TEST(PartDetail, bytesThatDoNotFitAreRefused) {
  std::mt19937 random(3);
  const PartGrid grid{{16, 16, 16}, 1};
  const DetailedParts kept = detailedParts(grid, randomCubes(grid, 9, random), 2);
  ASSERT_TRUE(detailFits(kept.parts, kept.detail));
  for (size_t size = 1; size < kept.detail.size(); ++size)
    EXPECT_FALSE(detailFits(kept.parts, std::span(kept.detail).first(size)));
  std::vector<uint8_t> longer = kept.detail;
  longer.push_back(0);
  EXPECT_FALSE(detailFits(kept.parts, longer));
  std::vector<uint8_t> wrong = kept.detail;
  wrong[0] = 3;
  EXPECT_FALSE(detailFits(kept.parts, wrong));
  std::vector<uint8_t> below = kept.detail;
  below[1] = 0;  // a level below the part's least
  if (kept.parts[0] > 0) {
    EXPECT_FALSE(detailFits(kept.parts, below));
  }
}

}  // namespace
}  // namespace sluice
