#include "src/texture/merging.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <random>

#include "cache/model/texture_cache.h"
#include "src/texture/chunk_names.h"
#include "src/texture/frame_trace.h"
#include "src/texture/texture_plan.h"

namespace sluice {
namespace {

std::vector<MergeBlock> blocksOf(const std::vector<int64_t>& thicknesses) {
  std::vector<MergeBlock> blocks;
  for (size_t i = 0; i < thicknesses.size(); ++i)
    blocks.push_back({static_cast<int64_t>(i), thicknesses[i]});
  return blocks;
}

// The thicknesses of each chunk's columns, from below, chunks and columns sorted.
std::vector<std::vector<std::vector<int64_t>>> shapeOf(const std::vector<MergedChunk>& chunks) {
  std::vector<std::vector<std::vector<int64_t>>> shape;
  for (const MergedChunk& chunk : chunks) {
    std::vector<std::vector<int64_t>> columns;
    for (const Column& column : chunk.columns) {
      std::vector<int64_t> pile;
      for (const MergeBlock& block : column.blocks) pile.push_back(block.thickness);
      columns.push_back(pile);
    }
    std::sort(columns.begin(), columns.end());
    shape.push_back(columns);
  }
  std::sort(shape.begin(), shape.end());
  return shape;
}

using Shape = std::vector<std::vector<std::vector<int64_t>>>;

TEST(Merging, horizontalMergesTakeTheLeastDifferenceFirst) {
  // 31 - 30 goes first, then 12 - 10 (not 12 with 30).
  const auto chunks = mergeInCluster(blocksOf({30, 10, 31, 12}), 64, MergeOrder::kPaper);
  EXPECT_EQ(shapeOf(chunks), (Shape{{{10}, {12}}, {{30}, {31}}}));
}

TEST(Merging, aPairInTheMiddleLeavesItsNeighborsToEachOther) {
  // 20 and 21 first; 3 and 60 are neighbours then.
  const auto chunks = mergeInCluster(blocksOf({3, 20, 21, 60}), 64, MergeOrder::kPaper);
  EXPECT_EQ(shapeOf(chunks), (Shape{{{3}, {60}}, {{20}, {21}}}));
}

TEST(Merging, theBlockLeftOverIsPiledWhereTheExtendedPartWas) {
  // 30 with 31, 10 with 12; 50 fits above 10 (60) and above 12 (62), which it fills better.
  const auto chunks = mergeInCluster(blocksOf({30, 10, 31, 12, 50}), 64, MergeOrder::kPaper);
  EXPECT_EQ(shapeOf(chunks), (Shape{{{10}, {12, 50}}, {{30}, {31}}}));
}

TEST(Merging, aBlockThatFitsNowhereStaysAlone) {
  const auto chunks = mergeInCluster(blocksOf({30, 31, 50}), 64, MergeOrder::kPaper);
  EXPECT_EQ(shapeOf(chunks), (Shape{{{30}, {31}}, {{50}}}));
}

TEST(Merging, firstFitPilesBeforeItPairs) {
  // Descending: 40, 30, 24, 20, 10 -> 40+24, 30+20+10; then side by side.
  const auto chunks = mergeInCluster(blocksOf({10, 20, 30, 40, 24}), 64, MergeOrder::kFirstFit);
  EXPECT_EQ(shapeOf(chunks), (Shape{{{30, 20, 10}, {40, 24}}}));
}

TEST(Merging, nothingComesOfNothing) {
  EXPECT_TRUE(mergeInCluster({}, 64, MergeOrder::kPaper).empty());
  EXPECT_TRUE(mergeInCluster({}, 64, MergeOrder::kFirstFit).empty());
}

int64_t texelsOf(const std::vector<MergedChunk>& chunks, int64_t side) {
  int64_t texels = 0;
  for (const MergedChunk& chunk : chunks)
    texels += static_cast<int64_t>(chunk.columns.size()) * side * side * chunk.thickness();
  return texels;
}

TEST(Merging, everyBlockLiesInExactlyOneColumnNoHigherThanABlock) {
  std::mt19937 random(7);
  for (int round = 0; round < 500; ++round) {
    std::vector<int64_t> thicknesses(random() % 40);
    for (int64_t& t : thicknesses) t = 2 + static_cast<int64_t>(random() % 63);
    for (const MergeOrder order : {MergeOrder::kPaper, MergeOrder::kFirstFit}) {
      const auto chunks = mergeInCluster(blocksOf(thicknesses), 64, order);
      std::map<int64_t, int> seen;
      int singles = 0;
      for (const MergedChunk& chunk : chunks) {
        ASSERT_GE(chunk.columns.size(), 1U);
        ASSERT_LE(chunk.columns.size(), 2U);
        singles += chunk.columns.size() == 1 ? 1 : 0;
        for (const Column& column : chunk.columns) {
          int64_t sum = 0;
          for (const MergeBlock& block : column.blocks) {
            EXPECT_EQ(block.thickness, thicknesses[static_cast<size_t>(block.block)]);
            ++seen[block.block];
            sum += block.thickness;
          }
          EXPECT_EQ(sum, column.thickness);
          EXPECT_LE(sum, 64);
        }
      }
      EXPECT_EQ(seen.size(), thicknesses.size());
      for (const auto& [block, times] : seen) EXPECT_EQ(times, 1) << block;
      EXPECT_LE(singles, 1);
    }
  }
}

TEST(Merging, firstFitNeedsFewerTexelsThanThePaperOrderOverManyClusters) {
  std::mt19937 random(3);
  int64_t paper = 0, first_fit = 0;
  for (int round = 0; round < 200; ++round) {
    std::vector<int64_t> thicknesses(4);
    for (int64_t& t : thicknesses) t = 2 + static_cast<int64_t>(random() % 63);
    paper += texelsOf(mergeInCluster(blocksOf(thicknesses), 64, MergeOrder::kPaper), 64);
    first_fit += texelsOf(mergeInCluster(blocksOf(thicknesses), 64, MergeOrder::kFirstFit), 64);
  }
  EXPECT_LT(first_fit, paper);
}

TEST(Merging, betweenClustersThePaperGoesSideBySideAndFirstFitPilesWhereItCan) {
  const MergeBlock thin{0, 20}, thick{1, 40}, full{2, 64};
  EXPECT_EQ(shapeOf({mergeBetweenClusters(thin, thick, 64, MergeOrder::kPaper)}),
            (Shape{{{20}, {40}}}));
  EXPECT_EQ(shapeOf({mergeBetweenClusters(thin, thick, 64, MergeOrder::kFirstFit)}),
            (Shape{{{20, 40}}}));
  EXPECT_EQ(shapeOf({mergeBetweenClusters(thin, full, 64, MergeOrder::kFirstFit)}),
            (Shape{{{20}, {64}}}));
}

// Tong's machine: blocks of 64, clusters of 2 x 2.
struct Machine {
  PageGeometry page{{32, 64, 2}, 1, 256};
  BlockLayout layout;
  explicit Machine(Vec3i blocks) : layout(blockLayout(blocks * 63 + Vec3i{1, 1, 1}, 64, 0)) {}

