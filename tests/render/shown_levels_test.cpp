// ShownLevels against all blocks of the finest level, one by one.
#include "src/render/blocks/cut/shown_levels.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <random>
#include <vector>

#include "tests/render/level_scene.h"
#include "tests/support/function_source.h"

namespace sluice {
namespace {

// Each finest block that shows, with its object box.
using Boxes = std::map<int64_t, Box3>;

Vec3i extentOf(const Boxes& boxes, const BlockLayout& layout, int64_t block, const Box3& crop) {
  const Box3 own = boxes.at(block);
  Vec3i extent = own.size();
  for (int a = 0; a < 3; ++a)
    for (const int64_t side : {-1, 1}) {
      const int64_t face = side < 0 ? own.lo[a] : own.hi[a];
      if (face == (side < 0 ? crop.lo[a] : crop.hi[a]) && face > 0 && face < layout.dims[a] - 1)
        extent[a] = INT64_MAX / 2;  // the crop ends it
      Vec3i index = layout.indexOf(block);
      index[a] += side;
      if (index[a] < 0 || index[a] >= layout.grid[a]) continue;
      const auto next = boxes.find(layout.idOf(index));
      if (next == boxes.end()) continue;
      const Box3& other = next->second;
      bool touches = (side < 0 ? other.hi[a] : other.lo[a]) == face;
      for (int b = 0; b < 3; ++b)
        if (b != a) touches = touches && other.lo[b] <= own.hi[b] && own.lo[b] <= other.hi[b];
      if (touches) extent[a] += other.size()[a];
    }
  return extent;
}

struct Truth {
  Box3 hull;
  std::vector<Vec3i> extents;
};

Truth below(const Boxes& boxes, const PyramidLayout& pyramid, int level, int64_t block,
            const Box3& crop) {
  Truth truth;
  const Box3 inside = pyramid.finestBlocksOf({.level = level, .block = block});
  for (const auto& [finest, cells] : boxes) {
    const Vec3i index = pyramid.finest().indexOf(finest);
    if (!inside.contains({index, index + Vec3i{1, 1, 1}})) continue;
    truth.hull = unite(truth.hull, cells);
    truth.extents.push_back(extentOf(boxes, pyramid.finest(), finest, crop));
  }
  return truth;
}

// Blobs with a hollow and a plane in it: solid blocks, empty ones, and all in between.
double blobs(Vec3i v, int seed) {
  const Vec3d at = toDouble(v) * 0.06 + Vec3d{seed * 1.7, seed * 0.3, seed * 2.9};
  const double wave = std::sin(at.x) + std::cos(1.3 * at.y) + std::sin(0.7 * at.z + at.x);
  if (v.x == 70 + seed) return 250;
  return std::clamp(90 + 60 * wave, 0.0, 255.0);
}

TEST(ShownLevels, boundWhatAllBlocksBelowShow) {
  std::mt19937 random(3);
  int hulls = 0, thin = 0, thick = 0;
  for (int seed = 0; seed < 6; ++seed) {
    const Vec3i dims{150 + 7 * seed, 120, 97 + seed};
    FunctionSource source(functionLayout(dims, VoxelType::kU8),
                          [&](int64_t, Vec3i v) { return blobs(v, seed); });
    Pyramid pyramid(source, 4);
    const PyramidLayout& layout = pyramid.layout();
    Box3 crop = boxOf(dims - Vec3i{1, 1, 1});
    if (seed % 2 == 1) crop = {{13, 20, 0}, {120 + seed, 97, 90}};
    for (const double threshold : {20.0, 100.0, 170.0, 240.0}) {
      SCOPED_TRACE(testing::Message() << "seed " << seed << " above " << threshold);
      const auto look = std::make_shared<const Look>(
          makeLook(pyramid.step, opaqueAbove(threshold, 256), Mode::kComposite));
      Boxes boxes;
      int64_t cells = 0;
      for (const ObjectBlock& object :
           classify(*pyramid.step.ranges, look->table, crop, pyramid.pool).blocks) {
        boxes[object.name.block] = object.cells;
        cells += object.cells.count();
      }
      const auto tree =
          std::make_shared<const RangeTree>(*pyramid.step.ranges, layout, pyramid.pool);
      ShownLevels shown(pyramid.step, look, crop, tree, pyramid.pool);
      std::vector<std::pair<int, int64_t>> order;
      for (int level = 1; level < layout.levels(); ++level)
        for (int64_t block = 0; block < layout.level(level).blocks.blockCount(); ++block)
          order.emplace_back(level, block);
      std::ranges::shuffle(order, random);
      for (const auto& [level, block] : order) {
        SCOPED_TRACE(testing::Message() << "level " << level << " block " << block);
        const Truth truth = below(boxes, layout, level, block, crop);
        const Vec3i index = layout.level(level).blocks.indexOf(block);
        EXPECT_EQ(shown.partOf(level, index, 0).has_value(), !truth.hull.empty());
        bool is_thin = false;
        for (const Vec3i extent : truth.extents)
          for (int a = 0; a < 3; ++a)
            is_thin = is_thin ||
                      static_cast<double>(extent[a]) < 2 * layout.level(level).placement.scale[a];
        EXPECT_EQ(shown.hasThinParts(level, index), is_thin);
        hulls += truth.hull.empty() ? 0 : 1;
        ++(is_thin ? thin : thick);
      }
      EXPECT_EQ(shown.coarseShare(0), boxes.empty() ? 0 : 1);
      if (cells > 0) {
        EXPECT_EQ(shown.coarseShare(cells / 3),
                  1 - static_cast<double>(cells / 3) / static_cast<double>(cells));
      }
    }
  }
  EXPECT_GT(hulls, 100);
  EXPECT_GT(thin, 50);
  EXPECT_GT(thick, 50);
}

// Single voxels of a great value, few and far apart.
double specks(Vec3i v, int seed) {
  const auto number = static_cast<uint32_t>((v.x * 73 + v.y * 179 + v.z * 283 + seed) * 2654435761);
  return number % 4001 == 0 ? 250 : 10;
}

// The cells of a level that show something in a region because of this hull: the voxels that stand
// for some of it are interpolated in the cells on both sides of them.
Box3 reachOf(const Box3& hull, const LevelLayout& level, const Box3& region) {
  if (hull.empty()) return {};
  Box3 reach;
  for (int a = 0; a < 3; ++a) {
    const double scale = level.placement.scale[a], offset = level.placement.offset[a];
    const auto voxelAt = [&](int64_t cell) {
      return std::round((static_cast<double>(cell) - offset) / scale);
    };
    reach.lo[a] =
        static_cast<int64_t>(std::floor(offset + scale * (voxelAt(hull.lo[a]) - 1) + 1e-6));
    reach.hi[a] =
        static_cast<int64_t>(std::ceil(offset + scale * (voxelAt(hull.hi[a]) + 1) - 1e-6));
  }
  return intersect(reach, region);
}

// Levels with spreads show the hull itself, with what their interpolation carries beyond it.
TEST(ShownLevels, levelsThatFollowTheFinestReachAroundItsHull) {
  int parts = 0, whole = 0;
  for (const bool is_specks : {false, true})
    for (const Box3& crop : {boxOf(Vec3i{149, 119, 96}), Box3{{13, 20, 0}, {120, 97, 90}}}) {
      FunctionSource source(functionLayout({150, 120, 97}, VoxelType::kU8), [&](int64_t, Vec3i v) {
        return is_specks ? specks(v, 1) : blobs(v, 1);
      });
      Pyramid pyramid(source, 4, false, Spreads::kKept);
      const PyramidLayout& layout = pyramid.layout();
      for (const double threshold : {100.0, 200.0, 240.0}) {
        SCOPED_TRACE(testing::Message() << (is_specks ? "specks" : "blobs") << " from " << crop.lo.x
                                        << " above " << threshold);
        const auto look = std::make_shared<const Look>(
            makeLook(pyramid.step, opaqueAbove(threshold, 256), Mode::kComposite));
        Boxes boxes;
        for (const ObjectBlock& object :
             classify(*pyramid.step.ranges, look->table, crop, pyramid.pool).blocks)
          boxes[object.name.block] = object.cells;
        ShownLevels shown(
            pyramid.step, look, crop,
            std::make_shared<const RangeTree>(*pyramid.step.ranges, layout, pyramid.pool),
            pyramid.pool);
        for (int level = 1; level < layout.levels(); ++level) {
          const BlockLayout& blocks = layout.level(level).blocks;
          std::vector<Box3> hulls;
          for (int64_t block = 0; block < blocks.blockCount(); ++block)
            hulls.push_back(below(boxes, layout, level, block, crop).hull);
          for (int64_t block = 0; block < blocks.blockCount(); ++block) {
            const Vec3i index = blocks.indexOf(block);
            const Box3 region = layout.regionOf(level, index);
            Box3 expected;
            for (int64_t near = 0; near < blocks.blockCount(); ++near) {
              const Vec3i away = blocks.indexOf(near) - index;
              if (std::max({std::abs(away.x), std::abs(away.y), std::abs(away.z)}) <= 1)
                expected = unite(expected, reachOf(hulls[static_cast<size_t>(near)],
                                                   layout.level(level), region));
            }
            expected = intersect(expected, crop);
            const auto part = shown.partOf(level, index, 0);
            const Box3 cells = part ? part->cells : Box3();
            EXPECT_EQ(cells.empty(), expected.empty()) << level << " " << block;
            if (!expected.empty()) {
              EXPECT_EQ(cells, expected) << level << " " << block;
              ++parts;
              whole += expected == region ? 1 : 0;
            }
          }
        }
      }
    }
  EXPECT_GT(whole, 50);
  EXPECT_GT(parts, whole + 200);
}

}  // namespace
}  // namespace sluice
