#include "src/surface/corner_bits.h"

#include <gtest/gtest.h>

#include <random>

namespace sluice {
namespace {

// Bits at random, and the same as a plain table.
struct Sample {
  explicit Sample(Vec3i size) : size(size), inside(static_cast<size_t>(volume(size))) {
    std::mt19937 random(5);
    std::vector<uint8_t> row(static_cast<size_t>(size.x));
    bits.reset(size);
    for (int64_t z = 0; z < size.z; ++z)
      for (int64_t y = 0; y < size.y; ++y) {
        for (auto& value : row) value = static_cast<uint8_t>(random() % 256);
        bits.setInside(y, z, 0, row.data(), size.x, uint8_t{100}, uint8_t{180});
        for (int64_t x = 0; x < size.x; ++x) {
          const int value = row[static_cast<size_t>(x)];
          inside[at({x, y, z})] = value >= 100 && value <= 180;
        }
      }
  }
  size_t at(Vec3i p) const { return static_cast<size_t>((p.z * size.y + p.y) * size.x + p.x); }

  Vec3i size;
  std::vector<bool> inside;
  CornerBits bits;
};

TEST(CornerBits, crossedEdgesAreThoseWhoseEndsDiffer) {
  for (const int64_t width : {2, 63, 64, 65, 130}) {
    const Sample sample({width, 5, 4});
    for (int axis = 0; axis < 3; ++axis)
      for (int64_t z = 0; z < sample.size.z - (axis == 2 ? 1 : 0); ++z)
        for (int64_t y = 0; y < sample.size.y - (axis == 1 ? 1 : 0); ++y) {
          int64_t count = 0;
          for (int64_t x = 0; x < width; ++x) {
            Vec3i next{x, y, z};
            ++next[axis];
            const bool expected = next.x < width && sample.inside[sample.at({x, y, z})] !=
                                                        sample.inside[sample.at(next)];
            EXPECT_EQ((sample.bits.crossed(axis, y, z, x / 64) >> (x % 64) & 1) != 0, expected)
                << width << " " << axis << " " << x;
            count += expected && x > 0 ? 1 : 0;
          }
          EXPECT_EQ(sample.bits.countCrossed(axis, y, z, 1), count);
        }
  }
}

TEST(CornerBits, mixedCellsAreThoseWithCornersOfBothKinds) {
  for (const int64_t width : {2, 64, 65, 129}) {
    const Sample sample({width, 3, 3});
    for (int64_t z = 0; z < 2; ++z)
      for (int64_t y = 0; y < 2; ++y)
        for (int64_t x = 0; x < width; ++x) {
          int count = 0;
          for (int c = 0; c < 8 && x + 1 < width; ++c)
            count +=
                sample.inside[sample.at({x + (c & 1), y + (c >> 1 & 1), z + (c >> 2)})] ? 1 : 0;
          EXPECT_EQ((sample.bits.mixedCells(y, z, x / 64) >> (x % 64) & 1) != 0, count % 8 != 0)
              << width << " " << x;
        }
  }
}

TEST(CornerBits, rowsOfBlocksJoin) {
  CornerBits bits;
  bits.reset({150, 2, 2});
  const std::vector<float> values{1, 5, 5, 1, 5};
  bits.setInside(1, 1, 62, values.data(), 5, 3.0F, 9.0F);
  bits.setInside(1, 1, 66, 140);
  for (int64_t x = 0; x < 150; ++x) {
    const bool expected = x == 63 || x == 64 || (x >= 66 && x <= 140);
    EXPECT_EQ((bits.row(1, 1)[x / 64] >> (x % 64) & 1) != 0, expected) << x;
    EXPECT_EQ(bits.row(0, 1)[x / 64], 0U);
  }
}

TEST(CornerBits, countsBits) {
  std::mt19937_64 random(9);
  for (int i = 0; i < 100; ++i) {
    const uint64_t word = random() & random();
    EXPECT_EQ(countBits(word), std::popcount(word));
  }
  EXPECT_EQ(countBits(~uint64_t{0}), 64);
}

}  // namespace
}  // namespace sluice