  // An object block whose object box is `cells` thick along `axis` and whole otherwise.
  ObjectBlock slab(Vec3i index, int64_t cells, int axis) const {
    ObjectBlock block;
    block.name.block = layout.idOf(index);
    block.cells = layout.ownedCells(index);
    block.cells.hi[axis] = block.cells.lo[axis] + cells;
    block.kind = cells == 63 ? BlockClass::kBlack : BlockClass::kGrey;
    block.trimming_axis = cells == 63 ? 2 : axis;
    return block;
  }
  TexturePlan plan(std::vector<ObjectBlock> visible, Algorithm algorithm = Algorithm::kMerged,
                   MergeOrder order = MergeOrder::kPaper) const {
    VisibleBlocks classes;
    classes.blocks = std::move(visible);
    std::sort(classes.blocks.begin(), classes.blocks.end(),
              [](const auto& a, const auto& b) { return a.name < b.name; });
    return planTextures(layout, classes, page,
                        {algorithm, order, 0, boxOf(layout.dims - Vec3i{1, 1, 1})});
  }
};

// Loads of a frame through an LRU cache of the machine's pages, clusters in the given direction.
uint64_t loadsOf(const TexturePlan& plan, Vec3d direction) {
  ChunkNames chunk_names;
  const auto names = chunk_names.namesOf(plan);
  TextureCache cache(static_cast<uint64_t>(plan.page.pages),
                     static_cast<uint64_t>(plan.page.pageBytes()),
                     makePolicy(PolicyKind::kLru, static_cast<uint64_t>(plan.page.pages)));
  for (const TraceRecord& request : frameRequests(plan, names, {true, direction}, 0))
    cache.request(request.chunk, request.pages, request.bytes.moved);
  EXPECT_EQ(cache.counters().brokenIdentity(), "");
  return cache.counters().loads;
}

// Fig. 5: two adjacent clusters of 4 blocks, one grey block of each left over.
TEST(MergingBetweenClusters, aChunkOfTwoClustersIsLoadedOnceInBothDirections) {
  for (const MergeOrder order : {MergeOrder::kPaper, MergeOrder::kFirstFit}) {
    const Machine machine({2, 2, 2});
    const TexturePlan plan =
        machine.plan({machine.slab({0, 0, 0}, 19, 0), machine.slab({1, 1, 1}, 29, 1)},
                     Algorithm::kMerged, order);
    ASSERT_EQ(plan.clusters.size(), 2U);
    ASSERT_EQ(plan.chunks.size(), 1U);
    EXPECT_EQ(plan.clusters.front().chunks, plan.clusters.back().chunks);
    EXPECT_EQ(plan.chunks.front().size_vox,
              order == MergeOrder::kPaper ? (Vec3i{64, 128, 30}) : (Vec3i{64, 64, 50}));
    EXPECT_EQ(loadsOf(plan, {0.3, 0.2, 1}), 1U);
    EXPECT_EQ(loadsOf(plan, {0.3, 0.2, -1}), 1U);
  }
}

// Two columns side by side in wide pages; otherwise one above the other along y.
TEST(MergingBetweenClusters, columnsLieAlongXWhereThatTakesFewerPages) {
  Machine machine({2, 2, 2});
  machine.page.size_vox = {128, 32, 32};
  const TexturePlan plan =
      machine.plan({machine.slab({0, 0, 0}, 19, 0), machine.slab({1, 1, 1}, 29, 1)});
  ASSERT_EQ(plan.chunks.size(), 1U);
  EXPECT_EQ(plan.chunks.front().size_vox, (Vec3i{128, 64, 30}));
  EXPECT_EQ(plan.chunks.front().pages, 2);
}

TEST(MergingBetweenClusters, theOddBlocksOfFullerClustersMergeToo) {
  const Machine machine({2, 2, 2});
  const TexturePlan plan =
      machine.plan({machine.slab({0, 0, 0}, 59, 2), machine.slab({1, 0, 0}, 60, 2),
                    machine.slab({0, 1, 0}, 40, 2), machine.slab({0, 0, 1}, 61, 2),
                    machine.slab({1, 0, 1}, 61, 2), machine.slab({0, 1, 1}, 44, 2)});
  // Two pairs, and the two left over.
  ASSERT_EQ(plan.chunks.size(), 3U);
  EXPECT_EQ(plan.clusters.front().chunks.size(), 2U);
  EXPECT_EQ(plan.clusters.back().chunks.size(), 2U);
  EXPECT_EQ(loadsOf(plan, {0, 0, 1}), 3U);
  EXPECT_EQ(loadsOf(plan, {0, 0, -1}), 3U);
}

TEST(MergingBetweenClusters, aMergeThatWouldOverfillAClusterIsNotMade) {
  // 3 x 1 x 2 blocks, clusters of 2 x 1: the cache holds 2 blocks, each cluster of one full block
  // and one more would need 3.
  Machine machine({3, 1, 2});
  machine.page.pages = 128;
  std::vector<ObjectBlock> black;
  for (int64_t z = 0; z < 2; ++z)
    for (int64_t x = 0; x < 3; ++x) black.push_back(machine.slab({x, 0, z}, 63, 2));
  const TexturePlan plan = machine.plan(black);
  for (const Cluster& cluster : plan.clusters) {
    int64_t pages = 0;
    for (const ChunkPosition chunk : cluster.chunks) pages += plan.chunks[chunk].pages;
    EXPECT_LE(pages, machine.page.pages);
  }
}

TEST(MergedPlan, everyClusterFitsTheCacheAndBlocksOfAChunkDoNotOverlap) {
  std::mt19937 random(11);
  for (int round = 0; round < 50; ++round) {
    const Machine machine({5, 4, 6});
    std::vector<ObjectBlock> visible;
    for (int64_t block = 0; block < machine.layout.blockCount(); ++block)
      if (random() % 3 != 0)
        visible.push_back(machine.slab(machine.layout.indexOf(block),
                                       1 + static_cast<int64_t>(random() % 63),
                                       static_cast<int>(random() % 3)));
    const TexturePlan plan = machine.plan(
        visible, Algorithm::kMerged, round % 2 == 0 ? MergeOrder::kPaper : MergeOrder::kFirstFit);
    for (const Cluster& cluster : plan.clusters) {
      int64_t pages = 0;
      for (const ChunkPosition chunk : cluster.chunks) pages += plan.chunks[chunk].pages;
      EXPECT_LE(pages, machine.page.pages);
      for (const BlockPosition block : cluster.blocks)
        EXPECT_EQ(
            std::count(cluster.chunks.begin(), cluster.chunks.end(), plan.blocks[block].chunk), 1);
    }
    for (const Chunk& chunk : plan.chunks) {
      std::vector<Box3> places;
      for (const BlockPosition position : chunk.blocks) {
        const TextureBlock& block = plan.blocks[position];
        const Box3 place{block.at, block.at + block.texels()};
        EXPECT_TRUE(boxOf(chunk.size_vox).contains(place));
        for (const Box3& other : places) EXPECT_TRUE(intersect(place, other).empty());
        places.push_back(place);
      }
    }
  }
}

// Slabs of many thicknesses, most of them whole blocks as in real volumes, of which some go.
struct ThinnedSlabs {
  Machine machine{{16, 16, 4}};
  std::vector<ObjectBlock> before, after;

