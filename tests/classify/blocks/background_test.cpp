// Blocks of background, which the ranges do not hold.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "src/base/error.h"
#include "tests/classify/blocks/classified.h"
#include "tests/support/function_source.h"

namespace sluice {
namespace {

using testing::AllOf;
using testing::HasSubstr;

SliceRanges sparseRanges(Vec3i dims, double background, std::vector<Box3> boxes, int64_t size) {
  VolumeLayout layout;
  layout.dims = dims;
  FunctionSource source(
      layout,
      [=](int64_t, Vec3i p) {
        for (const Box3& box : boxes)
          if (box.contains(p)) return 200.0;
        return background;
      },
      Occupancy{background, boxes});
  WorkerPool pool(2);
  ProgressMeter quiet;
  return buildSliceRanges(source, 0, blockLayout(dims, size, 0), {pool, quiet});
}

TEST(Background, invisibleBackgroundIsWhite) {
  const SliceRanges ranges = sparseRanges({100, 100, 100}, 0, {{{50, 50, 50}, {51, 51, 51}}}, 8);
  ASSERT_EQ(ranges.blocks.size(), 1U);
  const VisibleBlocks result = classified(ranges, threshold(100));
  EXPECT_EQ(result.blocks.size(), 1U);
  EXPECT_EQ(result.white, 15 * 15 * 15 - 1);
}

TEST(Background, visibleBackgroundFillsItsBlocks) {
  const SliceRanges ranges = sparseRanges({30, 30, 30}, 50, {{{10, 10, 10}, {12, 12, 12}}}, 8);
  ASSERT_EQ(ranges.blocks.size(), 1U);
  const VisibleBlocks result = classified(ranges, band(40, 60));
  ASSERT_EQ(static_cast<int64_t>(result.blocks.size()), ranges.layout.blockCount());
  EXPECT_EQ(result.white, 0);
  for (size_t i = 0; i < result.blocks.size(); ++i) {
    EXPECT_EQ(result.blocks[i].name.block, static_cast<int64_t>(i));
    if (result.blocks[i].name.block != ranges.blocks[0]) {
      EXPECT_EQ(result.blocks[i].kind, BlockClass::kBlack);
      EXPECT_EQ(result.blocks[i].cells,
                ranges.layout.ownedCells(ranges.layout.indexOf(static_cast<int64_t>(i))));
    }
  }
}

TEST(Background, visibleBackgroundIsCroppedToo) {
  const SliceRanges ranges = sparseRanges({30, 30, 30}, 50, {{{10, 10, 10}, {12, 12, 12}}}, 8);
  const Box3 crop{{5, 0, 7}, {8, 7, 29}};
  const VisibleBlocks result = classified(ranges, band(40, 60), crop);
  std::vector<Box3> expected;
  for (int64_t block = 0; block < ranges.layout.blockCount(); ++block) {
    const Box3 cells = intersect(ranges.layout.ownedCells(ranges.layout.indexOf(block)), crop);
    if (!cells.empty()) expected.push_back(cells);
  }
  ASSERT_EQ(result.blocks.size(), expected.size());
  for (size_t i = 0; i < expected.size(); ++i)
    if (result.blocks[i].name.block != ranges.blocks[0]) {
      EXPECT_EQ(result.blocks[i].cells, expected[i]);
    }
}

TEST(Background, moreVisibleBackgroundThanCanBeListedIsAnError) {
  const Vec3i dims{20000, 20000, 20000};
  const SliceRanges ranges = sparseRanges(dims, 50, {{{10, 10, 10}, {12, 12, 12}}}, 64);
  try {
    classified(ranges, band(40, 60));
    FAIL() << "nothing thrown";
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), AllOf(HasSubstr("(50)"), HasSubstr("crop")));
  }
  // The advice in the message works.
  const VisibleBlocks cropped = classified(ranges, band(40, 60), Box3{{0, 0, 0}, {126, 126, 63}});
  EXPECT_EQ(cropped.blocks.size(), 4U);
  EXPECT_EQ(classified(ranges, threshold(100)).blocks.size(), 1U);
}

}  // namespace
}  // namespace sluice
