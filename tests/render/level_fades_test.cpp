// Surfaces that let light through where blocks of two levels meet: the seams of a cut, and shares
// that add up to 1.
#include "src/render/frame/level_fades.h"

#include <gtest/gtest.h>

#include <algorithm>

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

  std::vector<LevelSeam> seams(const Box3& crop = kShown) {
    std::ranges::sort(blocks, {}, &ObjectBlock::name);
    setLevelFaces(pyramid, blocks);
    return takeLevelSeams(pyramid, crop, blocks);
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
  EXPECT_EQ(seams[0].face, 3);
  EXPECT_EQ(seams[0].coarse.level, 1);
  EXPECT_EQ(seams[0].cells, (Box3{{42, 33, 33}, {44, 44, 44}}));
  EXPECT_EQ(seams[1].face, 4);
  EXPECT_EQ(seams[1].coarse.level, 2);
  EXPECT_EQ(seams[1].cells, (Box3{{33, 40, 33}, {44, 44, 44}}));
}

TEST(LevelFades, theSharesOfAllBlocksAddUpToOne) {
  Cut cut = cutOfThree();
  const std::vector<LevelSeam> seams = cut.seams();
  const LevelFades fades(seams);
  const EyePosition eye{true, {1, 1, 1}};
  std::vector<BoxDraw> borders;
  for (const ObjectBlock& block : cut.blocks) {
    BoxDraw box;
    box.cells = block.cells;
    LevelBorders of_block;
    fades.addBorders(block.name, box, kShown, eye, of_block);
    // Rays pass the finer block first, with the borders in it.
    EXPECT_TRUE(of_block.behind.empty());
    for (const BoxDraw& border : of_block.before) borders.push_back(border);
  }
  ASSERT_EQ(borders.size(), 2U);
  double least = 1;
  for (double x = 33; x <= 44; x += 0.25)
    for (double y = 33; y <= 44; y += 0.25) {
      const Vec3d at{x, y, 36.3};
      const double own = shareAt(fades.within(cut.blocks[0].name), at);
      double sum = own;
      for (const BoxDraw& border : borders)
        if (x >= static_cast<double>(border.cells.lo.x) &&
            y >= static_cast<double>(border.cells.lo.y))
          sum += shareAt(border.fade, at);
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

TEST(LevelFades, bordersBehindTheirBlockAreDrawnAfterIt) {
  Cut cut = cutOfThree();
  const std::vector<LevelSeam> seams = cut.seams();
  LevelBorders borders;
  BoxDraw box;
  box.cells = cut.blocks[1].cells;
  LevelFades(seams).addBorders(cut.blocks[1].name, box, kShown, {true, {-1, 1, 1}}, borders);
  EXPECT_TRUE(borders.before.empty());
  ASSERT_EQ(borders.behind.size(), 1U);
  EXPECT_EQ(borders.behind[0].beside, box.cells);
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
