// Leaps over bricks of texels with spreads: bytes take their ranges from a table.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <memory>

#include "src/cpu/leap_grid.h"
#include "src/device/shading/expected_look.h"
#include "tests/support/plain_sampling.h"

namespace sluice {
namespace {

LookUp lookUp() {
  LookUp look_up;
  look_up.device_range = {4, 240};
  for (int entry = 0; entry < 256; ++entry)
    look_up.rgba.insert(look_up.rgba.end(), {0.5F, 0.5F, 0.5F, entry > 90 ? 0.1F : 0.0F});
  return look_up;
}

TEST(SpreadLeaps, aPairOfBytesHasTheRangeThatItsSamplesCanShow) {
  const ExpectedLook look = expectedLook(lookUp(), {4, 240}, TexelBytes::kOne);
  ASSERT_EQ(look.byte_ranges.size(), size_t{256} * 256);
  for (int mean = 0; mean < 256; ++mean)
    for (int spread = 0; spread < 256; ++spread) {
      const ByteRange range = look.byte_ranges[static_cast<size_t>(256 * mean + spread)];
      EXPECT_LE(range.lo, mean);
      EXPECT_GE(range.hi, mean);
      if (spread == 0) {
        EXPECT_EQ(range.lo, range.hi);
        continue;
      }
      // The values of the distribution itself, by its own formula.
      const ValueRange values = spreadRange(mean, spread, {4, 240});
      EXPECT_LE(range.lo, std::max(0.0, values.lo)) << mean << ' ' << spread;
      EXPECT_GE(range.hi, std::min(255.0, values.hi)) << mean << ' ' << spread;
    }
}

// Squares of spreads are interpolated, so that a sample between two texels may show values that
// neither of them stands for.
TEST(SpreadLeaps, aBrickHasTheValuesOfEverySampleInIt) {
  ChunkTexels chunk;
  chunk.storage_vox = chunk.size_vox = {2 * kBrickSide + 1, kBrickSide + 1, kBrickSide + 1};
  chunk.has_spread = true;
  chunk.byte_count = 2 * static_cast<size_t>(volume(chunk.storage_vox));
  chunk.bytes = std::make_shared<std::byte[]>(chunk.byte_count);
  uint32_t random = 11;
  const auto draw = [&random](uint32_t count) {
    random = random * 1664525 + 1013904223;
    return (random >> 16) % count;
  };
  for (size_t i = 0; i < chunk.byte_count; i += 2) {
    const bool is_spread = draw(3) == 0;
    chunk.bytes[i] = static_cast<std::byte>(is_spread ? 60 + draw(20) : 90 + draw(10));
    chunk.bytes[i + 1] = static_cast<std::byte>(is_spread ? 10 + draw(20) : 0);
  }
  const ExpectedLook look = expectedLook(lookUp(), {4, 240}, TexelBytes::kOne);
  const LeapGrid grid = leapGrid(chunk, &look);
  for (int i = 0; i < 20000; ++i) {
    Vec3d at;
    for (int a = 0; a < 3; ++a)
      at[a] =
          static_cast<double>(draw(1000)) / 1000 * static_cast<double>(chunk.storage_vox[a] - 1);
    const double spread = spreadAt(chunk, at);
    const ValueRange values = spreadRange(valueAt(chunk, at), spread, {4, 240});
    const auto brick = static_cast<size_t>(at.x / kBrickSide);
    EXPECT_LE(std::to_integer<int>(grid.ranges[2 * brick]), values.lo) << at.x;
    EXPECT_GE(std::to_integer<int>(grid.ranges[2 * brick + 1]), values.hi) << at.x;
  }
}

TEST(SpreadLeaps, theTableMakesTheSameGrid) {
  ChunkTexels chunk;
  chunk.storage_vox = chunk.size_vox = {24, 17, 13};
  chunk.has_spread = true;
  chunk.byte_count = 2 * static_cast<size_t>(volume(chunk.storage_vox));
  chunk.bytes = std::make_shared<std::byte[]>(chunk.byte_count);
  uint32_t random = 7;
  for (size_t i = 0; i < chunk.byte_count; ++i) {
    random = random * 1664525 + 1013904223;
    // Many texels without a spread.
    const uint32_t byte = i % 2 == 1 && (random >> 16) % 3 > 0 ? 0 : random >> 24;
    chunk.bytes[i] = static_cast<std::byte>(byte);
  }
  const ExpectedLook with = expectedLook(lookUp(), {4, 240}, TexelBytes::kOne);
  ExpectedLook without = with;
  without.byte_ranges.clear();
  EXPECT_EQ(leapGrid(chunk, &with).ranges, leapGrid(chunk, &without).ranges);
}

}  // namespace
}  // namespace sluice
