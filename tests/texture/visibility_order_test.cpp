// clusterOrder and blockOrder against rays: of two boxes on a ray, the one that the ray leaves
// before it enters the other must be drawn first.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <optional>
#include <set>

#include "tests/texture/random_plan.h"

namespace sluice {
namespace {

struct Ray {
  Vec3d origin, direction;
};

struct Interval {
  double enter, leave;
};

// The part of the ray inside a box, cut at `from`; nothing if it only touches.
std::optional<Interval> inside(const Ray& ray, const Box3& box, double from) {
  Interval part{from, std::numeric_limits<double>::infinity()};
  for (int a = 0; a < 3; ++a) {
    const double lo = static_cast<double>(box.lo[a]) - ray.origin[a];
    const double hi = static_cast<double>(box.hi[a]) - ray.origin[a];
    if (ray.direction[a] == 0) {
      if (lo >= 0 || hi <= 0) return std::nullopt;
      continue;
    }
    const double one = lo / ray.direction[a], other = hi / ray.direction[a];
    part.enter = std::max(part.enter, std::min(one, other));
    part.leave = std::min(part.leave, std::max(one, other));
  }
  if (part.leave - part.enter < 1e-9) return std::nullopt;
  return part;
}

class VisibilityOrder : public testing::Test {
 protected:
  double unit() { return static_cast<double>(random_() >> 11) * 0x1p-53; }
  Vec3d direction() {
    for (;;) {
      const Vec3d d{2 * unit() - 1, 2 * unit() - 1, 2 * unit() - 1};
      if (length(d) > 0.1 && length(d) < 1) return normalized(d);
    }
  }
  Vec3d pointIn(Vec3d lo, Vec3d hi) { return lo + Vec3d{unit(), unit(), unit()} * (hi - lo); }

  // Blocks and small clusters of them.
  TexturePlan plan(Algorithm algorithm) {
    const BlockLayout layout = blockLayout({50, 36, 43}, 8, 0);
    const PageGeometry page{{8, 8, 1}, 1, algorithm == Algorithm::kMerged ? 64 : 32};
    return planTextures(layout, randomVisibleBlocks(layout, 0.6, random_), page,
                        planOptions(layout, algorithm));
  }

  // The same of a cut through three levels.
  TexturePlan cutPlan(Algorithm algorithm) {
    const PyramidLayout pyramid = threeLevels({50, 36, 43}, 8, 1);
    const PageGeometry page{{8, 8, 1}, 1, algorithm == Algorithm::kMerged ? 64 : 32};
    return planTextures(pyramid, randomCut(pyramid, 0.7, random_), page,
                        planOptions(pyramid.finest(), algorithm));
  }
  TexturePlan planOf(Algorithm algorithm, bool is_cut) {
    return is_cut ? cutPlan(algorithm) : plan(algorithm);
  }

  // All positions in plan.blocks in layers.
  static std::vector<BlockPosition> inLayers(const TexturePlan& plan, const EyePosition& eye) {
    std::vector<BlockPosition> all;
    for (const BlockPosition block : plan.blocks.indices()) all.push_back(block);
    return layerOrder(plan, all, eye);
  }
  // Positions in plan.blocks as they are drawn.
  static std::vector<BlockPosition> drawn(const TexturePlan& plan, const EyePosition& eye) {
    std::vector<BlockPosition> order;
    for (const ClusterPosition cluster : clusterOrder(plan, eye)) {
      const auto blocks = blockOrder(plan, plan.clusters[cluster], eye);
      order.insert(order.end(), blocks.begin(), blocks.end());
    }
    return order;
  }

  // All pairs of boxes that the ray goes through from `from` on.
  static void expectFrontToBack(const TexturePlan& plan, const std::vector<BlockPosition>& order,
                                const Ray& ray, double from, int64_t& pairs) {
    std::vector<Interval> parts;  // in the order of drawing
    for (const BlockPosition position : order)
      if (const auto part = inside(ray, plan.blocks[position].cells, from)) parts.push_back(*part);
    for (size_t i = 1; i < parts.size(); ++i) {
      ++pairs;
      ASSERT_LE(parts[i - 1].leave, parts[i].enter + 1e-9);
    }
  }

