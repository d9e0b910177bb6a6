// LightSquares: which numbers lie side by side, and which volumes have none.
#include "src/cpu/light_squares.h"

#include <gtest/gtest.h>

namespace sluice {
namespace {

constexpr Vec3i kDims{5, 4, 3};

LightVolumePtr someLight(bool key_varies) {
  LightVolume light;
  light.dims = kDims;
  light.key_varies = key_varies;
  for (int64_t i = 0; i < volume(kDims); ++i) {
    light.texels.push_back(9);
    light.texels.push_back(static_cast<uint16_t>(60000 + i));
  }
  return std::make_shared<const LightVolume>(std::move(light));
}

TEST(LightSquares, haveFourNeighboursSideBySide) {
  WorkerPool pool(2);
  LightSquares squares;
  squares.take(someLight(false), pool);
  ASSERT_NE(squares.texels(), nullptr);
  const auto numberOf = [](int64_t x, int64_t y, int64_t z) {
    return static_cast<uint64_t>(60000 + (z * kDims.y + y) * kDims.x + x);
  };
  for (int64_t z = 0; z < kDims.z; ++z)
    for (int64_t y = 0; y + 1 < kDims.y; ++y)
      for (int64_t x = 0; x + 1 < kDims.x; ++x) {
        const uint64_t square = squares.texels()[(z * kDims.y + y) * kDims.x + x];
        EXPECT_EQ(square & 0xFFFF, numberOf(x, y, z));
        EXPECT_EQ(square >> 16 & 0xFFFF, numberOf(x + 1, y, z));
        EXPECT_EQ(square >> 32 & 0xFFFF, numberOf(x, y + 1, z));
        EXPECT_EQ(square >> 48, numberOf(x + 1, y + 1, z));
      }
}

TEST(LightSquares, areNotMadeOfALightThatMoves) {
  WorkerPool pool(1);
  LightSquares squares;
  squares.take(someLight(false), pool);
  squares.take(someLight(true), pool);
  EXPECT_EQ(squares.texels(), nullptr);
  squares.take(nullptr, pool);
  EXPECT_EQ(squares.texels(), nullptr);
}

}  // namespace
}  // namespace sluice
