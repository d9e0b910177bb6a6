// The growing boxes that are drawn: every visible cell once, in an order that no ray contradicts.
#include "src/render/blocks/visible_boxes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "src/classify/transfer/transfer_makers.h"
#include "tests/support/random_volume.h"

namespace sluice {
namespace {

// A block of random blobs with its bricks, and a transfer function.
struct Block {
  explicit Block(uint64_t seed) {
    BlobOptions options;
    options.dims = {34, 29, 31};
    options.seed = seed;
    source = makeSparseBlobs(options);
    voxels.resize(static_cast<size_t>(volume(options.dims)));
    source->readRegion(0, boxOf(options.dims), voxels);
    cells = boxOf(options.dims - Vec3i{1, 1, 1});
    grid = brickGrid({boxOf(options.dims), DeviceType::kU8, voxels.data()}, cells, 4);
    tree = growBoxTree(grid, growingParameters(DeviceType::kU8, {0, 200}));
  }
  OpacityTable tableOf(double threshold) const {
    return {thresholdTransfer(threshold, {0, 200}, 0.2, "viridis"),
            deviceMap(source->layout()),
            {0, 200}};
  }
  BoxVisibility seen(const OpacityTable& table) const { return {table, source->layout()}; }
  // By a plain loop over the cell's corners.
  bool shows(Vec3i cell, const OpacityTable& table) const {
    const Vec3i dims = source->layout().dims;
    int lo = 255, hi = 0;
    for (int corner = 0; corner < 8; ++corner) {
      const Vec3i p = cell + Vec3i{corner & 1, (corner >> 1) & 1, corner >> 2};
      const int value =
          static_cast<int>(voxels[static_cast<size_t>((p.z * dims.y + p.y) * dims.x + p.x)]);
      lo = std::min(lo, value), hi = std::max(hi, value);
    }
    return table.shown().anyIn(lo, hi);
  }

  std::unique_ptr<MemorySource> source;
  std::vector<std::byte> voxels;
  Box3 cells;
  BrickGrid grid;
  BoxTree tree;
};

std::vector<Box3> inOrder(const VisibleBoxes& drawn, const BoxEye& eye) {
  std::vector<Box3> boxes;
  drawn.visitFrontToBack(eye, [&](const Box3& box) { boxes.push_back(box); });
  return boxes;
}

const BoxCost kCosts[] = {{0, 0}, {1, 50}, {6, 1500}, {100, 1e6}};

TEST(VisibleBoxes, holdEveryVisibleCellOnceWithinTheClip) {
  for (const uint64_t seed : {1, 2, 3})
    for (const double threshold : {10.0, 80.0, 150.0})
      for (const BoxCost& cost : kCosts) {
        const Block block(seed);
        const OpacityTable table = block.tableOf(threshold);
        const Box3 clip = seed == 1 ? block.cells : Box3{{3, 2, 5}, {30, 21, 29}};
        const VisibleBoxes drawn(block.tree, block.seen(table), clip, cost);
        const std::vector<Box3> boxes = inOrder(drawn, {true, {1, -1, 1}});
        EXPECT_EQ(boxes.size(), drawn.count());
        int64_t visible = 0, wrong = 0;
        for (int64_t z = 0; z < block.cells.hi.z; ++z)
          for (int64_t y = 0; y < block.cells.hi.y; ++y)
            for (int64_t x = 0; x < block.cells.hi.x; ++x) {
              const auto held = std::count_if(boxes.begin(), boxes.end(), [&](const Box3& box) {
                return box.contains(Vec3i{x, y, z});
              });
              const bool inside = clip.contains(Vec3i{x, y, z});
              const bool shows = inside && block.shows({x, y, z}, table);
              visible += shows ? 1 : 0;
              wrong += held > 1 || (held == 1 && !inside) || (held == 0 && shows) ? 1 : 0;
            }
        EXPECT_EQ(wrong, 0);
        EXPECT_GT(visible, 0);
        int64_t cells = 0;
        for (const Box3& box : boxes) cells += box.count();
        if (cost.a_box == 0) {
          EXPECT_LT(cells, clip.count() * 9 / 10) << "nothing is skipped";
        } else if (cost.a_box == 1e6) {
          EXPECT_EQ(boxes.size(), 1U) << "one box is cheapest";
        }
      }
}

TEST(VisibleBoxes, costsDecideOnlyHowMany) {
  const Block block(4);
  const OpacityTable table = block.tableOf(60);
  size_t before = SIZE_MAX;
  double before_cells = 0;
  for (const BoxCost& cost : kCosts) {
    const VisibleBoxes drawn(block.tree, block.seen(table), block.cells, cost);
    double cells = 0;
    for (const Box3& box : inOrder(drawn, {true, {1, 1, 1}}))
      cells += static_cast<double>(box.count());
    EXPECT_LE(drawn.count(), before);
    EXPECT_GE(cells, before_cells);
    before = drawn.count();
    before_cells = cells;
  }
}

TEST(VisibleBoxes, noneWhereNothingShows) {
  const Block block(5);
  const OpacityTable table = block.tableOf(5000);
  const VisibleBoxes drawn(block.tree, block.seen(table), block.cells, {6, 1500});
  EXPECT_EQ(drawn.count(), 0U);
  EXPECT_TRUE(inOrder(drawn, {true, {1, 0, 0}}).empty());
}

// Rays are random: parallel, and from an eye outside, inside and on a corner.
TEST(VisibleBoxes, comeFrontToBackAlongEveryRay) {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> unit(-1, 1), share(0, 1);
  const Vec3d size{33, 28, 30};
  int64_t crossings = 0;
  for (int i = 0; i < 300; ++i) {
    const Block block(static_cast<uint64_t>(i % 3 + 1));
    const OpacityTable table = block.tableOf(60);
    const VisibleBoxes drawn(block.tree, block.seen(table), block.cells, {0.3, 10});
    BoxEye eye;
    eye.parallel = i % 2 == 0;
    eye.at = eye.parallel ? Vec3d{unit(random), unit(random), unit(random)}
                          : Vec3d{2 * unit(random), 2 * unit(random), 2 * unit(random)} * size;
    if (i % 50 == 1) eye.at = {0, 0, 0};
    const std::vector<Box3> boxes = inOrder(drawn, eye);
    for (int ray = 0; ray < 40; ++ray) {
      const Vec3d target = Vec3d{share(random), share(random), share(random)} * size;
      const Vec3d direction = normalized(eye.parallel ? eye.at : target - eye.at);
      const double length_to = eye.parallel ? 60 : length(target - eye.at);
      size_t last = 0;
      for (double t = -length_to; t < 60; t += 0.25) {
        const Vec3d p = target + direction * t;
        for (size_t b = 0; b < boxes.size(); ++b) {
          const Box3& box = boxes[b];
          const bool inside = p.x >= box.lo.x && p.x < box.hi.x && p.y >= box.lo.y &&
                              p.y < box.hi.y && p.z >= box.lo.z && p.z < box.hi.z;
          if (!inside) continue;
          ASSERT_GE(b, last) << "eye " << i << ", ray " << ray;
          crossings += b > last ? 1 : 0;
          last = b;
        }
      }
    }
  }
  EXPECT_GT(crossings, 10000);
}

}  // namespace
}  // namespace sluice