  std::mt19937_64 random_{1};
};

TEST_F(VisibilityOrder, everyBlockOfACutIsDrawnOnce) {
  const TexturePlan p = cutPlan(Algorithm::kMerged);
  std::set<int32_t> levels;
  for (const TextureBlock& block : p.blocks) levels.insert(block.name.level);
  EXPECT_EQ(levels.size(), 3U);
  std::vector<BlockPosition> order = drawn(p, {true, {1, -1, 0}});
  std::sort(order.begin(), order.end());
  EXPECT_EQ(order.size(), p.blocks.size());
  for (size_t i = 0; i < order.size(); ++i) EXPECT_EQ(order[i], BlockPosition(i));
  for (const Cluster& cluster : p.clusters) EXPECT_LE(cluster.blocks.size(), 8U);
  for (const Chunk& chunk : p.chunks)
    for (const BlockPosition block : chunk.blocks)
      EXPECT_EQ(p.blocks[block].name.level, p.blocks[chunk.blocks.front()].name.level);
}

TEST_F(VisibilityOrder, everyBlockIsDrawnOnce) {
  const TexturePlan p = plan(Algorithm::kMerged);
  std::vector<BlockPosition> order = drawn(p, {true, {1, -1, 0}});
  std::sort(order.begin(), order.end());
  for (size_t i = 0; i < order.size(); ++i) EXPECT_EQ(order[i], BlockPosition(i));
  EXPECT_EQ(order.size(), p.blocks.size());
  std::vector<BlockPosition> layers = inLayers(p, {true, {1, -1, 0}});
  std::sort(layers.begin(), layers.end());
  EXPECT_EQ(layers, order);
}

TEST_F(VisibilityOrder, layersGoThroughTheWholeFrontFirst) {
  const TexturePlan p = plan(Algorithm::kConventional);
  int64_t last = 0;
  for (const BlockPosition position : inLayers(p, {true, {1, 1, 1}})) {
    const Vec3i index = p.layout().indexOf(p.blocks[position].name.block);
    EXPECT_GE(index.x + index.y + index.z, last);
    last = index.x + index.y + index.z;
  }
}

// A thousand random views each.
TEST_F(VisibilityOrder, parallelViewsAreFrontToBack) {
  int64_t pairs = 0;
  for (const Algorithm algorithm :
       {Algorithm::kConventional, Algorithm::kTrimmed, Algorithm::kMerged})
    for (int view = 0; view < 680; ++view) {
      const TexturePlan p = planOf(algorithm, view % 4 < 2);
      const Vec3d d = direction();
      const std::vector<BlockPosition> order = drawn(p, {true, d}), layers = inLayers(p, {true, d});
      for (int ray = 0; ray < 20; ++ray) {
        const Ray r{pointIn({0, 0, 0}, toDouble(p.layout().dims)) - d * 200, d};
        expectFrontToBack(p, order, r, 0, pairs);
        expectFrontToBack(p, layers, r, 0, pairs);
        if (HasFatalFailure()) FAIL() << "direction " << d.x << ' ' << d.y << ' ' << d.z;
      }
    }
  EXPECT_GT(pairs, 20000);
}

TEST_F(VisibilityOrder, viewsAlongAnAxisAreFrontToBack) {
  int64_t pairs = 0;
  for (int axis = 0; axis < 3; ++axis)
    for (const double sign : {-1.0, 1.0, -2.0, 2.0}) {
      const TexturePlan p = planOf(Algorithm::kTrimmed, std::abs(sign) == 2);
      Vec3d d{0, 0, 0};
      d[axis] = sign < 0 ? -1 : 1;
      const std::vector<BlockPosition> order = drawn(p, {true, d}), layers = inLayers(p, {true, d});
      for (int ray = 0; ray < 1000; ++ray) {
        const Ray r{pointIn({0, 0, 0}, toDouble(p.layout().dims)) - d * 200, d};
        expectFrontToBack(p, order, r, 0, pairs);
        expectFrontToBack(p, layers, r, 0, pairs);
        if (HasFatalFailure()) FAIL() << "axis " << axis << " sign " << sign;
      }
    }
  EXPECT_GT(pairs, 1500);
}

TEST_F(VisibilityOrder, perspectiveViewsAreFrontToBackFromOutsideAndInside) {
  int64_t pairs = 0;
  for (const Algorithm algorithm :
       {Algorithm::kConventional, Algorithm::kTrimmed, Algorithm::kMerged})
    for (int view = 0; view < 680; ++view) {
      const TexturePlan p = planOf(algorithm, view % 4 < 2);
      const Vec3d dims = toDouble(p.layout().dims);
      const bool eye_inside = view % 2 == 0;
      Vec3d eye = eye_inside ? pointIn({0, 0, 0}, dims) : pointIn(dims * -2.0, dims * 3.0);
      // On a boundary of blocks now and then.
      const auto side = static_cast<double>(p.layout().cells());
      if (view % 5 == 0) eye.x = std::floor(eye.x / side) * side;
      const std::vector<BlockPosition> order = drawn(p, {false, eye}),
                                       layers = inLayers(p, {false, eye});
      for (int ray = 0; ray < 20; ++ray) {
        const Ray r{eye, normalized(pointIn({0, 0, 0}, dims) - eye)};
        expectFrontToBack(p, order, r, 0, pairs);
        expectFrontToBack(p, layers, r, 0, pairs);
        if (HasFatalFailure()) FAIL() << "eye " << eye.x << ' ' << eye.y << ' ' << eye.z;
      }
    }
  EXPECT_GT(pairs, 20000);
}

}  // namespace
}  // namespace sluice
