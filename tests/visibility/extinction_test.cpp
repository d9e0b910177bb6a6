// The least of an interval against every entry in it, and the precision of extinctions in one byte.
#include "src/visibility/plenoptic/extinction.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "src/visibility/plenoptic/block_parts.h"

namespace sluice {
namespace {

TransferFunction bumps() {
  TransferFunction transfer;
  transfer.colors = {{0, {1, 1, 1}}};
  transfer.opacities = {{0, 0}, {40, 0}, {60, 0.3}, {90, 0.1}, {120, 0.9}, {200, 0.2}, {250, 1}};
  return transfer;
}

TEST(Extinction, leastOfAnIntervalIsThatOfItsValues) {
  const OpacityTable table(bumps(), {DeviceType::kU8, 1, 0}, {0, 255});
  const ExtinctionTable extinction(table);
  std::mt19937 random(1);
  std::uniform_real_distribution<double> any(0, 255);
  for (int i = 0; i < 2000; ++i) {
    double lo = any(random), hi = any(random);
    if (lo > hi) std::swap(lo, hi);
    double least = kMostExtinction;
    for (double v = lo; v <= hi; v += 0.05)
      least = std::min(least, -std::log1p(-opacityAt(bumps(), v)));
    const double found = static_cast<double>(extinction.leastIn(lo, hi));
    EXPECT_LE(found, least + 1e-6) << lo << ".." << hi;
    EXPECT_GE(found, 0.9 * least - 0.02) << lo << ".." << hi;
  }
}

TEST(Extinction, opaqueHasTheMostAndNotANumberNothing) {
  const ExtinctionTable extinction(OpacityTable(bumps(), {DeviceType::kF32, 1, 0}, {0, 300}));
  EXPECT_EQ(extinction.leastIn(260, 400), kMostExtinction);
  EXPECT_EQ(extinction.leastIn(static_cast<double>(kNotANumber), 255), 0);
  EXPECT_EQ(extinction.opacityOf(static_cast<double>(kNotANumber)), 0);
}

TEST(Extinction, gradientsTakeTheLeastOfAll) {
  TransferFunction transfer = bumps();
  transfer.gradients = {{0, {{0, 0.25}}}, {10, {{0, 1}}}};
  const ExtinctionTable plain(OpacityTable(bumps(), {DeviceType::kU8, 1, 0}, {0, 255}));
  const ExtinctionTable with(OpacityTable(transfer, {DeviceType::kU8, 1, 0}, {0, 255}));
  const auto opacity = [](float extinction) { return -std::expm1(-extinction); };
  EXPECT_NEAR(opacity(with.leastIn(120, 120)), 0.25F * opacity(plain.leastIn(120, 120)), 1e-3);
}

TEST(Extinction, aByteIsNeverMoreAndNearlyAll) {
  EXPECT_EQ(packExtinction(0), 0);
  EXPECT_EQ(unpackExtinction(0), 0);
  EXPECT_EQ(unpackExtinction(packExtinction(kMostExtinction)), kMostExtinction);
  EXPECT_EQ(packExtinction(1000), 255);
  for (double v = 1e-4; v < 16; v *= 1.001) {
    const auto exact = static_cast<float>(v);
    EXPECT_LE(unpackExtinction(packExtinction(exact)), exact);
    EXPECT_GE(unpackExtinction(packExtinction(exact)), 0.95F * exact);
  }
  for (int i = 0; i < 256; ++i) {
    const float value = unpackExtinction(static_cast<uint8_t>(i));
    EXPECT_EQ(packExtinction(value), i);
    EXPECT_EQ(packExtinction(std::nextafter(value, 0.0F)), std::max(0, i - 1)) << "rounded down";
  }
}

// Of voxels of a type, in parts of `side` cells, against a look at every corner of every cell.
template <class T>
void expectLeastOfCells(int64_t side, DeviceType type) {
  const ExtinctionTable table(OpacityTable(bumps(), {type, 1, 0}, {0, 255}));
  std::mt19937 random(2);
  const Vec3i cells{10, 7, 9};
  const int64_t row = 13, plane = 13 * 8;
  std::vector<T> voxels(static_cast<size_t>(plane * 10));
  for (T& v : voxels) v = static_cast<T>(100 + random() % 60);
  const PartGrid grid{cells, side};
  const BlockParts parts = blockParts(voxels.data(), row, plane, grid, table);
  const Vec3i count = grid.count();
  ASSERT_EQ(static_cast<int64_t>(parts.least.size()), volume(count));
  size_t at = 0;
  for (int64_t z = 0; z < count.z; ++z)
    for (int64_t y = 0; y < count.y; ++y)
      for (int64_t x = 0; x < count.x; ++x, ++at) {
        float least = kMostExtinction;
        const Box3 box = grid.cellsOf({x, y, z});
        for (int64_t cz = box.lo.z; cz < box.hi.z; ++cz)
          for (int64_t cy = box.lo.y; cy < box.hi.y; ++cy)
            for (int64_t cx = box.lo.x; cx < box.hi.x; ++cx) {
              double lo = 255, hi = 0;
              for (int corner = 0; corner < 8; ++corner) {
                const auto v = static_cast<double>(voxels[static_cast<size_t>(
                    (cz + (corner >> 2)) * plane + (cy + (corner >> 1 & 1)) * row + cx +
                    (corner & 1))]);
                lo = std::min(lo, v), hi = std::max(hi, v);
              }
              least = std::min(least, table.leastIn(lo, hi));
            }
        EXPECT_EQ(parts.least[at], least);
      }
}

TEST(BlockParts, leastOfEachPartIsThatOfItsCells) {
  for (const int64_t side : {1, 2, 4}) {
    SCOPED_TRACE(side);
    expectLeastOfCells<uint8_t>(side, DeviceType::kU8);
    expectLeastOfCells<uint16_t>(side, DeviceType::kU16);
    expectLeastOfCells<float>(side, DeviceType::kF32);
  }
}

}  // namespace
}  // namespace sluice
