#include "src/cpu/tile_bins.h"

#include <gtest/gtest.h>

namespace sluice {
namespace {

KernelBox seenAt(int x_lo, int y_lo, int x_hi, int y_hi) {
  KernelBox box;
  box.x_lo = x_lo, box.y_lo = y_lo, box.x_hi = x_hi, box.y_hi = y_hi;
  return box;
}

TEST(TileBins, eachTileHasTheBoxesThatMeetItInTheirOrder) {
  constexpr int kAcross = 5, kUp = 4;
  std::vector<KernelBox> boxes;
  uint32_t state = 5;
  const auto random = [&state](int below) {
    state = state * 1664525U + 1013904223U;
    return static_cast<int>((state >> 8) % static_cast<uint32_t>(below));
  };
  for (int i = 0; i < 200; ++i) {
    const int x = random(kAcross * kTileSide), y = random(kUp * kTileSide);
    boxes.push_back(seenAt(x, y, std::min(kAcross * kTileSide, x + 1 + random(40)),
                           std::min(kUp * kTileSide, y + 1 + random(40))));
  }
  const TileBins bins = tileBins(boxes, kAcross, kUp);
  for (int tile = 0; tile < kAcross * kUp; ++tile) {
    const int x = tile % kAcross * kTileSide, y = tile / kAcross * kTileSide;
    std::vector<uint32_t> expected;
    for (uint32_t i = 0; i < boxes.size(); ++i)
      if (boxes[i].x_lo < x + kTileSide && boxes[i].x_hi > x && boxes[i].y_lo < y + kTileSide &&
          boxes[i].y_hi > y)
        expected.push_back(i);
    const auto found = bins.of(tile);
    EXPECT_EQ(std::vector<uint32_t>(found.begin(), found.end()), expected) << tile;
  }
}

TEST(TileBins, noBoxes) {
  const TileBins bins = tileBins({}, 2, 2);
  for (int tile = 0; tile < 4; ++tile) EXPECT_TRUE(bins.of(tile).empty());
}

}  // namespace
}  // namespace sluice
