// Cells that can show anything: all of them lie in the boxes, whatever the blocks.
#include "src/classify/blocks/visible_cells.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "src/classify/transfer/transfer_makers.h"
#include "tests/support/memory_source.h"
#include "tests/support/random_volume.h"

namespace sluice {
namespace {

struct Ranges {
  SliceRanges slices;
  BrickRanges bricks;
};
Ranges rangesOf(VolumeSource& source, int64_t block, int ghost = 0) {
  WorkerPool pool(2);
  ProgressMeter progress;
  Ranges ranges;
  ranges.slices = buildSliceRanges(source, 0, blockLayout(source.layout().dims, block, ghost),
                                   {pool, progress}, ranges.bricks);
  return ranges;
}
std::vector<Box3> visibleCells(const Ranges& ranges, const TransferFunction& transfer,
                               const Box3& crop) {
  return visibleCells(ranges.slices, ranges.bricks, transfer, crop);
}

// A value near `value` shows, and nothing else.
TransferFunction band(double value) {
  TransferFunction transfer;
  transfer.colors = {{0, {1, 1, 1}}};
  transfer.opacities = {{value - 8, 0}, {value, 0.5}, {value + 8, 0}};
  return transfer;
}

// A smooth ball of value 200 in the middle of nothing, of stored type T.
template <class T>
std::unique_ptr<MemorySource> ball(Vec3i dims, double radius) {
  return makeMemorySource<T>(dims, [=](auto x, auto y, auto z) {
    const double r = std::hypot(static_cast<double>(x) - 0.45 * static_cast<double>(dims.x),
                                static_cast<double>(y) - 0.5 * static_cast<double>(dims.y),
                                static_cast<double>(z) - 0.55 * static_cast<double>(dims.z));
    return std::round(200 * std::clamp(radius + 3 - r, 0.0, 6.0) / 6);
  });
}

double farthest(const std::vector<Box3>& boxes, Vec3d along) {
  double far = -std::numeric_limits<double>::infinity();
  for (const Box3& box : boxes) {
    Vec3d corner;
    for (int a = 0; a < 3; ++a)
      corner[a] = static_cast<double>(along[a] > 0 ? box.hi[a] : box.lo[a]);
    far = std::max(far, dot(corner, along));
  }
  return far;
}

// The cells whose own eight voxels span a value that shows, one at a time.
std::vector<Box3> cellsOneByOne(const MemorySource& source, const TransferFunction& transfer,
                                const Box3& crop) {
  std::vector<Box3> cells;
  for (int64_t z = crop.lo.z; z < crop.hi.z; ++z)
    for (int64_t y = crop.lo.y; y < crop.hi.y; ++y)
      for (int64_t x = crop.lo.x; x < crop.hi.x; ++x) {
        double lo = std::numeric_limits<double>::infinity(), hi = -lo;
        for (int corner = 0; corner < 8; ++corner) {
          const Vec3i p{x + (corner & 1), y + (corner >> 1 & 1), z + (corner >> 2)};
          const Vec3i dims = source.layout().dims;
          const double v = static_cast<double>(
              source.bytes()[static_cast<size_t>((p.z * dims.y + p.y) * dims.x + p.x)]);
          lo = std::min(lo, v);
          hi = std::max(hi, v);
        }
        bool shows = false;
        for (double v = lo; v <= hi; v += 0.5) shows = shows || opacityAt(transfer, v) > 0;
        if (shows) cells.push_back({{x, y, z}, {x + 1, y + 1, z + 1}});
      }
  return cells;
}

TEST(VisibleCells, holdEveryCellThatShowsAndLittleMore) {
  for (const Vec3i dims : {Vec3i{40, 50, 60}, Vec3i{150, 100, 90}}) {
    const auto source = ball<uint8_t>(dims, 17);
    const Ranges ranges = rangesOf(*source, 16);
    const auto side = static_cast<double>(ranges.bricks.side);
    for (const TransferFunction& transfer : {thresholdTransfer(120, {0, 200}), band(60)})
      for (const Box3& crop :
           {boxOf(dims - Vec3i{1, 1, 1}), Box3{{dims.x / 10, dims.y / 3, dims.z / 2},
                                               {dims.x * 2 / 3, dims.y * 3 / 5, dims.z - 1}}}) {
        const auto boxes = visibleCells(ranges, transfer, crop);
        const auto cells = cellsOneByOne(*source, transfer, crop);
        ASSERT_FALSE(cells.empty());
        for (const Box3& box : boxes) EXPECT_TRUE(crop.contains(box));
        for (int x = -1; x <= 1; ++x)
          for (int y = -1; y <= 1; ++y)
            for (int z = -1; z <= 1; ++z) {
              const Vec3d along = toDouble(Vec3i{x, y, z});
              const double slack = side * (std::abs(x) + std::abs(y) + std::abs(z));
              EXPECT_GE(farthest(boxes, along), farthest(cells, along));
              EXPECT_LE(farthest(boxes, along), farthest(cells, along) + (side > 1 ? slack : 0));
            }
      }
  }
}

TEST(VisibleCells, areWholeCellsAlongTheAxesHoweverLargeTheBricks) {
  const auto source = ball<uint8_t>({150, 100, 90}, 17);
  const Ranges ranges = rangesOf(*source, 16);
  ASSERT_GT(ranges.bricks.side, 1);
  const Box3 all = boxOf(Vec3i{149, 99, 89});
  const TransferFunction transfer = thresholdTransfer(120, {0, 200});
  const auto boxes = visibleCells(ranges, transfer, all);
  const auto cells = cellsOneByOne(*source, transfer, all);
  for (const Vec3d along :
       {Vec3d{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}})
    EXPECT_EQ(farthest(boxes, along), farthest(cells, along));
}

TEST(VisibleCells, areTheSameForAllBlocksLightsAndTypes) {
  const Vec3i dims{150, 100, 90};
  const auto bytes = ball<uint8_t>(dims, 20);
  const auto shorts = ball<int16_t>(dims, 20);
  const auto floats = ball<float>(dims, 20);
  const Box3 crop{{0, 10, 0}, {149, 99, 60}};
  const TransferFunction transfer = thresholdTransfer(77, {0, 200});
  const std::vector<Box3> expected = visibleCells(rangesOf(*bytes, 128), transfer, crop);
  ASSERT_FALSE(expected.empty());
  for (MemorySource* source : {bytes.get(), shorts.get(), floats.get()})
    for (const int64_t block : {8, 16, 64})
      for (const int ghost : {0, 1})
        EXPECT_EQ(visibleCells(rangesOf(*source, block, ghost), transfer, crop), expected)
            << block << " ghost " << ghost << " " << name(source->layout().type);
}

TEST(VisibleCells, areNoneWhereNothingShows) {
  const auto source = ball<uint8_t>({40, 40, 40}, 8);
  const Ranges ranges = rangesOf(*source, 16);
  const Box3 all = boxOf(Vec3i{39, 39, 39});
  EXPECT_TRUE(visibleCells(ranges, thresholdTransfer(201, {0, 200}), all).empty());
  EXPECT_TRUE(
      visibleCells(ranges, thresholdTransfer(100, {0, 200}), {{0, 0, 0}, {39, 5, 39}}).empty());
}

TEST(VisibleCells, areAllWhereTheBackgroundOfASparseVolumeShows) {
  BlobOptions options;
  options.dims = {60, 50, 40};
  options.blobs = 1;
  const auto source = makeSparseBlobs(options);
  const Ranges ranges = rangesOf(*source, 8);
  const Box3 all = boxOf(options.dims - Vec3i{1, 1, 1});
  TransferFunction everything;
  everything.colors = {{0, {1, 1, 1}}};
  everything.opacities = {{0, 0.5}};
  const auto boxes = visibleCells(ranges, everything, all);
  for (const Vec3d along : {Vec3d{1, 1, 1}, {-1, -1, -1}, {1, 0, 0}})
    EXPECT_EQ(farthest(boxes, along), farthest({all}, along));
}

TEST(AnyOpacity, seesBumpsBetweenTheEndsAndNothingBesideSteps) {
  TransferFunction transfer;
  transfer.colors = {{0, {1, 1, 1}}};
  transfer.opacities = {{10, 0}, {20, 0.5}, {20, 0}, {30, 0}, {40, 0.25}};
  EXPECT_TRUE(anyOpacity(transfer, 0, 50));
  EXPECT_TRUE(anyOpacity(transfer, 0, 20));
  EXPECT_FALSE(anyOpacity(transfer, 20, 30));
  EXPECT_FALSE(anyOpacity(transfer, 0, 10));
  EXPECT_TRUE(anyOpacity(transfer, 0, 10.1));
  EXPECT_TRUE(anyOpacity(transfer, 25, 30.1));
  EXPECT_TRUE(anyOpacity(transfer, 41, 99));
}

}  // namespace
}  // namespace sluice
