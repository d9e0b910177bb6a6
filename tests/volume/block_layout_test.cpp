#include "src/volume/block_layout.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>
#include <vector>

#include "src/base/error.h"

namespace sluice {
namespace {

using testing::AllOf;
using testing::HasSubstr;

// Blocks along an axis, counted by laying them one after the other, the last plane of one being the
// first of the next, until all voxels are covered.
int64_t blocksLaidOut(int64_t voxels, int64_t side) {
  int64_t blocks = 1;
  for (int64_t last = side - 1; last < voxels - 1; last += side - 1) ++blocks;
  return blocks;
}

std::vector<BlockLayout> manyLayouts() {
  std::vector<BlockLayout> layouts;
  std::mt19937 random(1);
  std::uniform_int_distribution<int64_t> dim(2, 40);
  for (const int64_t size : {4, 8, 16})
    for (const int ghost : {0, 1})
      for (int trial = 0; trial < 25; ++trial)
        layouts.push_back(blockLayout({dim(random), dim(random), dim(random)}, size, ghost));
  return layouts;
}

TEST(BlockLayout, gridFollowsFormulaOne) {
  for (const int64_t size : {2, 4, 8, 32, 64})
    for (int64_t voxels = 2; voxels < 300; ++voxels)
      EXPECT_EQ(blockLayout({voxels, 2, 2}, size, 0).grid,
                (Vec3i{blocksLaidOut(voxels, size), 1, 1}))
          << voxels << " voxels in blocks of " << size;
}

TEST(BlockLayout, aGhostLayerTakesTwoPlanesOfEachBlock) {
  for (const int64_t size : {4, 8, 64})
    for (int64_t voxels = 2; voxels < 300; ++voxels)
      EXPECT_EQ(blockLayout({2, voxels, 2}, size, 1).grid.y, blocksLaidOut(voxels, size - 2));
}

TEST(BlockLayout, everyCellIsOwnedOnce) {
  for (const BlockLayout& layout : manyLayouts()) {
    const Vec3i cells = layout.dims - Vec3i{1, 1, 1};
    std::vector<int> owners(static_cast<size_t>(volume(cells)), 0);
    for (int64_t block = 0; block < layout.blockCount(); ++block) {
      const Box3 owned = layout.ownedCells(layout.indexOf(block));
      EXPECT_FALSE(owned.empty());
      for (int64_t z = owned.lo.z; z < owned.hi.z; ++z)
        for (int64_t y = owned.lo.y; y < owned.hi.y; ++y)
          for (int64_t x = owned.lo.x; x < owned.hi.x; ++x)
            ++owners.at(static_cast<size_t>((z * cells.y + y) * cells.x + x));
    }
    EXPECT_EQ(owners, std::vector<int>(owners.size(), 1));
  }
}

TEST(BlockLayout, aBlockStoresWhatItsCellsAndTheirGradientsNeed) {
  for (const BlockLayout& layout : manyLayouts())
    for (int64_t block = 0; block < layout.blockCount(); ++block) {
      const Vec3i index = layout.indexOf(block);
      const Box3 cells = layout.ownedCells(index), stored = layout.storedVoxels(index);
      const Vec3i ghost{layout.ghost, layout.ghost, layout.ghost};
      // A cell's far corner is one further; central differences there one more.
      const Box3 needed{cells.lo - ghost, cells.hi + Vec3i{1, 1, 1} + ghost};
      EXPECT_TRUE(stored.contains(intersect(needed, boxOf(layout.dims))));
      EXPECT_TRUE(boxOf(layout.dims).contains(stored));
      EXPECT_EQ(layout.cube(index).size(), (Vec3i{layout.size, layout.size, layout.size}));
    }
}

TEST(BlockLayout, neighboursShareTheirBoundaryPlanes) {
  for (const BlockLayout& layout : manyLayouts())
    for (int axis = 0; axis < 3; ++axis)
      for (int64_t block = 0; block < layout.blockCount(); ++block) {
        Vec3i index = layout.indexOf(block);
        const Box3 here = layout.cube(index);
        if (++index[axis] == layout.grid[axis]) continue;
        EXPECT_EQ(intersect(here, layout.cube(index)).size()[axis], 1 + 2 * layout.ghost);
      }
}

TEST(BlockLayout, idsAndIndicesAreOneToOne) {
  const BlockLayout layout = blockLayout({20, 30, 40}, 8, 0);
  int64_t next = 0;
  for (int64_t z = 0; z < layout.grid.z; ++z)
    for (int64_t y = 0; y < layout.grid.y; ++y)
      for (int64_t x = 0; x < layout.grid.x; ++x, ++next) {
        EXPECT_EQ(layout.idOf({x, y, z}), next);
        EXPECT_EQ(layout.indexOf(next), (Vec3i{x, y, z}));
      }
  EXPECT_EQ(next, layout.blockCount());
}

TEST(BlockLayout, idsGoFarBeyond32Bits) {
  const BlockLayout layout = blockLayout({1'000'000'000, 1'000'000'000, 1000}, 64, 0);
  EXPECT_EQ(layout.grid, (Vec3i{15873016, 15873016, 16}));
  EXPECT_EQ(layout.indexOf(layout.blockCount() - 1), (layout.grid - Vec3i{1, 1, 1}));
  EXPECT_EQ(layout.idOf(layout.grid - Vec3i{1, 1, 1}), layout.blockCount() - 1);
}

// The line of the Error that blockLayout throws.
std::string errorOf(Vec3i dims, int64_t size) {
  try {
    blockLayout(dims, size, 0, "a.raw");
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

TEST(BlockLayout, rejectsAnAxisOfOneVoxel) {
  for (const Vec3i dims : {Vec3i{1, 5, 5}, Vec3i{5, 1, 5}, Vec3i{5, 5, 1}})
    EXPECT_THAT(errorOf(dims, 8), AllOf(HasSubstr("a.raw: "), HasSubstr("at least 2")));
}

TEST(BlockLayout, rejectsMoreBlocksThanCanBeCounted) {
  const int64_t billion = 1'000'000'000;
  EXPECT_THAT(errorOf({billion, billion, billion}, 64),
              AllOf(HasSubstr("a.raw: "), HasSubstr("15873016"), HasSubstr("larger --block")));
  EXPECT_EQ(errorOf({billion, billion, billion}, 1024), "no error");
}

TEST(BlockLayoutDeathTest, aBlockIsAPowerOfTwoAndHoldsACell) {
  EXPECT_DEATH(blockLayout({5, 5, 5}, 6, 0), "check failed");
  EXPECT_DEATH(blockLayout({5, 5, 5}, 2, 1), "check failed");
  EXPECT_DEATH(blockLayout({5, 5, 5}, 16, 4), "check failed");
}

TEST(BlockSizeFor, holdsOnePageAndNoSmallerPowerOfTwoDoes) {
  EXPECT_EQ(blockSizeFor({32, 64, 2}), 64);  // the paper's page
  EXPECT_EQ(blockSizeFor({64, 32, 32}), 64);
  EXPECT_EQ(blockSizeFor({32, 32, 32}), 32);
  EXPECT_EQ(blockSizeFor({1, 2, 128}), 128);
  EXPECT_EQ(blockSizeFor({1, 1, 1}), 4);  // with a ghost layer, the least that owns a cell
}

}  // namespace
}  // namespace sluice
