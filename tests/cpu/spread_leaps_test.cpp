// Leaps over bricks of texels with spreads: bytes take their ranges from a table.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <memory>

#include "src/cpu/leap_grid.h"
#include "src/device/expected_look.h"

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

TEST(SpreadLeaps, theTableMakesTheSameGrid) {
  ChunkTexels chunk;
  chunk.storage_vox = {24, 17, 13};
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
