// Hilbert's curve, the ranks of blocks, and layers against rays that are walked cell by cell.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <random>
#include <set>

#include "src/parallel/dealing.h"
#include "src/parallel/hilbert.h"
#include "src/render/camera/frame_setup.h"
#include "tests/render/culling_scene.h"

namespace sluice {
namespace {

TEST(Hilbert, visitsEveryCellOnceAndGoesOverFaces) {
  for (const int bits : {0, 1, 2, 3, 4}) {
    const int64_t side = int64_t{1} << bits;
    std::map<uint64_t, Vec3i> cells;
    for (int64_t z = 0; z < side; ++z)
      for (int64_t y = 0; y < side; ++y)
        for (int64_t x = 0; x < side; ++x) cells[hilbertPosition({x, y, z}, bits)] = {x, y, z};
    ASSERT_EQ(cells.size(), static_cast<size_t>(side * side * side)) << bits;
    EXPECT_EQ(cells.rbegin()->first, cells.size() - 1);
    for (uint64_t at = 1; at < cells.size(); ++at) {
      const Vec3i step = cells[at] - cells[at - 1];
      EXPECT_EQ(std::abs(step.x) + std::abs(step.y) + std::abs(step.z), 1) << bits << " at " << at;
    }
  }
}

TEST(Hilbert, takesTheFarCornerOfTheLargestCube) {
  const int64_t last = (int64_t{1} << 21) - 1;
  EXPECT_LT(hilbertPosition({last, last, last}, 21), uint64_t{1} << 63);
}

TEST(Dealing, everyRankHasAsMuchAsAnyOther) {
  for (const int ranks : {1, 2, 3, 7, 32}) {
    const BlockLayout layout = blockLayout({500, 500, 500}, 32, 0);
    const Dealing dealing = dealBlocks(layout, ranks);
    std::vector<int64_t> counts(static_cast<size_t>(ranks));
    for (int64_t block = 0; block < layout.blockCount(); ++block) {
      const int rank = dealing.rankOf(layout.indexOf(block));
      ASSERT_GE(rank, 0);
      ASSERT_LT(rank, ranks);
      ++counts[static_cast<size_t>(rank)];
    }
    const auto [least, most] = std::minmax_element(counts.begin(), counts.end());
    EXPECT_LE(static_cast<double>(*most), 1.12 * static_cast<double>(*least)) << ranks;
  }
}

// A slab of blocks, a thin shell, a corner: typical visible parts of a volume.
TEST(Dealing, partsOfAVolumeAreSharedOutToo) {
  const BlockLayout layout = blockLayout({993, 993, 993}, 32, 0);  // 32^3 blocks
  const Dealing dealing = dealBlocks(layout, 32);
  const auto share = [&](const auto& isIn) {
    std::vector<int64_t> counts(32);
    for (int64_t block = 0; block < layout.blockCount(); ++block)
      if (isIn(layout.indexOf(block)))
        ++counts[static_cast<size_t>(dealing.rankOf(layout.indexOf(block)))];
    int64_t sum = 0;
    for (const int64_t count : counts) sum += count;
    return 32.0 * static_cast<double>(*std::max_element(counts.begin(), counts.end())) /
           static_cast<double>(sum);
  };
  for (int64_t plane = 0; plane < 32; plane += 5)
    for (int axis = 0; axis < 3; ++axis)
      EXPECT_LT(share([&](Vec3i b) { return b[axis] / 2 == plane / 2; }), 1.4) << plane << axis;
  EXPECT_LT(share([](Vec3i b) {
              const double r = length(toDouble(b) - Vec3d{15.5, 15.5, 15.5});
              return r > 12 && r < 14;
            }),
            1.25);
  EXPECT_LT(share([](Vec3i b) { return b.x + b.y + b.z < 24; }), 1.25);
}

TEST(Dealing, aPictureIsDealtEvenlyAndWholeHandsGoToOneRank) {
  std::mt19937 random(5);
  for (const int ranks : {1, 2, 7, 32})
    for (const int64_t side : {60, 250}) {
      const BlockLayout layout = blockLayout({side, side, side}, 8, 0);
      const Dealing dealing = dealBlocks(layout, ranks);
      VisibleBlocks visible;
      for (int64_t block = 0; block < layout.blockCount(); ++block) {
        const Vec3i at = layout.indexOf(block);
        if (at.z != layout.grid.z / 2 && random() % 50 > 0) continue;
        visible.blocks.emplace_back();
        visible.blocks.back().name.block = block;
      }
      const std::vector<int32_t> dealt = dealPicture(dealing, layout, visible);
      ASSERT_EQ(dealt.size(), visible.blocks.size());
      std::vector<int64_t> counts(static_cast<size_t>(ranks));
      std::map<int64_t, int32_t> hands;
      for (size_t i = 0; i < dealt.size(); ++i) {
        ++counts[static_cast<size_t>(dealt[i])];
        const Vec3i hand = layout.indexOf(visible.blocks[i].name.block) / dealing.hand;
        const auto placed = hands.emplace(hand.x + 1000 * (hand.y + 1000 * hand.z), dealt[i]).first;
        EXPECT_EQ(placed->second, dealt[i]);
      }
      const auto [least, most] = std::minmax_element(counts.begin(), counts.end());
      EXPECT_LE(*most - *least, dealing.hand * dealing.hand * dealing.hand);
    }
}

// A block of a level that pictures may have never lies in two hands.
TEST(Dealing, blocksOfCoarserLevelsLieInOneHandEach) {
  for (const Vec3i dims : {Vec3i{300, 280, 260}, {124, 246, 121}, {63, 63, 63}})
    for (const Vec3i factor : {Vec3i{2, 2, 2}, {2, 2, 1}, {3, 3, 3}})
      for (const int ranks : {1, 2, 5}) {
        PyramidLayout pyramid(blockLayout(dims, 8, 1));
        Vec3i times{1, 1, 1};
        for (Vec3i level = dims / factor; level.x > 2 && level.y > 2 && level.z > 2;
             level = level / factor) {
          times = times * factor;
          const Vec3d scale = toDouble(times);
          if (!pyramid.add(level, {scale, (scale - Vec3d{1, 1, 1}) * 0.5}).empty()) break;
        }
        ASSERT_GE(pyramid.levels(), 2);
        const Dealing dealing = dealBlocks(pyramid, ranks, 1);
        EXPECT_GE(dealing.coarsest_level, 1);
        for (int at = 0; at <= dealing.coarsest_level; ++at)
          for (int64_t block = 0; block < pyramid.level(at).blocks.blockCount(); ++block) {
            const BlockName name{.level = at, .block = block};
            const Box3 region = pyramid.regionOf(name);
            EXPECT_EQ(dealing.handOf(region.lo), dealing.handOf(region.hi - Vec3i{1, 1, 1}));
            const Box3 finest = pyramid.finestBlocksOf(name);
            EXPECT_EQ(dealing.rankOf(finest.lo), dealing.rankOf(finest.hi - Vec3i{1, 1, 1}));
          }
      }
}

TEST(Dealing, handsOfALayerShareNoRayAndLaterLayersLieBehind) {
  std::mt19937 random(3);
  VolumeLayout volume;
  volume.dims = {100, 80, 121};
  int64_t crossings = 0;
  for (int view_at = 0; view_at < 60; ++view_at) {
    const BlockLayout layout = blockLayout(volume.dims, view_at % 2 == 0 ? 8 : 16, 0);
    const Dealing dealing = dealBlocks(layout, 1 + static_cast<int>(random() % 4));
    const FrameOptions options = randomView(random, volume);
    const View view = resolve(options, volume);
    const FrameSetup setup = viewSetup(view, volume, {});
    const DealingLayers layers(dealing, setup);
    for (int i = 0; i < 60; ++i) {
      const double x = random() % static_cast<unsigned>(options.size.width) + 0.5,
                   y = random() % static_cast<unsigned>(options.size.height) + 0.5;
      const Vec3d origin = setup.rays.origin0 + setup.rays.origin_dx * x + setup.rays.origin_dy * y;
      const Vec3d step = setup.rays.step0 + setup.rays.step_dx * x + setup.rays.step_dy * y;
      std::optional<uint32_t> last;
      Vec3i last_hand;
      for (int64_t k = setup.first_slice; k < setup.first_slice + 900; ++k) {
        const Vec3d at = origin + step * (static_cast<double>(k) + 0.5);
        const Vec3i cell{static_cast<int64_t>(std::floor(at.x)),
                         static_cast<int64_t>(std::floor(at.y)),
                         static_cast<int64_t>(std::floor(at.z))};
        if (!boxOf(volume.dims - Vec3i{1, 1, 1}).contains(Box3{cell, cell + Vec3i{1, 1, 1}}))
          continue;
        const Vec3i hand = cell / dealing.side_vox;
        const uint32_t layer = layers.layerOf({cell, cell + Vec3i{1, 1, 1}});
        if (last && hand == last_hand) {
          ASSERT_EQ(layer, *last);
        } else if (last) {
          ASSERT_GT(layer, *last) << "view " << view_at;
          ++crossings;
        }
        last = layer;
        last_hand = hand;
      }
    }
  }
  EXPECT_GT(crossings, 2000);
}

}  // namespace
}  // namespace sluice
