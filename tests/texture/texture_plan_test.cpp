#include "src/texture/texture_plan.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <set>

#include "src/base/error.h"
#include "src/texture/plan_totals.h"
#include "tests/texture/random_plan.h"

namespace sluice {
namespace {

using testing::AllOf;
using testing::HasSubstr;

// The paper's machine, and today's standard page.
const PageGeometry kOctane = findPageConfiguration("octane")->geometry;
const PageGeometry kSparse = findPageConfiguration("sparse-8")->geometry;

// 5 x 4 x 3 blocks of 64^3, none padded.
BlockLayout wholeBlocks(int ghost = 0) {
  const int64_t cells = 63 - 2 * ghost;
  return blockLayout({5 * cells + 1, 4 * cells + 1, 3 * cells + 1}, 64, ghost);
}

TexturePlan planned(const BlockLayout& layout, const VisibleBlocks& classification,
                    const PageGeometry& page, Algorithm algorithm) {
  return planTextures(layout, classification, page, planOptions(layout, algorithm));
}

// Each block shows `thickness` cells along `axis`.
VisibleBlocks slabs(const BlockLayout& layout, int axis, int64_t thickness) {
  std::vector<ObjectBlock> visible;
  for (int64_t block = 0; block < layout.blockCount(); ++block) {
    Box3 cells = layout.ownedCells(layout.indexOf(block));
    cells.lo[axis] += 5;
    cells.hi[axis] = cells.lo[axis] + thickness;
    visible.push_back(objectBlock(layout, block, cells));
  }
  return visibleBlocksOf(layout, std::move(visible));
}

// --- chunks and pages in closed form

TEST(TexturePlan, blackVolumeTakesWholeBlocksUnderEachAlgorithm) {
  for (const int ghost : {0, 1}) {
    const BlockLayout layout = wholeBlocks(ghost);
    for (const Algorithm algorithm :
         {Algorithm::kConventional, Algorithm::kClipped, Algorithm::kTrimmed}) {
      const TexturePlan octane = planned(layout, allBlack(layout), kOctane, algorithm);
      EXPECT_EQ(octane.chunks.size(), 60U);
      EXPECT_EQ(octane.pageCount(), 60 * (2 * 1 * 32));
      EXPECT_EQ(octane.bytes(), 60U * 64 * 64 * 64);
      const TexturePlan sparse = planned(layout, allBlack(layout), kSparse, algorithm);
      EXPECT_EQ(sparse.chunks.size(), 60U);
      EXPECT_EQ(sparse.pageCount(), 60 * (1 * 2 * 2));
    }
  }
}

TEST(TexturePlan, trimmedSlabsTakeTheirThicknessWhateverTheAxis) {
  for (const int ghost : {0, 1}) {
    const BlockLayout layout = wholeBlocks(ghost);
    for (int axis = 0; axis < 3; ++axis)
      for (const int64_t thickness : {1, 2, 7, 8, 31, 32, 40}) {
        const int64_t planes = thickness + 1 + 2 * ghost;
        const VisibleBlocks classification = slabs(layout, axis, thickness);
        const TexturePlan octane = planned(layout, classification, kOctane, Algorithm::kTrimmed);
        EXPECT_EQ(octane.pageCount(), 60 * 2 * ((planes + 1) / 2));
        const TexturePlan sparse = planned(layout, classification, kSparse, Algorithm::kTrimmed);
        EXPECT_EQ(sparse.pageCount(), 60 * 2 * ((planes + 31) / 32));
        for (const Chunk& chunk : octane.chunks) EXPECT_EQ(chunk.size_vox, (Vec3i{64, 64, planes}));
        for (const TextureBlock& block : octane.blocks) EXPECT_EQ(block.trimming_axis, axis);
      }
  }
}

TEST(TexturePlan, untrimmedSlabsTakeWholeBlocks) {
  const BlockLayout layout = wholeBlocks();
  const VisibleBlocks classification = slabs(layout, 1, 7);
  for (const Algorithm algorithm : {Algorithm::kConventional, Algorithm::kClipped}) {
    const TexturePlan plan = planned(layout, classification, kOctane, algorithm);
    EXPECT_EQ(plan.pageCount(), 60 * 64);
    for (const BlockPosition i : plan.blocks.indices())
      EXPECT_EQ(plan.blocks[i].cells,
                algorithm == Algorithm::kClipped
                    ? classification.blocks[static_cast<size_t>(i.value())].cells
                    : layout.ownedCells(layout.indexOf(i.value())));
  }
}

TEST(TexturePlan, conventionalLoadsWhiteBlocksAndTrimmedDoesNot) {
  const BlockLayout layout = wholeBlocks();
  const VisibleBlocks one =
      visibleBlocksOf(layout, {objectBlock(layout, 17, layout.ownedCells(layout.indexOf(17)))});
  EXPECT_EQ(planned(layout, one, kOctane, Algorithm::kConventional).chunks.size(), 60U);
  const TexturePlan clipped = planned(layout, one, kOctane, Algorithm::kClipped);
  EXPECT_EQ(clipped.chunks.size(), 60U);
  for (const TextureBlock& block : clipped.blocks)
    EXPECT_EQ(block.cells.empty(), block.name.block != 17);
  EXPECT_EQ(planned(layout, one, kOctane, Algorithm::kTrimmed).chunks.size(), 1U);
}

// A volume that is smaller than a block takes chunks of its own size.
TEST(TexturePlan, aBlockIsNoLargerThanTheVolume) {
  for (const int ghost : {0, 1}) {
    const BlockLayout layout = blockLayout({20, 20, 20}, 64, ghost);
    const VisibleBlocks all =
        visibleBlocksOf(layout, {objectBlock(layout, 0, layout.ownedCells({0, 0, 0}))});
    for (const Algorithm algorithm : kAlgorithms) {
      const TexturePlan plan = planned(layout, all, kOctane, algorithm);
      ASSERT_EQ(plan.chunks.size(), 1U);
      const int64_t side = 20 + 2 * ghost;
      EXPECT_EQ(plan.chunks[ChunkPosition(int64_t{0})].size_vox, (Vec3i{side, side, side}));
    }
  }
}

TEST(TexturePlan, nothingVisibleIsNothingToLoad) {
  const BlockLayout layout = wholeBlocks();
  for (const Algorithm algorithm : {Algorithm::kTrimmed, Algorithm::kMerged}) {
    const TexturePlan plan = planned(layout, visibleBlocksOf(layout, {}), kOctane, algorithm);
    EXPECT_EQ(plan.pageCount(), 0);
    EXPECT_TRUE(plan.clusters.empty());
    EXPECT_TRUE(clusterOrder(plan, {}).empty());
  }
}

TEST(TexturePlan, conventionalDrawsTheCropAlone) {
  const BlockLayout layout = wholeBlocks();
  PlanOptions options = planOptions(layout, Algorithm::kConventional);
  options.crop = {{30, 0, 0}, {100, 63, 63}};
  const TexturePlan plan = planTextures(layout, allBlack(layout), kOctane, options);
  int64_t cells = 0;
  for (const TextureBlock& block : plan.blocks) cells += block.cells.count();
  EXPECT_EQ(cells, 70 * 63 * 63);
}

// --- the shape of any plan

TEST(TexturePlan, everyVisibleCellIsInOneTextureBlockThatHoldsItsVoxels) {
  std::mt19937_64 random(1);
  for (int trial = 0; trial < 20; ++trial)
    for (const int ghost : {0, 1})
      for (const Algorithm algorithm : kAlgorithms) {
        const BlockLayout layout = blockLayout({30, 41, 23}, 8, ghost);
        const VisibleBlocks classification = randomVisibleBlocks(layout, 0.4, random);
        const PageGeometry page{{8, 4, 2}, 1, 256};
        const TexturePlan plan = planned(layout, classification, page, algorithm);
        std::map<int64_t, Box3> shown;  // by volume block
        for (const TextureBlock& block : plan.blocks) {
          EXPECT_TRUE(shown.emplace(block.name.block, block.cells).second);
          if (block.cells.empty()) continue;
          const Vec3i border{ghost, ghost, ghost};
          EXPECT_TRUE(block.voxels.contains(
              Box3{block.cells.lo - border, block.cells.hi + Vec3i{1, 1, 1} + border}));
          EXPECT_TRUE(layout.cube(layout.indexOf(block.name.block)).contains(block.voxels));
        }
        for (const ObjectBlock& object : classification.blocks) {
          ASSERT_TRUE(shown.contains(object.name.block));
          if (algorithm == Algorithm::kConventional)
            EXPECT_TRUE(shown[object.name.block].contains(object.cells));
          else
            EXPECT_EQ(shown[object.name.block], object.cells);
        }
      }
}

TEST(TexturePlan, chunksBlocksAndClustersPointAtEachOther) {
  std::mt19937_64 random(2);
  for (int trial = 0; trial < 20; ++trial)
    for (const Algorithm algorithm : kAlgorithms) {
      const BlockLayout layout = blockLayout({50, 41, 60}, 8, 0);
      const PageGeometry page{{8, 4, 2}, 2, 128};
      const TexturePlan plan =
          planned(layout, randomVisibleBlocks(layout, 0.5, random), page, algorithm);
      std::multiset<BlockPosition> in_chunks, in_clusters;
      for (const ChunkPosition c : plan.chunks.indices()) {
        const Chunk& chunk = plan.chunks[c];
        EXPECT_EQ(chunk.pages, page.pagesOf(chunk.size_vox));
        for (const BlockPosition position : chunk.blocks) {
          const TextureBlock& block = plan.blocks[position];
          EXPECT_EQ(block.chunk, c);
          EXPECT_TRUE(boxOf(chunk.size_vox).contains(Box3{block.at, block.at + block.texels()}));
          in_chunks.insert(position);
        }
      }
      for (const ClusterPosition c : plan.clusters.indices()) {
        const Cluster& cluster = plan.clusters[c];
        const std::set<ChunkPosition> chunks(cluster.chunks.begin(), cluster.chunks.end());
        EXPECT_EQ(chunks.size(), cluster.chunks.size());
        for (const BlockPosition position : cluster.blocks) {
          const TextureBlock& block = plan.blocks[position];
          EXPECT_EQ(block.cluster, c);
          EXPECT_EQ(layout.indexOf(block.name.block) / plan.cluster_blocks, cluster.index);
          EXPECT_TRUE(chunks.contains(block.chunk));
          in_clusters.insert(position);
        }
      }
      std::multiset<BlockPosition> all;
      for (const BlockPosition i : plan.blocks.indices()) all.insert(i);
      EXPECT_EQ(in_chunks, all);
      EXPECT_EQ(in_clusters, all);
    }
}

TEST(TexturePlan, blocksOfAChunkDoNotOverlap) {
  std::mt19937_64 random(3);
  for (int trial = 0; trial < 10; ++trial)
    for (const MergeOrder order : {MergeOrder::kPaper, MergeOrder::kFirstFit}) {
      const BlockLayout layout = blockLayout({50, 41, 60}, 8, 0);
      const TexturePlan plan = planTextures(layout, randomVisibleBlocks(layout, 0.5, random),
                                            PageGeometry{{8, 4, 2}, 2, 128},
                                            planOptions(layout, Algorithm::kMerged, order));
      for (const Chunk& chunk : plan.chunks)
        for (const BlockPosition a : chunk.blocks)
          for (const BlockPosition b : chunk.blocks) {
            const TextureBlock& one = plan.blocks[a];
            const TextureBlock& other = plan.blocks[b];
            EXPECT_EQ(
                intersect({one.at, one.at + one.texels()}, {other.at, other.at + other.texels()})
                    .empty(),
                a != b);
          }
    }
}

TEST(TexturePlan, causesOfABytesMovedAddUp) {
  std::mt19937_64 random(4);
  for (const Algorithm algorithm : kAlgorithms) {
    const BlockLayout layout = blockLayout({50, 41, 60}, 8, 1);
    const PageGeometry page{{8, 4, 2}, 2, 128};
    const VisibleBlocks classification = randomVisibleBlocks(layout, 0.5, random);
    const TexturePlan plan = planned(layout, classification, page, algorithm);
    uint64_t moved = 0, needed = 0;
    for (const Chunk& chunk : plan.chunks) {
      const LoadBytes load = plan.loadBytes(chunk);
      moved += load.moved;
      needed += load.needed;
      EXPECT_LE(load.needed + load.empty + load.extended, load.moved);
      EXPECT_EQ(load.rounding(),
                static_cast<uint64_t>(page.pagesOf(chunk.size_vox) * page.pageBytes() -
                                      volume(chunk.size_vox) * page.bytes_per_voxel));
      if (algorithm != Algorithm::kMerged) {
        EXPECT_EQ(load.extended, 0U);
      }
    }
    EXPECT_EQ(moved, plan.bytes());
    if (algorithm == Algorithm::kConventional) continue;
    uint64_t expected = 0;  // the voxels around the object boxes' cells
    for (const ObjectBlock& object : classification.blocks)
      expected += static_cast<uint64_t>(volume(object.cells.size() + Vec3i{1, 1, 1})) * 2;
    EXPECT_EQ(needed, expected);
  }
}

TEST(TexturePlan, visitsItsBlocksAndTotalsThemWithoutAList) {
  std::mt19937_64 random(3);
  const BlockLayout layout = blockLayout({150, 90, 60}, 16, 1);
  const EyePosition eye{.parallel = true, .index = {1, 2, 3}};
  PageGeometry page = kSparse;
  for (const int64_t pages : {1, 5, 40})
    for (const Box3& crop : {allCells(layout), Box3{{20, 0, 31}, {21, 89, 59}}, Box3{}})
      for (const Algorithm algorithm : kAlgorithms) {
        page.pages = pages;
        PlanOptions options = planOptions(layout, algorithm);
        options.crop = crop;
        const VisibleBlocks visible = randomVisibleBlocks(layout, 0.3, random);
        const TexturePlan plan = planTextures(layout, visible, page, options);
        std::vector<BlockName> visited;
        visitTextureBlocks(layout, visible, options,
                           [&](const TextureBlock& block) { visited.push_back(block.name); });
        ASSERT_EQ(visited.size(), plan.blocks.size());
        for (const BlockPosition i : plan.blocks.indices())
          EXPECT_EQ(visited[static_cast<size_t>(i.value())], plan.blocks[i].name);
        EXPECT_EQ(loadsEveryBlock(visible, algorithm), loadsWholeBlocks(algorithm));
        if (!loadsEveryBlock(visible, algorithm)) continue;
        const PlanTotals listed = totalsOf(plan, eye);
        const PlanTotals totals = totalsOfEveryBlock(layout, visible, page, options);
        EXPECT_EQ(totals.chunks, listed.chunks);
        EXPECT_EQ(totals.clusters, listed.clusters);
        EXPECT_EQ(totals.cluster_blocks, listed.cluster_blocks);
        EXPECT_EQ(totals.pages, listed.pages);
        EXPECT_EQ(totals.bytes, listed.bytes);
        EXPECT_EQ(totals.binds, listed.binds);
      }
}

TEST(TexturePlan, isAFunctionOfItsArguments) {
  std::mt19937_64 random(5);
  const BlockLayout layout = blockLayout({50, 41, 60}, 8, 0);
  const VisibleBlocks classification = randomVisibleBlocks(layout, 0.5, random);
  const PageGeometry page{{8, 4, 2}, 1, 128};
  for (const Algorithm algorithm : kAlgorithms) {
    const TexturePlan a = planned(layout, classification, page, algorithm);
    const TexturePlan b = planned(layout, classification, page, algorithm);
    ASSERT_EQ(a.chunks.size(), b.chunks.size());
    for (const ChunkPosition i : a.chunks.indices())
      EXPECT_EQ(a.chunks[i].blocks, b.chunks[i].blocks);
    for (const BlockPosition i : a.blocks.indices()) EXPECT_EQ(a.blocks[i].at, b.blocks[i].at);
  }
}

// --- clusters

TEST(TexturePlan, thePapersClusterIsTwoByTwoBlocks) {
  const BlockLayout layout = wholeBlocks();
  const TexturePlan plan = planned(layout, allBlack(layout), kOctane, Algorithm::kTrimmed);
  EXPECT_EQ(plan.cluster_blocks, (Vec3i{2, 2, 1}));
  EXPECT_EQ(plan.cluster_grids.front().count, (Vec3i{3, 2, 3}));
  EXPECT_EQ(plan.clusters.size(), 18U);
}

TEST(TexturePlan, aLargeCacheHasClustersOfWholeRows) {
  const BlockLayout layout = blockLayout({20 * 63 + 1, 30 * 63 + 1, 64}, 64, 0);
  const VisibleBlocks nothing = visibleBlocksOf(layout, {});
  PageGeometry page = kOctane;
  page.pages = 64 * 128;
  EXPECT_EQ(planned(layout, nothing, page, Algorithm::kTrimmed).cluster_blocks, (Vec3i{20, 6, 1}));
  page.pages = 64 * 64;  // three rows: a square gives more neighbours to merge with
  EXPECT_EQ(planned(layout, nothing, page, Algorithm::kTrimmed).cluster_blocks, (Vec3i{8, 8, 1}));
}

TEST(TexturePlan, aClustersBlackBlocksFitTheCache) {
  for (const int64_t blocks_a_side : {1, 3, 40})
    for (const int64_t pages : {64, 128, 256, 512, 1024, 2048, 4096, 65536}) {
      const int64_t voxels = blocks_a_side * 63 + 1;
      const BlockLayout layout = blockLayout({voxels, voxels, voxels}, 64, 0);
      PageGeometry page = kOctane;
      page.pages = pages;
      const VisibleBlocks nothing = visibleBlocksOf(layout, {});
      const TexturePlan plan = planned(layout, nothing, page, Algorithm::kTrimmed);
      const int64_t capacity = pages / 64;
      const Vec3i cluster = plan.cluster_blocks;
      EXPECT_LE(volume(cluster), capacity);
      EXPECT_EQ(cluster.z, 1);
      EXPECT_LE(cluster.x, layout.grid.x);
      EXPECT_LE(cluster.y, layout.grid.y);
      // Clusters are as full as powers of two and the grid allow.
      EXPECT_TRUE(2 * volume(cluster) > capacity ||
                  (cluster.x == layout.grid.x && cluster.y == layout.grid.y))
          << pages << " pages, " << blocks_a_side << " blocks a side";
    }
}

TEST(TexturePlan, rejectsACacheOfLessThanABlock) {
  const BlockLayout layout = wholeBlocks();
  PageGeometry page = kOctane;
  page.pages = 32;
  try {
    planned(layout, allBlack(layout), page, Algorithm::kTrimmed);
    FAIL() << "nothing thrown";
  } catch (const Error& error) {
    EXPECT_THAT(error.what(),
                AllOf(HasSubstr("64 pages"), HasSubstr("has 32"), HasSubstr("--pages 64")));
  }
}

TEST(TexturePlan, conventionalRefusesAVolumeOfTooManyBlocks) {
  const BlockLayout layout = blockLayout({100'000, 100'000, 100'000}, 64, 0);
  const VisibleBlocks one =
      visibleBlocksOf(layout, {objectBlock(layout, 0, layout.ownedCells({0, 0, 0}))});
  for (const Algorithm algorithm : {Algorithm::kConventional, Algorithm::kClipped})
    EXPECT_THROW(planned(layout, one, kSparse, algorithm), Error);
  EXPECT_EQ(planned(layout, one, kSparse, Algorithm::kMerged).chunks.size(), 1U);
}

TEST(TextureAxes, turnTheTrimmingAxisToZ) {
  EXPECT_EQ(turned({10, 20, 30}, 0), (Vec3i{20, 30, 10}));
  EXPECT_EQ(turned({10, 20, 30}, 1), (Vec3i{30, 10, 20}));
  EXPECT_EQ(turned({10, 20, 30}, 2), (Vec3i{10, 20, 30}));
}

}  // namespace
}  // namespace sluice
