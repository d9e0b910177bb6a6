#include "src/classify/blocks/classification.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <random>

#include "tests/classify/blocks/classified.h"
#include "tests/support/random_volume.h"

namespace sluice {
namespace {

double unit(std::mt19937_64& random) {
  return static_cast<double>(random() >> 11) * 0x1p-53;
}

// Threshold, band or several bands with soft and hard sides, each wider than a table entry.
TransferFunction randomTransfer(std::mt19937_64& random, ValueRange range) {
  const double span = range.hi - range.lo;
  const int bands = static_cast<int>(random() % 4);
  if (bands == 0) return threshold(range.lo + span * unit(random));
  std::vector<OpacityPoint> points;
  for (int i = 0; i < bands; ++i) {
    const double part = span / bands, lo = range.lo + part * i + 0.3 * part * unit(random);
    const double hi = lo + part * (0.05 + 0.5 * unit(random));
    const double side = random() % 2 == 0 ? 0 : 0.1 * (hi - lo);
    points.insert(points.end(), {{lo, 0}, {lo + side, 0.5}, {hi - side, 0.3}, {hi, 0}});
  }
  return transferOf(points);
}

struct Volume {
  std::unique_ptr<MemorySource> source;
  SliceRanges ranges;

  // Device value of a voxel: the types used here are held as they are stored.
  double at(Vec3i p) const {
    const Vec3i dims = ranges.layout.dims;
    return visitDeviceType(ranges.map.type, [&](auto tag) {
      std::memcpy(&tag,
                  source->bytes().data() +
                      ((p.z * dims.y + p.y) * dims.x + p.x) * static_cast<int64_t>(sizeof tag),
                  sizeof tag);
      return static_cast<double>(tag);
    });
  }
  ValueRange rangeOf(const Box3& voxels) const {
    ValueRange range{1e300, -1e300};
    for (int64_t z = voxels.lo.z; z < voxels.hi.z; ++z)
      for (int64_t y = voxels.lo.y; y < voxels.hi.y; ++y)
        for (int64_t x = voxels.lo.x; x < voxels.hi.x; ++x) {
          range.lo = std::min(range.lo, at({x, y, z}));
          range.hi = std::max(range.hi, at({x, y, z}));
        }
    return range;
  }
};

Volume volumeOf(std::unique_ptr<MemorySource> source, int64_t size, int ghost = 0) {
  WorkerPool pool(2);
  ProgressMeter quiet;
  SliceRanges ranges =
      buildSliceRanges(*source, 0, blockLayout(source->layout().dims, size, ghost), {pool, quiet});
  return {std::move(source), std::move(ranges)};
}

// The table's entries one at a time; the neighbours count too, for rounding.
bool anyOpaque(const OpacityTable& table, ValueRange range) {
  const int lo = std::max(0, table.entryOf(range.lo) - 1);
  const int hi = std::min(table.entries() - 1, table.entryOf(range.hi) + 1);
  for (int entry = lo; entry <= hi; ++entry)
    if (table.opacity()[static_cast<size_t>(entry)] > 0) return true;
  return false;
}

// The object box of a block by its definition, from the voxels.
Box3 objectBox(const Volume& volume, const OpacityTable& table, int64_t block) {
  const Box3 owned = volume.ranges.layout.ownedCells(volume.ranges.layout.indexOf(block));
  Box3 box = owned;
  for (int axis = 0; axis < 3; ++axis) {
    int64_t first = owned.hi[axis], last = owned.lo[axis];
    for (int64_t slab = owned.lo[axis]; slab < owned.hi[axis]; ++slab) {
      Box3 voxels{owned.lo, owned.hi + Vec3i{1, 1, 1}};
      voxels.lo[axis] = slab;
      voxels.hi[axis] = slab + 2;  // the planes on both sides
      if (!anyOpaque(table, volume.rangeOf(voxels))) continue;
      first = std::min(first, slab);
      last = std::max(last, slab + 1);
    }
    if (first >= last) return {};
    box.lo[axis] = first;
    box.hi[axis] = last;
  }
  return box;
}

std::vector<Volume> randomVolumes() {
  std::vector<Volume> volumes;
  for (const VoxelType type : {VoxelType::kU8, VoxelType::kU16, VoxelType::kF32})
    for (const int ghost : {0, 1}) {
      BlobOptions options;
      options.type = type;
      options.dims = {33, 27, 30};
      options.seed = 11 + static_cast<uint64_t>(ghost);
      volumes.push_back(volumeOf(makeSparseBlobs(options), 8, ghost));
      volumes.push_back(volumeOf(makeWhiteNoise({19, 20, 17}, type, 5), 8, ghost));
    }
  return volumes;
}

TEST(Classification, objectBoxesAreThoseOfTheDefinition) {
  std::mt19937_64 random(1);
  for (const Volume& volume : randomVolumes())
    for (int trial = 0; trial < 6; ++trial) {
      const TransferFunction transfer = randomTransfer(random, volume.ranges.device_range);
      const OpacityTable table(transfer, volume.ranges.map, volume.ranges.device_range);
      const VisibleBlocks result = classified(volume.ranges, transfer);
      const BlockLayout& layout = volume.ranges.layout;
      size_t next = 0;
      int64_t white = 0, grey = 0, black = 0;
      for (int64_t block = 0; block < layout.blockCount(); ++block) {
        const Box3 expected = objectBox(volume, table, block);
        if (expected.empty()) {
          ++white;
          ASSERT_TRUE(next == result.blocks.size() || result.blocks[next].name.block != block);
          continue;
        }
        ASSERT_LT(next, result.blocks.size());
        const ObjectBlock& found = result.blocks[next++];
        ASSERT_EQ(found.name.block, block);
        ASSERT_EQ(found.cells, expected);
        const bool whole = expected == layout.ownedCells(layout.indexOf(block));
        ASSERT_EQ(found.kind, whole ? BlockClass::kBlack : BlockClass::kGrey);
        ++(whole ? black : grey);
      }
      EXPECT_EQ(next, result.blocks.size());
      EXPECT_EQ(result.white, white);
      EXPECT_EQ(result.grey, grey);
      EXPECT_EQ(result.black, black);
    }
}

TEST(Classification, noSampleOutsideTheObjectBoxesIsVisible) {
  std::mt19937_64 random(2);
  int64_t outside = 0;
  for (const Volume& volume : randomVolumes())
    for (int trial = 0; trial < 4; ++trial) {
      const BlockLayout& layout = volume.ranges.layout;
      const TransferFunction transfer = randomTransfer(random, volume.ranges.device_range);
      const VisibleBlocks result = classified(volume.ranges, transfer);
      std::map<int64_t, Box3> boxes;
      for (const ObjectBlock& object : result.blocks) boxes[object.name.block] = object.cells;
      const Vec3i cells = layout.dims - Vec3i{1, 1, 1};
      for (int64_t z = 0; z < cells.z; ++z)
        for (int64_t y = 0; y < cells.y; ++y)
          for (int64_t x = 0; x < cells.x; ++x) {
            const Vec3i cell{x, y, z};
            const auto box = boxes.find(layout.idOf(cell / layout.cells()));
            if (box != boxes.end() && box->second.contains(cell)) continue;
            ++outside;
            // Interpolation stays between the least and the greatest corner; every value between
            // them occurs in the cell. The transfer function itself must deny it, not its table.
            const ValueRange corners = volume.rangeOf({cell, cell + Vec3i{2, 2, 2}});
            for (int step = 0; step <= 8; ++step) {
              const double device = std::lerp(corners.lo, corners.hi, step / 8.0);
              ASSERT_EQ(opacityAt(transfer, volume.ranges.map.valueOf(device)), 0)
                  << x << ' ' << y << ' ' << z << " value " << device;
            }
          }
    }
  EXPECT_GT(outside, 10000);  // there was something to look at
}

TEST(Classification, aSurfaceBetweenTwoPlanesIsFound) {
  // No voxel is in the band, every cell between the two halves is.
  const Volume volume =
      volumeOf(makeMemorySource<uint8_t>(Vec3i{15, 15, 15},
                                         [](auto x, auto, auto) { return x < 5 ? 10 : 200; }),
               8);
  const VisibleBlocks result = classified(volume.ranges, band(90, 110));
  ASSERT_EQ(result.blocks.size(), 4U);  // half of the 2 x 2 x 2 blocks
  EXPECT_EQ(result.blocks[0].cells, (Box3{{4, 0, 0}, {5, 7, 7}}));
  EXPECT_EQ(result.grey, 4);
  EXPECT_EQ(result.white, 4);
}

TEST(Classification, allVisibleIsBlackAndNothingVisibleIsWhite) {
  const Volume volume = volumeOf(makeWhiteNoise({22, 15, 8}, VoxelType::kU8, 1), 8);
  const VisibleBlocks all = classified(volume.ranges, threshold(-1));
  EXPECT_EQ(all.black, volume.ranges.layout.blockCount());
  EXPECT_EQ(all.grey + all.white, 0);
  const VisibleBlocks none = classified(volume.ranges, transferOf({{0, 0}}));
  EXPECT_EQ(none.white, volume.ranges.layout.blockCount());
  EXPECT_TRUE(none.blocks.empty());
}

TEST(Classification, theTrimmingAxisIsTheShortestAndTheLastOfEquals) {
  // A box of voxels of 200 in a block of 64; its cells reach one further on each side.
  const auto axisOf = [](Vec3i size) {
    const Box3 box{{10, 10, 10}, Vec3i{10, 10, 10} + size};
    const Volume volume =
        volumeOf(makeMemorySource<uint8_t>(Vec3i{64, 64, 64},
                                           [&](auto x, auto y, auto z) {
                                             return box.contains(Vec3i{x, y, z}) ? 200 : 0;
                                           }),
                 64);
    const VisibleBlocks result = classified(volume.ranges, threshold(199));
    EXPECT_EQ(result.blocks.at(0).cells, (Box3{box.lo - Vec3i{1, 1, 1}, box.hi}));
    return result.blocks.at(0).trimming_axis;
  };
  EXPECT_EQ(axisOf({3, 9, 9}), 0);
  EXPECT_EQ(axisOf({9, 3, 9}), 1);
  EXPECT_EQ(axisOf({9, 9, 3}), 2);
  EXPECT_EQ(axisOf({5, 5, 9}), 1);
  EXPECT_EQ(axisOf({5, 9, 5}), 2);
  EXPECT_EQ(axisOf({9, 5, 5}), 2);
  EXPECT_EQ(axisOf({5, 5, 5}), 2);
}

TEST(Classification, aCropCutsBlocksAndBoxes) {
  std::mt19937_64 random(3);
  for (const Volume& volume : randomVolumes()) {
    const BlockLayout& layout = volume.ranges.layout;
    const TransferFunction transfer = randomTransfer(random, volume.ranges.device_range);
    const VisibleBlocks whole = classified(volume.ranges, transfer);
    Box3 crop;
    for (int a = 0; a < 3; ++a) {
      crop.lo[a] = static_cast<int64_t>(random() % 10);
      crop.hi[a] = crop.lo[a] + 1 + static_cast<int64_t>(random() % 12);
    }
    const VisibleBlocks cut = classified(volume.ranges, transfer, crop);
    std::vector<ObjectBlock> expected;
    for (ObjectBlock object : whole.blocks) {
      object.cells = intersect(object.cells, crop);
      if (!object.cells.empty()) expected.push_back(object);
    }
    ASSERT_EQ(cut.blocks.size(), expected.size());
    for (size_t i = 0; i < expected.size(); ++i) {
      EXPECT_EQ(cut.blocks[i].name.block, expected[i].name.block);
      EXPECT_EQ(cut.blocks[i].cells, expected[i].cells);
      const Box3 owned = layout.ownedCells(layout.indexOf(expected[i].name.block));
      EXPECT_EQ(cut.blocks[i].kind == BlockClass::kBlack, expected[i].cells == owned);
    }
    EXPECT_EQ(cut.white, layout.blockCount() - static_cast<int64_t>(expected.size()));
  }
}

TEST(Classification, anEmptyCropShowsNothing) {
  const Volume volume = volumeOf(makeWhiteNoise({22, 15, 8}, VoxelType::kU8, 1), 8);
  EXPECT_TRUE(classified(volume.ranges, threshold(-1), Box3{}).blocks.empty());
}

TEST(Classification, doesNotDependOnTheNumberOfThreads) {
  // More blocks than one task takes.
  const Volume volume = volumeOf(makeWhiteNoise({46, 46, 46}, VoxelType::kU8, 8), 4);
  ASSERT_GT(volume.ranges.layout.blockCount(), 3000);
  const VisibleBlocks one = classified(volume.ranges, band(250, 253), std::nullopt, 1);
  const VisibleBlocks many = classified(volume.ranges, band(250, 253), std::nullopt, 7);
  ASSERT_EQ(one.blocks.size(), many.blocks.size());
  for (size_t i = 0; i < one.blocks.size(); ++i) {
    EXPECT_EQ(one.blocks[i].name.block, many.blocks[i].name.block);
    EXPECT_EQ(one.blocks[i].cells, many.blocks[i].cells);
  }
  EXPECT_EQ(one.white, many.white);
}

TEST(Classification, notANumberShowsAsTheLowEnd) {
  const double nan = std::nan("");
  const Volume volume =
      volumeOf(makeMemorySource<float>(Vec3i{15, 8, 8},
                                       [&](auto x, auto, auto) { return x < 3 ? nan : 5.0; }),
               8);
  // Around the NaN every value below 5 is interpolated.
  const VisibleBlocks low = classified(volume.ranges, band(4, 4.5));
  EXPECT_EQ(low.blocks.size(), 0U);  // the table ends at the least number there is, 5
  const VisibleBlocks high = classified(volume.ranges, threshold(4.9));
  EXPECT_EQ(high.white, 0);
}

// By their definition: each block's hull of what lies within a cell of any object box, with cells
// beside the crop among them.
TEST(ClassifyAround, takesInTheCellsBesideVisibleOnes) {
  std::mt19937_64 random(12);
  WorkerPool pool(2);
  int grown = 0, woken = 0;
  for (int trial = 0; trial < 12; ++trial) {
    const Volume volume = volumeOf(makeSparseBlobs({.dims = {41, 37, 33}, .seed = random()}), 8, 1);
    const SliceRanges& ranges = volume.ranges;
    const OpacityTable table(randomTransfer(random, {0, 255}), ranges.map, ranges.device_range);
    const Box3 all = allCells(ranges.layout);
    const Box3 crop = trial % 2 == 0 ? all : Box3{{4, 7, 2}, {33, 30, 29}};
    const auto around = [](const Box3& cells) {
      return Box3{cells.lo - Vec3i{1, 1, 1}, cells.hi + Vec3i{1, 1, 1}};
    };
    const VisibleBlocks exact = classify(ranges, table, intersect(around(crop), all), pool);
    const VisibleBlocks result = classifyAround(ranges, table, crop, pool);
    size_t next = 0;
    for (int64_t block = 0; block < ranges.layout.blockCount(); ++block) {
      const Box3 owned = ranges.layout.ownedCells(ranges.layout.indexOf(block));
      Box3 expected, own;
      for (const ObjectBlock& object : exact.blocks) {
        if (object.name.block == block) own = intersect(object.cells, crop);
        const Box3 part = intersect(intersect(around(object.cells), crop), owned);
        if (!part.empty()) expected = expected.empty() ? part : unite(expected, part);
      }
      const bool listed = next < result.blocks.size() && result.blocks[next].name.block == block;
      ASSERT_EQ(listed ? result.blocks[next++].cells : Box3(), expected) << block;
      grown += !own.empty() && !(own == expected) ? 1 : 0;
      woken += own.empty() && !expected.empty() ? 1 : 0;
    }
    EXPECT_EQ(next, result.blocks.size()) << "each once, ascending";
    EXPECT_EQ(result.white + result.grey + result.black, ranges.layout.blockCount());
  }
  EXPECT_GT(grown, 50);
  EXPECT_GT(woken, 50);
}

}  // namespace
}  // namespace sluice
