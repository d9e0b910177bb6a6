// Surfaces where blocks of two levels meet: the seams of a cut, and shares that add up to 1.
#include "src/render/frame/level_fades.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "src/base/error.h"
#include "src/render/blocks/cut/level_faces.h"

namespace sluice {
namespace {

constexpr Box3 kShown{{0, 0, 0}, {128, 128, 128}};

// Levels 0 to 2, in blocks of 11 cells.
PyramidLayout pyramidOf() {
  PyramidLayout pyramid(blockLayout({129, 129, 129}, 16, 2));
  EXPECT_EQ(pyramid.add({64, 64, 64}, {{2, 2, 2}, {0.5, 0.5, 0.5}}), "");
  EXPECT_EQ(pyramid.add({32, 32, 32}, {{4, 4, 4}, {1.5, 1.5, 1.5}}), "");
  return pyramid;
}

ObjectBlock blockAt(const PyramidLayout& pyramid, int level, Vec3i index) {
  ObjectBlock block;
  block.name.level = level;
  block.name.block = pyramid.level(level).blocks.idOf(index);
  block.cells = pyramid.regionOf(level, index);
  return block;
}

struct Cut {
  PyramidLayout pyramid = pyramidOf();
  std::vector<ObjectBlock> blocks;
  bool with_edges = false;