  explicit ThinnedSlabs(double share_gone, uint32_t seed) {
    std::mt19937 random(seed);
    std::bernoulli_distribution is_visible(0.6), is_whole(0.5), goes(share_gone);
    machine.page.pages = 64 * 256;
    for (int64_t block = 0; block < machine.layout.blockCount(); ++block) {
      const int64_t cells = is_whole(random) ? 63 : 1 + static_cast<int64_t>(random() % 63);
      if (!is_visible(random)) continue;
      before.push_back(machine.slab(machine.layout.indexOf(block), cells, 2));
      if (!goes(random)) after.push_back(before.back());
    }
  }
  // The share of the pages after the change whose chunks got other names.
  double renamedShare() const {
    ChunkNames chunk_names;
    chunk_names.namesOf(machine.plan(before));
    const auto known = ChunkName(chunk_names.count());
    const TexturePlan plan = machine.plan(after);
    const auto names = chunk_names.namesOf(plan);
    int64_t renamed = 0;
    for (const ChunkPosition i : plan.chunks.indices())
      if (names[i] >= known) renamed += plan.chunks[i].pages;
    return static_cast<double>(renamed) / static_cast<double>(plan.pageCount());
  }
};

// Each of the 2 % of the blocks that go takes a partner along: about 4 % must change.
TEST(MergedPlan, aChangeOfFewBlocksChangesFewChunks) {
  double sum = 0;
  constexpr uint32_t kSeeds = 20;
  for (uint32_t seed = 1; seed <= kSeeds; ++seed) sum += ThinnedSlabs(0.02, seed).renamedShare();
  EXPECT_GT(sum / kSeeds, 0.02);
  EXPECT_LT(sum / kSeeds, 0.08);
}

TEST(Merging, blocksOfOneThicknessMergeWithTheirNeighbors) {
  std::vector<MergeBlock> blocks;
  for (const uint64_t place : {0b0001U, 0b1100U, 0b0110U, 0b1101U, 0b0000U, 0b0100U})
    blocks.push_back({static_cast<int64_t>(place), 20, place});
  const auto chunks = mergeInCluster(blocks, 64, MergeOrder::kPaper);
  std::vector<std::pair<int64_t, int64_t>> pairs;
  for (const MergedChunk& chunk : chunks)
    pairs.emplace_back(chunk.columns[0].blocks[0].block, chunk.columns[1].blocks[0].block);
  EXPECT_THAT(pairs,
              testing::UnorderedElementsAre(std::pair(0b0000, 0b0001), std::pair(0b1100, 0b1101),
                                            std::pair(0b0100, 0b0110)));
}

TEST(MergedPlan, bytesByCauseAddUp) {
  const Machine machine({2, 1, 1});
  const TexturePlan plan =
      machine.plan({machine.slab({0, 0, 0}, 19, 2), machine.slab({1, 0, 0}, 31, 2)});
  ASSERT_EQ(plan.chunks.size(), 1U);
  const LoadBytes load = plan.loadBytes(plan.chunks.front());
  // 128 x 64 x 32 texels in 4 x 1 x 16 pages; needed: 20 and 32 planes of 64 x 64.
  EXPECT_EQ(load.moved, 64U * 4096);
  EXPECT_EQ(load.needed, 64U * 64 * (20 + 32));
  EXPECT_EQ(load.extended, 64U * 64 * 12);
  EXPECT_EQ(load.empty, 0U);
  EXPECT_EQ(load.rounding(), 0U);
}

// Closed forms of the issue: n black blocks of 64 pages.
TEST(MergedPlan, aBlackVolumeCostsItsPagesEachFrameWhenTheCacheHoldsOneCluster) {
  for (const Algorithm algorithm :
       {Algorithm::kConventional, Algorithm::kClipped, Algorithm::kTrimmed, Algorithm::kMerged}) {
    const Machine machine({4, 4, 3});
    std::vector<ObjectBlock> black;
    for (int64_t block = 0; block < machine.layout.blockCount(); ++block)
      black.push_back(machine.slab(machine.layout.indexOf(block), 63, 2));
    const TexturePlan plan = machine.plan(black, algorithm);
    EXPECT_EQ(plan.pageCount(), 48 * 64) << name(algorithm);
    ChunkNames chunk_names;
    const auto names = chunk_names.namesOf(plan);
    for (const uint64_t pages : {uint64_t{256}, uint64_t{48 * 64}}) {
      TextureCache cache(pages, 4096, makePolicy(PolicyKind::kLru, pages));
      for (int frame = 0; frame < 3; ++frame) {
        const uint64_t before = cache.pagesLoaded();
        for (const TraceRecord& r : frameRequests(plan, names, {true, {0.1, 0.2, 1}}, frame))
          cache.request(r.chunk, r.pages, r.bytes.moved);
        const bool nothing = frame > 0 && pages > 256;
        EXPECT_EQ(cache.pagesLoaded() - before, nothing ? 0U : 48U * 64)
            << name(algorithm) << " frame " << frame << " pages " << pages;
      }
    }
  }
}

TEST(MergedPlan, aSlabCostsThePagesOfItsThicknessInEachTrimmingAxis) {
  for (int axis = 0; axis < 3; ++axis)
    for (const int64_t cells : {1, 2, 9, 10, 61, 62}) {
      const Machine machine({1, 1, 1});
      const TexturePlan plan = machine.plan({machine.slab({0, 0, 0}, cells, axis)});
      // cells + 1 planes of 64 x 64, in pages of 32 x 64 x 2.
      EXPECT_EQ(plan.pageCount(), 2 * ((cells + 1 + 1) / 2)) << axis << " " << cells;
    }
}

}  // namespace
}  // namespace sluice
