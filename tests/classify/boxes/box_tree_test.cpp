// The order of the boxes along random rays, and the properties that a conversion must keep.
#include "src/classify/boxes/box_tree.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <set>

#include "tests/classify/boxes/partition.h"
#include "tests/support/random_volume.h"
#include "tests/support/tree_visit.h"

namespace sluice::box_tree_test {
namespace {

struct Ray {
  Vec3d from, along;
};

// The interval of the ray inside the box, shrunk by a little; lo > hi: it misses.
ValueRange inside(const Ray& ray, const Box3& box) {
  constexpr double kNear = 1e-6;
  ValueRange t{0, std::numeric_limits<double>::max()};
  for (int a = 0; a < 3; ++a) {
    const double lo = static_cast<double>(box.lo[a]) + kNear,
                 hi = static_cast<double>(box.hi[a]) - kNear;
    if (ray.along[a] == 0) {
      if (ray.from[a] < lo || ray.from[a] > hi) return {1, 0};
      continue;
    }
    const double x = (lo - ray.from[a]) / ray.along[a], y = (hi - ray.from[a]) / ray.along[a];
    t.lo = std::max(t.lo, std::min(x, y));
    t.hi = std::min(t.hi, std::max(x, y));
  }
  return t;
}

// Positions of the boxes that the ray goes through, from its origin on.
std::vector<size_t> alongRay(const std::vector<GrownBox>& boxes, const Ray& ray) {
  std::vector<std::pair<double, size_t>> hit;
  for (size_t i = 0; i < boxes.size(); ++i) {
    const ValueRange t = inside(ray, boxes[i].local());
    if (t.lo < t.hi) hit.emplace_back(t.lo, i);
  }
  std::sort(hit.begin(), hit.end());
  std::vector<size_t> order;
  for (const auto& [t, box] : hit) order.push_back(box);
  return order;
}

class Views {
 public:
  explicit Views(Vec3i cells) : cells_(toDouble(cells)) {}
  BoxEye next() {
    BoxEye eye;
    eye.parallel = random_() % 2 == 0;
    if (eye.parallel) {
      eye.at = direction();
      // People ask for straight views first.
      if (random_() % 4 == 0) eye.at[static_cast<int>(random_() % 3)] = 0;
      if (eye.at == Vec3d{}) eye.at = {0, 0, 1};
    } else {
      // Inside the block as often as outside, sometimes on a plane between cells.
      for (int a = 0; a < 3; ++a) eye.at[a] = cells_[a] * (2 * unit_(random_) - 0.5);
      if (random_() % 4 == 0) eye.at.x = std::floor(eye.at.x);
    }
    return eye;
  }
  Ray rayOf(const BoxEye& eye) {
    Vec3d target;
    for (int a = 0; a < 3; ++a) target[a] = cells_[a] * unit_(random_);
    if (!eye.parallel) return {eye.at, target - eye.at};
    return {target - eye.at * (2 * length(cells_) / length(eye.at)), eye.at};
  }

