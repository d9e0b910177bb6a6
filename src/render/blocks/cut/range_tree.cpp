#include "src/render/blocks/cut/range_tree.h"

#include <algorithm>
#include <span>

namespace sluice {
namespace {

void widen(RangeTree::Node& node, const RangeTree::Node& by) {
  node.has_unknown = node.has_unknown || by.has_unknown;
  // A node without known blocks has no range.
  if (by.lo > by.hi) return;
  const bool is_first = node.lo > node.hi;
  node.lo = is_first ? by.lo : std::min(node.lo, by.lo);
  node.hi = is_first ? by.hi : std::max(node.hi, by.hi);
}

// Widens the nodes of one row along x by a row of finest blocks, with one search in the list of the
// blocks that are held.
template <class T>
void widenRow(std::span<RangeTree::Node> nodes, int64_t blocks_a_node, const SliceRanges& ranges,
              int64_t first_block) {
  const std::span<const PlaneRange<T>> totals = ranges.totalsAs<T>();
  const auto background = static_cast<float>(ranges.background);
  const int64_t end = first_block + ranges.layout.grid.x;
  auto held = std::ranges::lower_bound(ranges.blocks, first_block);
  auto unknown = std::ranges::lower_bound(ranges.unknown, first_block);
  int64_t block = first_block;
  for (RangeTree::Node& node : nodes) {
    // The last one has the rest of the row.
    const bool is_last = &node == &nodes.back();
    for (const int64_t end_of_node = is_last ? end : std::min(end, block + blocks_a_node);
         block < end_of_node; ++block) {
      if (held != ranges.blocks.end() && *held == block) {
        const PlaneRange<T>& total = totals[static_cast<size_t>(held - ranges.blocks.begin())];
        widen(node, {static_cast<float>(total.lo), static_cast<float>(total.hi), false});
        ++held;
      } else if (unknown != ranges.unknown.end() && *unknown == block) {
        node.has_unknown = true;
        ++unknown;
      } else {
        // A block that is neither held nor unknown is all background.
        widen(node, {background, background, false});
      }
    }
  }
}

// The nodes of the level above the finest one, on all threads of the pool.
template <class T>
std::vector<RangeTree::Node> firstLevelOf(const SliceRanges& finest, const PyramidLayout& pyramid,
                                          WorkerPool& pool) {
  const Vec3i grid = pyramid.level(1).blocks.grid;
  const int64_t blocks_a_node = pyramid.level(1).width.x / pyramid.level(0).width.x;
  std::vector<RangeTree::Node> nodes(static_cast<size_t>(volume(grid)));
  // A thread has whole rows of nodes, so that no two write the same one.
  pool.parallelFor(grid.z * grid.y, [&](int64_t row) {
    const auto of_row =
        std::span(nodes).subspan(static_cast<size_t>(row * grid.x), static_cast<size_t>(grid.x));
    const Box3 children = pyramid.childrenOf(1, {0, row % grid.y, row / grid.y});
    for (int64_t z = children.lo.z; z < children.hi.z; ++z)
      for (int64_t y = children.lo.y; y < children.hi.y; ++y)
        widenRow<T>(of_row, blocks_a_node, finest, finest.layout.idOf({0, y, z}));
  });
  return nodes;
}

// All nodes of a level, on all threads of the pool.
template <class Of>
std::vector<RangeTree::Node> levelOf(const PyramidLayout& pyramid, int level, WorkerPool& pool,
                                     const Of& of) {
  // Parts are so large that handing one out costs little.
  constexpr int64_t kPart = 512;
  const BlockLayout& blocks = pyramid.level(level).blocks;
  std::vector<RangeTree::Node> nodes(static_cast<size_t>(blocks.blockCount()));
  pool.parallelFor((blocks.blockCount() + kPart - 1) / kPart, [&](int64_t part) {
    const int64_t end = std::min(blocks.blockCount(), (part + 1) * kPart);
    for (int64_t block = part * kPart; block < end; ++block)
      nodes[static_cast<size_t>(block)] = of(pyramid.childrenOf(level, blocks.indexOf(block)));
  });
  return nodes;
}

}  // namespace

RangeTree::RangeTree(const SliceRanges& finest, const PyramidLayout& pyramid, WorkerPool& pool) {
  if (pyramid.levels() < 2) return;
  levels_.push_back(visitDeviceType(finest.map.type, [&](auto tag) {
    return firstLevelOf<decltype(tag)>(finest, pyramid, pool);
  }));
  // Each level is made of the one below, which has fewer nodes than there are blocks.
  for (int level = 2; level < pyramid.levels(); ++level)
    levels_.push_back(levelOf(pyramid, level, pool, [&](const Box3& children) {
      Node node;
      const BlockLayout& below = pyramid.level(level - 1).blocks;
      for (int64_t z = children.lo.z; z < children.hi.z; ++z)
        for (int64_t y = children.lo.y; y < children.hi.y; ++y)
          for (int64_t x = children.lo.x; x < children.hi.x; ++x)
            widen(node, of(level - 1, below.idOf({x, y, z})));
      return node;
    }));
}

}  // namespace sluice
