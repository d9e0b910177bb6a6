// The tree against a look at every block; fusion against its formulas by hand.
#include "src/visibility/plenoptic/toc_tree.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "src/visibility/plenoptic/fusion.h"
#include "src/visibility/plenoptic/series_opacity.h"

namespace sluice {
namespace {

std::vector<std::vector<int32_t>> randomSpans(Vec3i grid, int32_t steps, std::mt19937& random) {
  std::vector<std::vector<int32_t>> begins(static_cast<size_t>(volume(grid)));
  for (auto& of_block : begins)
    for (int32_t step = 1; step < steps; ++step)
      if (random() % 20 == 0) of_block.push_back(step);
  return begins;
}

TEST(TocTree, findsWhatALookAtEveryBlockFinds) {
  std::mt19937 random(1);
  for (const Vec3i grid : {Vec3i{1, 1, 1}, Vec3i{5, 3, 7}, Vec3i{8, 8, 8}, Vec3i{1, 9, 2}})
    for (const int32_t steps : {1, 2, 64, 65, 130}) {
      const auto begins = randomSpans(grid, steps, random);
      const TocTree tree(grid, steps, begins);
      for (int i = 0; i < 30; ++i) {
        const auto a = static_cast<int32_t>(random() % static_cast<unsigned>(steps)),
                   b = static_cast<int32_t>(random() % static_cast<unsigned>(steps));
        std::vector<int64_t> expected;
        for (size_t block = 0; block < begins.size(); ++block)
          if (std::any_of(begins[block].begin(), begins[block].end(), [&](int32_t step) {
                return step > std::min(a, b) && step <= std::max(a, b);
              }))
            expected.push_back(static_cast<int64_t>(block));
        std::vector<int64_t> found = tree.changedBetween(a, b);
        std::sort(found.begin(), found.end());
        EXPECT_EQ(found, expected) << a << " to " << b << " of " << steps;
      }
    }
}

TEST(TocTree, findsTheOneBlockThatChanges) {
  std::vector<std::vector<int32_t>> begins(4096);
  begins[777] = {5};
  const TocTree tree({16, 16, 16}, 64, begins);
  EXPECT_TRUE(tree.changedBetween(5, 40).empty());
  EXPECT_EQ(tree.changedBetween(4, 5), std::vector<int64_t>{777});
  EXPECT_EQ(tree.bytes(), 8U * (4096 + 512 + 64 + 8 + 1));
}

TEST(Fusion, differenceCountsVoxelsThatAreNotEmptyInEither) {
  const std::vector<float> a{0, 0, 0.5F, 0.2F, 0}, b{0, 0.3F, 0.1F, 0.2F, 0};
  EXPECT_NEAR(blockDifference(a, b), (0.3 * 0.3 + 0.4 * 0.4 + 0) / 3, 1e-7);
  EXPECT_EQ(blockDifference({a.data(), 2}, {a.data(), 2}), 0);
  EXPECT_EQ(blockDifference(a, a), 0);
  // Longer than the parallel partial sums.
  std::vector<float> c(5003, 0.25F), d(5003, 0.5F);
  EXPECT_NEAR(blockDifference(c, d), 0.0625, 1e-6);
}

TEST(Fusion, representativeIsTheLeastOfBoth) {
  TransferFunction transfer;
  transfer.colors = {{0, {1, 1, 1}}};
  transfer.opacities = {{0, 1}, {100, 0}, {200, 1}};  // transparent between opaque values
  const ExtinctionTable table(OpacityTable(transfer, {DeviceType::kU8, 1, 0}, {0, 255}));
  const PartGrid grid{{4, 4, 4}, 4};
  const std::vector<uint8_t> low(125, 20), high(125, 180);
  std::vector<uint8_t> mixed(125, 180);
  mixed[0] = 20;
  OpacityBlock a, b;
  fillOpacityBlock(low.data(), 5, 25, grid, table, a);
  fillOpacityBlock(high.data(), 5, 25, grid, table, b);
  const float before = b.parts.floor();
  fuse(b, a);
  EXPECT_FLOAT_EQ(b.opacity[7], 0.8F);
  EXPECT_NEAR(b.parts.floor(), before, 0.02F * before);
  // A block with both has the transparent ones between them too, which fusing values would lose.
  fillOpacityBlock(mixed.data(), 5, 25, grid, table, a);
  EXPECT_EQ(a.parts.floor(), 0);
  fuse(b, a);
  EXPECT_EQ(b.parts.floor(), 0);
}

TEST(SeriesOpacity, equalFunctionsAreKeptOnceAndFamiliesEndSpansOfAnyBasis) {
  const auto seriesOf = [](std::vector<std::vector<int32_t>> begins, uint8_t floor) {
    SeriesOpacity series;
    series.dims = {9, 5, 5};
    series.grid = {2, 1, 1};
    series.block_cells = 4;
    series.steps = 10;
    std::vector<BlockOpacity> blocks(2);
    for (size_t b = 0; b < 2; ++b)
      for (const int32_t begin : begins[b]) {
        blocks[b].spans.push_back({begin, static_cast<int32_t>(blocks[b].functions.size())});
        blocks[b].functions.push_back({static_cast<uint8_t>(begin > 5 ? 0 : floor), {}, {}, {}});
      }
    gather(series, std::move(blocks));
    return series;
  };
  const SeriesOpacity a = seriesOf({{0, 3, 7}, {0}}, 200), b = seriesOf({{0}, {0, 8}}, 100);
  EXPECT_EQ(a.functions.size(), 2U);
  EXPECT_EQ(a.functionAt(0, 2), a.functionAt(1, 9));
  EXPECT_NE(a.functionAt(0, 7), a.functionAt(0, 6));
  EXPECT_EQ(a.tree->changedBetween(2, 3), std::vector<int64_t>{0});
  const std::array<const SeriesOpacity*, 2> bases{&a, &b};
  const std::array<double, 2> both{1, 1}, first{2, 0};
  const SeriesOpacity sum = combined(bases, both);
  EXPECT_EQ(sum.spansOf(0).size(), 3U);
  EXPECT_EQ(sum.spansOf(1).size(), 2U);
  EXPECT_NEAR(unpackExtinction(sum.functions[static_cast<size_t>(sum.functionAt(0, 0))].floor),
              unpackExtinction(200) + unpackExtinction(100), 0.06);
  EXPECT_EQ(combined(bases, first).spansOf(1).size(), 1U);
}

}  // namespace
}  // namespace sluice
