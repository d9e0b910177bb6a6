// Pictures of cuts that may not wait for their data: whole at any time, better one after the other.
#include "src/render/blocks/cut/read_limit.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "tests/render/level_scene.h"

namespace sluice {
namespace {

class ReadLimitTest : public LevelCutTest {
 protected:
  ReadLimitTest()
      : source_(manyBlobs({120, 101, 95})), pyramid_(*source_, 4, false, Spreads::kKept) {
    options_.cut = CutOptions{.pixel_error = 1e-3};
  }
  VisibleBlocksPtr within(const ReadLimit* limit) const {
    return chosen(pyramid_, opaqueAbove(20, 255), options_, limit);
  }
  // Nothing may be read.
  static ReadLimit held(std::vector<BlockName> names) {
    ReadLimit limit;
    limit.is_in_memory = [names = std::move(names)](const BlockName& name) {
      return std::ranges::find(names, name) != names.end();
    };
    return limit;
  }
  static std::vector<BlockName> namesOf(const VisibleBlocks& blocks) {
    std::vector<BlockName> names;
    for (const ObjectBlock& block : blocks.blocks) names.push_back(block.name);
    return names;
  }
  std::vector<BlockName> allNames() const {
    std::vector<BlockName> names;
    for (int32_t level = 0; level < pyramid_.layout().levels(); ++level)
      for (int64_t block = 0; block < pyramid_.layout().level(level).blocks.blockCount(); ++block)
        names.push_back({.level = level, .block = block});
    return names;
  }

