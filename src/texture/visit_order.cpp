// The orders in which a plan's clusters and blocks are visited; see texture_plan.h.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <span>
#include <vector>

#include "src/texture/texture_plan.h"

namespace sluice {
namespace {

// Smaller is nearer along this axis; two blocks share a rank only on opposite sides of the eye,
// where neither can hide the other. `cells` is the width of one step of the index.
int64_t rankOf(int64_t index, int64_t cells, const EyePosition& eye, int axis) {
  // The eye of a parallel view has no cell: the index itself tells which of two cells is nearer.
  if (eye.parallel) return eye.index[axis] >= 0 ? index : -index;
  const auto at = static_cast<int64_t>(std::floor(eye.index[axis] / static_cast<double>(cells)));
  return std::abs(index - at);
}

// Three numbers that order the cells of one grid, smaller ones first.
using CellRank = std::array<int64_t, 3>;

// Sorts items by the ranks of the cells that they are in, from the coarsest grid to the one that
// each is a cell of; equals in the order given.
class GridOrder {
 public:
  // Reserves room for `count` items over at most `grids` grids.
  GridOrder(size_t count, size_t grids) : finer_grids_(grids - 1) {
    items_.reserve(count);
    finer_.reserve(count * finer_grids_);
  }
  // The next item, its ranks coarse to fine. Requires: ranks not empty.
  void add(std::span<const CellRank> ranks) {
    items_.push_back({ranks.front(), ranks.size(), items_.size()});
    finer_.insert(finer_.end(), ranks.begin() + 1, ranks.end());
    // Items in coarse grids have fewer ranks. They are padded, so that an item's ranks are found by
    // its position.
    finer_.resize(items_.size() * finer_grids_);
  }
  // Positions of the items as they were added.
  template <class Visit>
  void visitSorted(Visit&& visit) {
    std::sort(items_.begin(), items_.end(), [this](const Item& a, const Item& b) {
      if (a.rank != b.rank) return a.rank < b.rank;
      return isBeforeInside(a, b);
    });
    for (const Item& item : items_) visit(item.position);
  }

 private:
  struct Item {
    CellRank rank;  // in the coarsest grid, here because that decides nearly always
    size_t grids;
    size_t position;
  };
  bool isBeforeInside(const Item& a, const Item& b) const {
    const CellRank* of_a = finer_.data() + a.position * finer_grids_;
    const CellRank* of_b = finer_.data() + b.position * finer_grids_;
    for (size_t i = 0; i + 1 < std::min(a.grids, b.grids); ++i)
      if (of_a[i] != of_b[i]) return of_a[i] < of_b[i];
    // A cell, and something inside a cell of the same rank, which lies on another side of the eye.
    if (a.grids != b.grids) return a.grids < b.grids;
    return a.position < b.position;
  }

  const size_t finer_grids_;
  std::vector<Item> items_;
  std::vector<CellRank> finer_;  // ranks of each item in all grids but the coarsest
};

CellRank rankIn(const VisitGrid& grid, Vec3i corner, const EyePosition& eye) {
  const Vec3i index = grid.indexOf(corner);
  CellRank rank;
  for (int a = 0; a < 3; ++a)
    rank[static_cast<size_t>(a)] = rankOf(index[a], grid.width[a], eye, a);
  return rank;
}

// The blocks sorted by `rank_of` applied to the ranks of their cells along the axes.
std::vector<BlockPosition> sortedBlocks(const TexturePlan& plan,
                                        std::span<const BlockPosition> blocks,
                                        const EyePosition& eye, const auto& rank_of) {
  GridOrder order(blocks.size(), plan.block_grids.size());
  std::vector<CellRank> ranks;
  for (const BlockPosition position : blocks) {
    const BlockName& name = plan.blocks[position].name;
    const LevelLayout& level = plan.pyramid.of(name);
    // A grid's cell is found from the finest cells, since blocks of all levels have their corner
    // there.
    const Vec3i corner = level.blocks.indexOf(name.block) * level.width;
    ranks.clear();
    for (const VisitGrid& grid : plan.block_grids) {
      ranks.push_back(rank_of(rankIn(grid, corner, eye)));
      // A block is no larger than its own level's cells: finer grids cannot order it.
      if (grid.width == level.width) break;
    }
    order.add(ranks);
  }
  std::vector<BlockPosition> positions;
  positions.reserve(blocks.size());
  order.visitSorted([&](size_t i) { positions.push_back(blocks[i]); });
  return positions;
}

}  // namespace

std::vector<ClusterPosition> clusterOrder(const TexturePlan& plan, const EyePosition& eye) {
  GridOrder order(plan.clusters.size(), plan.cluster_grids.size());
  std::vector<CellRank> ranks;
  for (const Cluster& cluster : plan.clusters) {
    const Vec3i corner = cluster.index * plan.cluster_grids[cluster.grid].width;
    ranks.clear();
    for (size_t grid = 0; grid <= cluster.grid; ++grid)
      ranks.push_back(rankIn(plan.cluster_grids[grid], corner, eye));
    order.add(ranks);
  }
  std::vector<ClusterPosition> positions;
  positions.reserve(plan.clusters.size());
  order.visitSorted([&](size_t i) { positions.emplace_back(i); });
  return positions;
}

std::vector<BlockPosition> blockOrder(const TexturePlan& plan, const Cluster& cluster,
                                      const EyePosition& eye) {
  return sortedBlocks(plan, cluster.blocks, eye, [](const CellRank& rank) { return rank; });
}

std::vector<BlockPosition> layerOrder(const TexturePlan& plan,
                                      std::span<const BlockPosition> blocks,
                                      const EyePosition& eye) {
  // Along a ray no axis' rank descends, and one ascends from cell to cell.
  return sortedBlocks(plan, blocks, eye, [](const CellRank& rank) {
    return CellRank{rank[0] + rank[1] + rank[2], 0, 0};
  });
}

}  // namespace sluice