  // `hidden_level`: the picture shows no block of it.
  std::vector<LevelSeam> seams(const Box3& crop = kShown, int hidden_level = -1) {
    std::ranges::sort(blocks, {}, &ObjectBlock::name);
    setLevelFaces(pyramid, blocks);
    return takeLevelSeams(
        pyramid,
        {.crop = crop,
         .with_edges = with_edges,
         .is_in_picture = [&](const BlockName& name) { return name.level != hidden_level; }},
        blocks);
  }
};

// A block of level 0 from 33 to 44, one of level 1 above it along x, of level 2 above it along y.
Cut cutOfThree() {
  Cut cut;
  cut.blocks = {blockAt(cut.pyramid, 0, {3, 3, 3}), blockAt(cut.pyramid, 1, {2, 1, 1}),
                blockAt(cut.pyramid, 2, {0, 1, 0})};
  return cut;
}

double shareAt(const std::optional<LevelFade>& fade, Vec3d at) {
  double share = 1;
  for (size_t i = 0; fade && i < 6; ++i)
    share *= std::clamp(fade->start[i] + fade->slope[i] * at[static_cast<int>(i) % 3], 0.0, 1.0);
  return share;
}

TEST(LevelFades, aSeamIsAsWideAsTheCoarserBlocksTexelsReach) {
  Cut cut = cutOfThree();
  const std::vector<LevelSeam> seams = cut.seams();
  ASSERT_EQ(seams.size(), 2U);
  // A voxel of the coarser level, although its ghost layer reaches farther.
  EXPECT_EQ(seams[0].faces, 1U << 3);
  EXPECT_EQ(seams[0].coarse.level, 1);
  EXPECT_EQ(seams[0].cells, (Box3{{42, 33, 33}, {44, 44, 44}}));
  EXPECT_EQ(seams[1].faces, 1U << 4);
  EXPECT_EQ(seams[1].coarse.level, 2);
  EXPECT_EQ(seams[1].cells, (Box3{{33, 40, 33}, {44, 44, 44}}));
}

// Blocks outside the picture are not refined: a seam with them would show their voxels inside it.
TEST(LevelFades, blocksOutsideThePictureHaveNoSeams) {
  Cut cut = cutOfThree();
  const std::vector<LevelSeam> seams = cut.seams(kShown, 2);
  ASSERT_EQ(seams.size(), 1U);
  EXPECT_EQ(seams[0].coarse.level, 1);
}

TEST(LevelFades, theSharesOfAllBlocksAddUpToOne) {
  Cut cut = cutOfThree();
  const std::vector<LevelSeam> seams = cut.seams();
  const LevelFades fades(seams);
  ASSERT_EQ(seams.size(), 2U);
  double least = 1;
  for (double x = 33; x <= 44; x += 0.25)
    for (double y = 33; y <= 44; y += 0.25) {
      const Vec3d at{x, y, 36.3};
      const double own = shareAt(fades.within(cut.blocks[0].name), at);
      double sum = own;
      for (const LevelSeam& seam : seams)
        if (x >= static_cast<double>(seam.cells.lo.x) && y >= static_cast<double>(seam.cells.lo.y))
          sum += shareAt(fades.rest(seam), at);
      EXPECT_NEAR(sum, 1, 1e-9) << x << ", " << y;
      least = std::min(least, own);
      if (x == 44 || y == 44) {
        EXPECT_NEAR(own, 0, 1e-9);
      }
    }
  EXPECT_EQ(least, 0);
  for (size_t coarse : {size_t{1}, size_t{2}})
    EXPECT_FALSE(fades.within(cut.blocks[coarse].name)) << "drawn in full";
}

// Blocks of level 1 at a face, an edge and a corner of the finer block.
TEST(LevelFades, opaqueSurfacesHaveSeamsAtEdgesAndCornersToo) {
  Cut cut;
  cut.blocks = {blockAt(cut.pyramid, 0, {3, 3, 3}), blockAt(cut.pyramid, 1, {2, 1, 2}),
                blockAt(cut.pyramid, 1, {2, 2, 2}), blockAt(cut.pyramid, 1, {1, 2, 1})};
  EXPECT_EQ(cut.seams().size(), 1U);
  cut.with_edges = true;
  const std::vector<LevelSeam> seams = cut.seams();
  ASSERT_EQ(seams.size(), 3U);
  EXPECT_EQ(seams[0].faces, 1U << 4) << "faces come first";
  EXPECT_EQ(seams[1].faces, 1U << 3 | 1U << 5);
  EXPECT_EQ(seams[1].coarse, cut.blocks[2].name);
  EXPECT_EQ(seams[1].cells, (Box3{{42, 33, 42}, {44, 44, 44}}));
  EXPECT_EQ(seams[2].faces, 1U << 3 | 1U << 4 | 1U << 5);
  EXPECT_EQ(seams[2].coarse, cut.blocks[3].name);
  EXPECT_EQ(seams[2].cells, (Box3{{42, 42, 42}, {44, 44, 44}}));
  const LevelFades fades(seams);
  for (const double at : {42.0, 43.5, 44.0}) {
    EXPECT_EQ(shareAt(fades.rest(seams[1]), {at, 40, at}), 0) << "of surfaces that fade";
    EXPECT_EQ(shareAt(fades.rest(seams[2]), {at, at, at}), 0);
  }
  EXPECT_FALSE(fades.hasSeamAt(seams[0].fine, 3));
  EXPECT_TRUE(fades.hasSeamAt(seams[0].fine, 4));
  EXPECT_EQ(fades.cellsInFiner(seams[1].coarse), (std::vector<Box3>{seams[1].cells}));
}

// A block of level 2 that meets the finer block at a face reaches around its edge.
TEST(LevelFades, aBlockHasOneSeamWithAnother) {
  Cut cut;
  cut.with_edges = true;
  cut.blocks = {blockAt(cut.pyramid, 0, {3, 2, 3}), blockAt(cut.pyramid, 2, {1, 0, 0})};
  const std::vector<LevelSeam> seams = cut.seams();
  ASSERT_EQ(seams.size(), 1U);
  EXPECT_EQ(seams[0].faces, 1U << 3);
}

// Rays pass what is cut off before the finer block's box from the outside inwards, and what lies
// behind it the other way.
TEST(LevelFades, theRestAtACornerIsDrawnFrontToBack) {
  LevelSeam seam;
  seam.faces = 1U << 3 | 1U << 4;
  seam.cells = {{40, 40, 33}, {44, 44, 44}};
  const Box3 fine{{33, 33, 33}, {42, 42, 44}}, last_x{{42, 40, 33}, {44, 44, 44}},
      last_y{{40, 42, 33}, {42, 44, 44}};
  const SeamBoxes behind = seamBoxes(seam, {}, fine, kShown, {true, {1, 1, 1}});
  EXPECT_EQ(behind.joined->cells, (Box3{{40, 40, 33}, {42, 42, 44}}));
  ASSERT_EQ(behind.behind.size(), 2U);
  EXPECT_EQ(behind.behind[0].cells, last_y);
  EXPECT_EQ(behind.behind[1].cells, last_x);
  const SeamBoxes before = seamBoxes(seam, {}, fine, kShown, {true, {-1, -1, 1}});
  ASSERT_EQ(before.before.size(), 2U);
  EXPECT_EQ(before.before[0].cells, last_x);
  EXPECT_EQ(before.before[1].cells, last_y);
}

// The finer block's box may end before its face: the rest of the seam is drawn on its own.
TEST(LevelFades, theRestJoinsTheFinerBlockAsFarAsThatShowsSomething) {
  Cut cut = cutOfThree();
  const LevelSeam seam = cut.seams()[1];  // cells from 40 to 44 along y
  const Box3 fine{{33, 33, 33}, {44, 42, 44}};
  for (const double way : {1.0, -1.0}) {
    const SeamBoxes boxes = seamBoxes(seam, {}, fine, kShown, {true, {1, way, 1}});
    const std::vector<BoxDraw>& beyond = way < 0 ? boxes.before : boxes.behind;
    ASSERT_TRUE(boxes.joined);
    ASSERT_EQ(beyond.size(), 1U);
    ASSERT_EQ(boxes.before.size() + boxes.behind.size(), 1U);
    EXPECT_TRUE(boxes.joined->joins);
    EXPECT_FALSE(beyond[0].joins);
    EXPECT_EQ(boxes.joined->cells, (Box3{{33, 40, 33}, {44, 42, 44}}));
    EXPECT_EQ(beyond[0].cells, (Box3{{33, 42, 33}, {44, 44, 44}}));
    EXPECT_EQ(boxes.joined->beside, fine) << "the layer of the finer block";
    EXPECT_EQ(beyond[0].beside, fine);
  }
  const SeamBoxes all = seamBoxes(seam, {}, seam.cells, kShown, {true, {1, 1, 1}});
  EXPECT_TRUE(all.before.empty() && all.behind.empty());
  const SeamBoxes none =
      seamBoxes(seam, {}, {{33, 33, 33}, {44, 39, 44}}, kShown, {true, {1, 1, 1}});
  EXPECT_FALSE(none.joined);
}

TEST(LevelFades, boxesAreCutWhereSeamsBeginFrontToBack) {
  const Box3 cells{{33, 33, 33}, {44, 44, 44}};
  const std::vector<Box3> seams = {{{42, 33, 33}, {44, 44, 44}}, {{33, 40, 33}, {44, 44, 44}}};
  for (const Vec3d way : {Vec3d{1, 1, 1}, {-1, 1, 0.3}, {1, -1, -1}}) {
    int64_t count = 0;
    std::vector<SeamPart> parts = partsAtSeams(cells, seams, {true, way});
    for (size_t i = 0; i < parts.size(); ++i) {
      const SeamPart& part = parts[i];
      count += part.cells.count();
      for (size_t seam = 0; seam < seams.size(); ++seam) {
        const Box3 both = intersect(part.cells, seams[seam]);
        if (std::ranges::find(part.seams, seam) != part.seams.end())
          EXPECT_EQ(both, part.cells) << i;
        else
          EXPECT_TRUE(both.empty()) << i;
      }
      // No part before this one lies behind it.
      for (size_t before = 0; before < i; ++before) {
        EXPECT_TRUE(intersect(parts[before].cells, part.cells).empty());
        bool may_come_first = false;
        for (int a = 0; a < 3; ++a)
          may_come_first =
              may_come_first || (way[a] >= 0 ? parts[before].cells.hi[a] <= part.cells.lo[a]
                                             : parts[before].cells.lo[a] >= part.cells.hi[a]);
        EXPECT_TRUE(may_come_first) << before << " before " << i;
      }
    }
    EXPECT_EQ(count, cells.count());
    EXPECT_EQ(parts.size(), 4U);
  }
}

// The finer block's cluster has the texels of its coarser neighbours, which are no blocks of their
// own.
TEST(LevelFades, aPlanHasTheTexelsOfSeamsWithTheFinerBlock) {
  Cut cut = cutOfThree();
  VisibleBlocks visible;
  visible.seams = cut.seams();
  visible.blocks = cut.blocks;
  visible.cut.emplace().levels.resize(3);
  visible.cut->levels.back().level = 2;
  for (const Algorithm algorithm : kAlgorithms) {
    PlanOptions options;
    options.algorithm = algorithm;
    options.crop = kShown;
    const PageGeometry page{{16, 16, 16}, 1, 4};
    const TexturePlan plan = planTextures(cut.pyramid, visible, page, options);
    ASSERT_EQ(plan.blocks.size(), 5U);
    EXPECT_EQ(plan.seamsOf(BlockPosition(int64_t{0})), 2);
    EXPECT_EQ(plan.seamsOf(BlockPosition(int64_t{3})), 0);
    for (const int64_t i : {1, 2}) {
      const TextureBlock& block = plan.blocks[BlockPosition(i)];
      const LevelSeam& seam = visible.seams[static_cast<size_t>(i - 1)];
      EXPECT_EQ(block.name, seam.coarse);
      EXPECT_EQ(block.cells, seam.cells);
      EXPECT_EQ(block.cluster, plan.blocks[BlockPosition(int64_t{0})].cluster);
      const Box3 needed = cut.pyramid.of(seam.coarse).voxelsUnder(seam.cells);
      EXPECT_EQ(intersect(needed, block.voxels), needed);
      const auto& chunks = plan.clusters[block.cluster].chunks;
      EXPECT_NE(std::ranges::find(chunks, block.chunk), chunks.end());
    }
    for (const Cluster& cluster : plan.clusters)
      for (const BlockPosition block : cluster.blocks) EXPECT_FALSE(plan.blocks[block].isOfSeam());
    EXPECT_THROW(planTextures(cut.pyramid, visible, {{16, 16, 16}, 1, 2}, options), Error);
  }
}

TEST(LevelFades, theCoarserBlockReachesTheSeam) {
  Cut cut = cutOfThree();
  cut.blocks[1].cells.lo = {50, 30, 30};  // trimmed
  cut.seams();
  EXPECT_EQ(cut.blocks[1].cells,
            unite(Box3{{50, 30, 30}, {66, 44, 44}}, Box3{{44, 33, 33}, {45, 44, 44}}));
}

TEST(LevelFades, noneIsAwayFromTheFaceOrBesideACropOrBesideNothing) {
  Cut away = cutOfThree();
  away.blocks[0].cells.hi = {41, 41, 44};
  EXPECT_EQ(away.seams().size(), 1U) << "the seam of level 2 is wider";
  Cut cropped = cutOfThree();
  EXPECT_EQ(cropped.seams({{0, 0, 0}, {44, 128, 128}}).size(), 1U);
  Cut alone = cutOfThree();
  alone.blocks.pop_back();
  EXPECT_EQ(alone.seams().size(), 1U);
  Cut alike;
  alike.blocks = {blockAt(alike.pyramid, 0, {3, 3, 3}), blockAt(alike.pyramid, 0, {4, 3, 3})};
  EXPECT_TRUE(alike.seams().empty());
}

}  // namespace
}  // namespace sluice
