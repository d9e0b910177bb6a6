#include "src/texture/clusters.h"

#include <algorithm>
#include <map>
#include <set>
#include <tuple>
#include <unordered_map>
#include <utility>

#include "src/base/error.h"

namespace sluice {
namespace {

// A cache of this many rows of blocks has clusters of whole rows, which a file stores together.
constexpr int64_t kRowsOfACluster = 4;

VisitGrid gridOf(const LevelLayout& level) {
  return {level.width, level.blocks.grid};
}

// The grids of the levels that there are blocks of; the finest if there are none.
std::vector<VisitGrid> blockGrids(const TexturePlan& plan) {
  std::set<int32_t> levels;
  for (const TextureBlock& block : plan.blocks) levels.insert(block.name.level);
  if (levels.empty()) levels.insert(0);
  std::vector<VisitGrid> grids;
  // Coarse to fine, as the order of the visit goes down the grids.
  for (auto level = levels.rbegin(); level != levels.rend(); ++level)
    grids.push_back(gridOf(plan.pyramid.level(*level)));
  return grids;
}

// Blocks of one level.
void groupIntoBoxes(TexturePlan& plan, int64_t capacity_blocks) {
  const VisitGrid& blocks = plan.block_grids.front();
  plan.cluster_blocks = clusterBlocks(blocks.count, capacity_blocks);
  VisitGrid grid{blocks.width * plan.cluster_blocks, {}};
  for (int a = 0; a < 3; ++a) grid.count[a] = ceilDiv(blocks.count[a], plan.cluster_blocks[a]);
  plan.cluster_grids = {grid};
  std::unordered_map<int64_t, ClusterPosition> cluster_at;  // by linear index in the grid
  int64_t last_linear = -1;  // neighbours in a row share their cluster
  ClusterPosition position;
  for (const BlockPosition i : plan.blocks.indices()) {
    TextureBlock& block = plan.blocks[i];
    const BlockLayout& layout = plan.pyramid.of(block.name).blocks;
    const Vec3i index = layout.indexOf(block.name.block) / plan.cluster_blocks;
    const int64_t linear = (index.z * grid.count.y + index.y) * grid.count.x + index.x;
    if (linear != last_linear) {
      const auto [found, fresh] = cluster_at.emplace(linear, plan.clusters.endIndex());
      if (fresh) plan.clusters.push_back({.grid = 0, .index = index, .blocks = {}, .chunks = {}});
      position = found->second;
      last_linear = linear;
    }
    block.cluster = position;
    plan.clusters[block.cluster].blocks.push_back(i);
  }
}

class OctreeClusters {
 public:
  OctreeClusters(TexturePlan& plan, int64_t capacity_blocks)
      : plan_(plan), capacity_(static_cast<size_t>(capacity_blocks)) {}

  // Blocks in one cell of the grid.
  void add(size_t grid, Vec3i index, std::vector<BlockPosition> blocks) {
    size_t with_seams = blocks.size();
    for (const BlockPosition block : blocks)
      with_seams += static_cast<size_t>(plan_.seamsOf(block));
    if (with_seams > capacity_) {
      divide(grid + 1, blocks);
      return;
    }
    for (const BlockPosition block : blocks)
      plan_.blocks[block].cluster = plan_.clusters.endIndex();
    plan_.clusters.push_back(
        {.grid = grid, .index = index, .blocks = std::move(blocks), .chunks = {}});
  }

 private:
  // A cell of the finest grid has one block, which the cache holds with its seams: there is always
  // a finer grid.
  void divide(size_t grid, const std::vector<BlockPosition>& blocks) {
    std::map<std::tuple<int64_t, int64_t, int64_t>, std::vector<BlockPosition>> cells;
    // Regions of all levels are made of whole cells of any coarser grid, so that the corner alone
    // tells the cell.
    for (const BlockPosition block : blocks) {
      const Vec3i corner = plan_.pyramid.regionOf(plan_.blocks[block].name).lo;
      const Vec3i index = plan_.cluster_grids[grid].indexOf(corner);
      cells[{index.z, index.y, index.x}].push_back(block);
    }
    for (auto& [place, inside] : cells) {
      const auto& [z, y, x] = place;
      add(grid, {x, y, z}, std::move(inside));
    }
  }

  TexturePlan& plan_;
  const size_t capacity_;
};

}  // namespace

// u and v: whole rows if the cache has room for some, otherwise a square as nearly as powers of two
// allow, never wider than the grid.
Vec3i clusterBlocks(Vec3i grid, int64_t capacity_blocks) {
  int64_t u = 1;
  while (4 * u * u <= capacity_blocks) u *= 2;
  u = std::min(u, grid.x);
  if (capacity_blocks >= kRowsOfACluster * grid.x) u = grid.x;
  const int64_t v = std::min(capacity_blocks / u, grid.y);
  // A grid with few rows leaves capacity over, which makes clusters wider.
  return {std::min(capacity_blocks / v, grid.x), v, 1};
}

void groupIntoClusters(TexturePlan& plan, int64_t capacity_blocks) {
  plan.block_grids = blockGrids(plan);
  if (plan.block_grids.size() == 1) {
    groupIntoBoxes(plan, capacity_blocks);
    return;
  }
  plan.cluster_blocks = {1, 1, 1};
  plan.cluster_grids = plan.block_grids;
  // The root of the octree is one cell over the whole volume: if the cache has room for all blocks,
  // they are one cluster.
  plan.cluster_grids.insert(plan.cluster_grids.begin(), {plan.layout().dims, {1, 1, 1}});
  std::vector<BlockPosition> all;
  for (const BlockPosition block : plan.blocks.indices())
    if (!plan.blocks[block].isOfSeam()) all.push_back(block);
  OctreeClusters(plan, capacity_blocks).add(0, {0, 0, 0}, std::move(all));
  ClusterPosition last;
  for (TextureBlock& block : plan.blocks) {
    if (block.isOfSeam()) block.cluster = last;
    last = block.cluster;
  }
}

void groupAs(const TexturePlan& other, TexturePlan& plan) {
  plan.block_grids = other.block_grids;
  plan.cluster_grids = other.cluster_grids;
  plan.cluster_blocks = other.cluster_blocks;
  // The other plan is the union over several channels, which may show this one's blocks at other
  // time steps.
  std::map<std::pair<int32_t, int64_t>, ClusterPosition> cluster_of;  // by level and block
  for (const TextureBlock& block : other.blocks)
    cluster_of.emplace(std::pair(block.name.level, block.name.block), block.cluster);
  std::map<ClusterPosition, ClusterPosition> own;  // by the other plan's
  for (const BlockPosition i : plan.blocks.indices()) {
    const BlockName& name = plan.blocks[i].name;
    const auto found = cluster_of.find({name.level, name.block});
    SLUICE_CHECK(found != cluster_of.end());
    // Clusters without a block of this plan are left out, so that no cluster is empty.
    const auto [at, fresh] = own.emplace(found->second, plan.clusters.endIndex());
    if (fresh) {
      const Cluster& cluster = other.clusters[found->second];
      plan.clusters.push_back(
          {.grid = cluster.grid, .index = cluster.index, .blocks = {}, .chunks = {}});
    }
    plan.blocks[i].cluster = at->second;
    plan.clusters[at->second].blocks.push_back(i);
  }
}

}  // namespace sluice