  const std::unique_ptr<MemorySource> source_;
  Pyramid pyramid_;
  FrameOptions options_;
};

TEST_F(ReadLimitTest, withNothingInMemoryTheCoarsestLevelIsShown) {
  const ReadLimit limit = held({});
  const VisibleBlocksPtr blocks = within(&limit);
  expectPartition(pyramid_, *blocks);
  EXPECT_EQ(levelsOf(*blocks), std::set<int32_t>{pyramid_.layout().levels() - 1});
  EXPECT_TRUE(blocks->cut->will_improve);
  EXPECT_FALSE(blocks->cut->is_final);
}

TEST_F(ReadLimitTest, withAllInMemoryTheCutIsTheOneWithoutALimit) {
  const ReadLimit limit = held(allNames());
  const VisibleBlocksPtr blocks = within(&limit), all = within(nullptr);
  ASSERT_EQ(blocks->blocks.size(), all->blocks.size());
  for (size_t i = 0; i < all->blocks.size(); ++i)
    EXPECT_EQ(blocks->blocks[i].name, all->blocks[i].name);
  EXPECT_TRUE(blocks->cut->is_final);
  EXPECT_FALSE(blocks->cut->will_improve);
}

TEST_F(ReadLimitTest, aParentIsShownUntilAllItsChildrenAreThere) {
  const VisibleBlocksPtr all = within(nullptr);
  const PyramidLayout& layout = pyramid_.layout();
  for (const ObjectBlock& missing : all->blocks) {
    ASSERT_EQ(missing.name.level, 0);
    std::vector<BlockName> names = allNames();
    std::erase(names, missing.name);
    const ReadLimit limit = held(names);
    const VisibleBlocksPtr blocks = within(&limit);
    expectPartition(pyramid_, *blocks);
    EXPECT_TRUE(blocks->cut->will_improve);
    // One block of the next level, in the place of its children; the rest as ever.
    const Box3 region = layout.regionOf(missing.name);
    int coarser = 0;
    for (const ObjectBlock& block : blocks->blocks) {
      if (block.name.level == 0) continue;
      ++coarser;
      EXPECT_EQ(block.name.level, 1);
      EXPECT_TRUE(layout.regionOf(block.name).contains(region));
    }
    EXPECT_EQ(coarser, 1);
  }
}

TEST_F(ReadLimitTest, asMuchIsRefinedAsTheBytesAllow) {
  size_t finest = 0;
  for (const uint64_t bytes : {0, 20'000, 200'000, 2'000'000}) {
    ReadLimit limit = held({});
    limit.most_bytes = bytes;
    const VisibleBlocksPtr blocks = within(&limit);
    expectPartition(pyramid_, *blocks);
    uint64_t taken = 0;
    for (const ObjectBlock& block : blocks->blocks)
      taken += static_cast<uint64_t>(pyramid_.layout().storedVoxels(block.name).count());
    if (bytes > 0) {
      EXPECT_LE(taken, bytes);
    }
    EXPECT_GE(blocks->blocks.size(), finest);
    finest = blocks->blocks.size();
  }
  EXPECT_EQ(finest, within(nullptr)->blocks.size());
}

TEST_F(ReadLimitTest, eachPictureIsBetterThanTheOneBefore) {
  VisibleBlocksPtr last;
  int pictures = 0;
  for (bool improves = true; improves; ++pictures) {
    ASSERT_LT(pictures, 1000);
    const std::vector<BlockName> names =
        last == nullptr ? std::vector<BlockName>() : namesOf(*last);
    ReadLimit limit = held(names);
    limit.refines_some = true;
    limit.last = last;
    const VisibleBlocksPtr blocks = within(&limit);
    expectPartition(pyramid_, *blocks);
    improves = blocks->cut->will_improve;
    EXPECT_NE(namesOf(*blocks), names);
    // Nothing gets coarser.
    if (last != nullptr) {
      EXPECT_TRUE(std::ranges::includes(blocks->refined, last->refined));
    }
    last = blocks;
  }
  EXPECT_GT(pictures, 3);
  EXPECT_EQ(last->blocks.size(), within(nullptr)->blocks.size());
}

TEST_F(ReadLimitTest, nothingInBetweenIsReadWhereTheWantedBlocksAreInMemory) {
  const VisibleBlocksPtr fine = within(nullptr);
  const ReadLimit limit = held(namesOf(*fine));
  const VisibleBlocksPtr blocks = within(&limit);
  EXPECT_EQ(namesOf(*blocks), namesOf(*fine));
  EXPECT_TRUE(blocks->cut->is_final);
}

TEST_F(ReadLimitTest, partsStayRefinedInAViewThatMovesALittle) {
  // Voxels of level 1 are a pixel wide at zoom 1, and a little less a moment later.
  const auto widthAt = [&](double zoom) {
    options_.camera.zoom = zoom;
    const View view = viewOf(pyramid_, options_);
    return 2.0 * view.size.height / (2 * view.half_height);
  };
  const double level_1_pixels = widthAt(1);
  options_.cut->pixel_error = 0.97 * level_1_pixels;
  const VisibleBlocksPtr before = within(nullptr);
  ASSERT_EQ(levelsOf(*before), std::set<int32_t>{0});
  options_.camera.zoom = 0.9;
  ASSERT_EQ(levelsOf(*within(nullptr)), std::set<int32_t>{1});
  ReadLimit limit = held(allNames());
  limit.last = before;
  EXPECT_EQ(levelsOf(*within(&limit)), std::set<int32_t>{1});
  limit.keeps_refined = true;
  EXPECT_EQ(levelsOf(*within(&limit)), std::set<int32_t>{0});
  options_.camera.zoom = 0.6;
  EXPECT_EQ(levelsOf(*within(&limit)), std::set<int32_t>{1}) << "clearly too fine";
}

TEST_F(ReadLimitTest, framesWithATimeLimitAreWholeAndEndAsTheOneWithout) {
  const auto session = sessionOf(pyramid_, opaqueAbove(20, 255));
  const auto other = sessionOf(pyramid_, opaqueAbove(20, 255));
  FrameOptions options = obliqueView(Projection::kOrtho);
  options.cut = options_.cut;
  options.step_follows_cut = true;
  const Drawn whole = draw(*other, options);
  options.time_limit_s = 0;
  const Drawn first = draw(*session, options);
  EXPECT_EQ(first.report.missing_share, 0.0);
  EXPECT_TRUE(first.report.cut->will_improve);
  EXPECT_EQ(first.report.cut->coarse_share, 1.0);
  EXPECT_EQ(first.report.step_vox, options.step_vox * 8) << "as the voxels of level 3";
  Drawn last = first;
  options.time_limit_s = 0.1;
  for (int i = 0; last.report.cut->will_improve; ++i) {
    ASSERT_LT(i, 1000);
    last = draw(*session, options);
    EXPECT_EQ(last.report.missing_share, 0.0);
  }
  EXPECT_EQ(last.report.step_vox, options.step_vox);
  EXPECT_EQ(last.picture.rgba, whole.picture.rgba);
  EXPECT_NE(first.picture.rgba, whole.picture.rgba);
}

}  // namespace
}  // namespace sluice