 private:
  Vec3d direction() {
    return {2 * unit_(random_) - 1, 2 * unit_(random_) - 1, 2 * unit_(random_) - 1};
  }
  Vec3d cells_;
  std::mt19937_64 random_{7};
  std::uniform_real_distribution<double> unit_{0, 1};
};

void expectOrderRight(const BoxTree& tree, Vec3i cells, int views, int rays) {
  Views random(cells);
  size_t pairs = 0;
  for (int view = 0; view < views; ++view) {
    const BoxEye eye = random.next();
    std::vector<size_t> rank(tree.boxes.size(), tree.boxes.size());
    size_t next = 0;
    visitFrontToBack(tree, eye, [&](size_t box) {
      ASSERT_EQ(rank[box], tree.boxes.size()) << "visited twice";
      rank[box] = next++;
    });
    ASSERT_EQ(next, tree.boxes.size()) << "left out";
    for (int i = 0; i < rays; ++i) {
      const std::vector<size_t> order = alongRay(tree.boxes, random.rayOf(eye));
      for (size_t at = 1; at < order.size(); ++at) {
        ASSERT_LT(rank[order[at - 1]], rank[order[at]]) << "view " << view;
        ++pairs;
      }
    }
  }
  EXPECT_GT(pairs, static_cast<size_t>(views)) << "too few pairs to mean anything";
}

// Rooms are halved down to the leaves' boxes; textures share the block out and hold their boxes.
void expectWhole(const BoxTree& tree, Vec3i cells) {
  struct Visit {
    int32_t node;
    Box3 room;
  };
  std::vector<Visit> stack{{0, boxOf(cells)}};
  size_t leaves = 0, nodes = 0;
  while (!stack.empty()) {
    const auto [at, room] = stack.back();
    stack.pop_back();
    ++nodes;
    const TreeNode& node = tree.nodes.at(static_cast<size_t>(at));
    if (node.isLeaf()) {
      EXPECT_EQ(tree.boxes.at(static_cast<size_t>(node.box)).local(), room);
      ++leaves;
      continue;
    }
    EXPECT_GT(node.lower, at);
    EXPECT_GT(node.upper, at);
    Box3 low = room, high = room;
    low.hi[node.axis] = high.lo[node.axis] = node.plane;
    EXPECT_FALSE(low.empty() || high.empty());
    stack.push_back({node.lower, low});
    stack.push_back({node.upper, high});
  }
  EXPECT_EQ(leaves, tree.boxes.size());
  EXPECT_EQ(nodes, tree.nodes.size());

  ASSERT_EQ(tree.texture_of.size(), tree.boxes.size());
  int64_t stored = 0;
  std::vector<size_t> pieces(tree.textures.size());
  for (size_t i = 0; i < tree.boxes.size(); ++i) {
    const GrownBox& texture = tree.textures.at(tree.texture_of[i]);
    EXPECT_TRUE(texture.local().contains(tree.boxes[i].local()));
    ++pieces[tree.texture_of[i]];
  }
  for (size_t i = 0; i < pieces.size(); ++i) {
    EXPECT_GE(pieces[i], 1U);
    stored += tree.textures[i].local().count();
  }
  EXPECT_EQ(stored, volume(cells)) << "no cell's voxels are stored twice for one block";
}

// Bricks of one cell, each from a given value to `width` above it.
BrickGrid gridOf(Vec3i size, const std::vector<float>& values, float width = 0) {
  BrickGrid grid;
  grid.cells = boxOf(size);
  grid.side = 1;
  grid.size = size;
  for (const float value : values) grid.bricks.push_back({value, value + width, 0, 0});
  return grid;
}

GrownBox boxAt(const BrickGrid& grid, const Box3& cells) {
  return boxOfBricks(grid, grid.bricksOf(cells), {});
}

TEST(BoxTree, randomVolumesAreInOrderFromThousandViews) {
  for (const uint64_t seed : {1, 2}) {
    const auto blobs = makeSparseBlobs({.dims = {40, 36, 33}, .seed = seed, .blobs = 9});
    const DeviceVolume volume(*blobs);
    const BrickGrid grid = brickGrid(volume.span(), volume.cells(), kSide);
    const BoxTree tree = growBoxTree(grid, {});
    ASSERT_GT(tree.boxes.size(), 30U);
    expectWhole(tree, volume.cells().size());
    expectOrderRight(tree, volume.cells().size(), 1000, 4);
  }
}

TEST(BoxTree, everyTypeKeepsTheCellsAndTheirIntervals) {
  for (const VoxelType type : {VoxelType::kU8, VoxelType::kI16, VoxelType::kU16, VoxelType::kF32}) {
    SCOPED_TRACE(name(type));
    const auto blobs = makeSparseBlobs({.type = type, .seed = 4});
    const DeviceVolume volume(*blobs);
    for (const int64_t block_vox : {16, 32}) expectRight(volume, treePartition(volume, block_vox));
  }
}

// Two cells long each, and turned so that from some sides each is in front of the next one.
constexpr std::array<Box3, 5> kCycle = {Box3{{0, 0, 0}, {2, 1, 1}}, Box3{{0, 0, 1}, {1, 2, 2}},
                                        Box3{{1, 1, 0}, {2, 2, 2}}, Box3{{0, 1, 0}, {1, 2, 1}},
                                        Box3{{1, 0, 1}, {2, 1, 2}}};

// Values so far apart that nothing merges. x fastest: bars 0, 50, 100, the rest 150 and 200.
BrickGrid cycleGrid() {
  return gridOf({2, 2, 2}, {0, 0, 150, 100, 50, 200, 50, 100});
}

TEST(BoxTree, aCycleIsCut) {
  const BrickGrid grid = cycleGrid();
  std::vector<GrownBox> boxes;
  for (const Box3& box : kCycle) boxes.push_back(boxAt(grid, box));
  // Not one order of the five serves all rays of some view.
  Views random({2, 2, 2});
  bool cyclic = false;
  for (const Vec3d along : {Vec3d{1, 1, 1}, {1, 1, -1}, {1, -1, 1}, {-1, 1, 1}}) {
    std::set<std::pair<size_t, size_t>> before;
    for (int i = 0; i < 2000; ++i) {
      const auto order = alongRay(boxes, random.rayOf({true, along}));
      for (size_t at = 1; at < order.size(); ++at) before.emplace(order[at - 1], order[at]);
    }
    cyclic = cyclic ||
             (before.contains({0, 1}) && before.contains({1, 2}) && before.contains({2, 0})) ||
             (before.contains({1, 0}) && before.contains({2, 1}) && before.contains({0, 2}));
  }
  ASSERT_TRUE(cyclic) << "the arrangement is none";

  const BoxTree tree = boxTree(grid, boxes, {});
  EXPECT_EQ(tree.grown, 5U);
  EXPECT_GT(tree.boxes.size(), 5U) << "one was cut";
  EXPECT_EQ(tree.textures.size(), 5U) << "its pieces share its texture";
  expectWhole(tree, {2, 2, 2});
  expectOrderRight(tree, {2, 2, 2}, 1000, 8);
}

TEST(BoxTree, oneBoxIsALeaf) {
  const BrickGrid grid = gridOf({2, 1, 1}, {5, 5});
  const GrownBox box = boxAt(grid, {{0, 0, 0}, {2, 1, 1}});
  const BoxTree tree = boxTree(grid, std::array{box}, {});
  EXPECT_EQ(tree.boxes, std::vector{box});
  EXPECT_EQ(tree.textures, std::vector{box});
  std::vector<size_t> visited;
  visitFrontToBack(tree, {true, {1, 0, 0}}, [&](size_t i) { visited.push_back(i); });
  EXPECT_EQ(visited, std::vector<size_t>{0});
}

TEST(BoxTree, fewestBoxesAreCut) {
  // A long box above, two below that meet in its middle: only the plane between above and below
  // cuts nothing.
  const BrickGrid grid = gridOf({4, 2, 1}, {200, 200, 0, 0, 100, 100, 100, 100});
  const std::array boxes = {boxAt(grid, {{0, 0, 0}, {2, 1, 1}}),
                            boxAt(grid, {{2, 0, 0}, {4, 1, 1}}),
                            boxAt(grid, {{0, 1, 0}, {4, 2, 1}})};
  const BoxTree tree = boxTree(grid, boxes, {});
  EXPECT_EQ(tree.boxes.size(), 3U);
  EXPECT_EQ(tree.nodes.front().axis, 1);
  EXPECT_EQ(tree.nodes.front().plane, 1);
}

TEST(BoxTree, uniformSiblingsMergeToAUniformBoxOnly) {
  GrowingParameters parameters;
  parameters.least_uniform_cells = 1;
  const auto boxesAfter = [&](float left, float right) {
    const BrickGrid grid = gridOf(
        {8, 4, 4},
        [&] {
          std::vector<float> values;
          for (int i = 0; i < 8 * 4 * 4; ++i) values.push_back(i % 8 < 4 ? left : right);
          return values;
        }(),
        1);
    const std::array boxes = {boxOfBricks(grid, {{0, 0, 0}, {4, 4, 4}}, parameters),
                              boxOfBricks(grid, {{4, 0, 0}, {8, 4, 4}}, parameters)};
    return boxTree(grid, boxes, parameters).boxes.size();
  };
  EXPECT_EQ(boxesAfter(10, 41), 1U);
  EXPECT_EQ(boxesAfter(10, 42), 2U) << "wider than a uniform box may be";
}

// A thin sheet joins its neighbour although their types differ; a thick one does not.
TEST(BoxTree, thinBoxesJoinTheirSiblings) {
  const auto boxesAfter = [](int64_t thickness) {
    BrickGrid grid = gridOf({8, 8, 8}, std::vector<float>(512, 10), 1);
    for (int64_t z = 0; z < thickness; ++z)
      for (int64_t i = 0; i < 64; ++i)
        grid.bricks[static_cast<size_t>(64 * z + i)] = {20, 21, 0, 9};  // a faint gradient
    const std::array boxes = {boxAt(grid, {{0, 0, 0}, {8, 8, thickness}}),
                              boxAt(grid, {{0, 0, thickness}, {8, 8, 8}})};
    EXPECT_NE(boxes[0].type, boxes[1].type);
    return boxTree(grid, boxes, {}).boxes.size();
  };
  EXPECT_EQ(boxesAfter(1), 1U);
  EXPECT_EQ(boxesAfter(4), 2U);
}

}  // namespace
}  // namespace sluice::box_tree_test
