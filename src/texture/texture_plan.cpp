#include "src/texture/texture_plan.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>
#include <unordered_map>

#include "src/base/error.h"
#include "src/base/large_pages.h"

namespace sluice {
namespace {

constexpr std::array<std::string_view, 4> kAlgorithmNames = {"conventional", "clipped", "trimmed",
                                                             "merged"};
// Most blocks that the conventional algorithm may list.
constexpr int64_t kMostBlocks = int64_t{1} << 26;

// A cache of this many rows of blocks has clusters of whole rows, which a file stores together.
constexpr int64_t kRowsOfACluster = 4;

// u and v: whole rows where the cache has room for some, otherwise a square as nearly as powers of
// two allow, never wider than the grid.
Vec3i clusterBlocks(const BlockLayout& layout, int64_t capacity_blocks) {
  int64_t u = 1;
  while (4 * u * u <= capacity_blocks) u *= 2;
  u = std::min(u, layout.grid.x);
  if (capacity_blocks >= kRowsOfACluster * layout.grid.x) u = layout.grid.x;
  const int64_t v = std::min(capacity_blocks / u, layout.grid.y);
  return {std::min(capacity_blocks / v, layout.grid.x), v, 1};
}

// The whole block, drawn whole (I) or clipped to its object box (II).
TextureBlock wholeBlock(const BlockLayout& layout, const ObjectBlock& object) {
  TextureBlock result;
  result.name = object.name;
  result.voxels = layout.cube(layout.indexOf(object.name.block));
  result.cells = object.cells;
  return result;
}

// Section 3.2.2: trimmed along one axis, 2^d along the others.
TextureBlock trimmedBlock(const BlockLayout& layout, const ObjectBlock& object) {
  TextureBlock result = wholeBlock(layout, object);
  const int axis = result.trimming_axis = object.trimming_axis;
  result.voxels.lo[axis] = object.cells.lo[axis] - layout.ghost;
  result.voxels.hi[axis] = object.cells.hi[axis] + 1 + layout.ghost;
  return result;
}

void addBlocks(TexturePlan& plan, const VisibleBlocks& visible, const PlanOptions& options) {
  const BlockLayout& layout = plan.layout;
  const Algorithm algorithm = options.algorithm;
  auto& blocks = plan.blocks;
  if (algorithm == Algorithm::kTrimmed || algorithm == Algorithm::kMerged) {
    reserveLarge(blocks, visible.blocks.size());
    for (const ObjectBlock& object : visible.blocks) blocks.push_back(trimmedBlock(layout, object));
    return;
  }
  if (layout.blockCount() > kMostBlocks)
    fail("--algorithm {} loads every block, here {}; use trimmed or merged", name(algorithm),
         layout.blockCount());
  reserveLarge(blocks, static_cast<size_t>(layout.blockCount()));
  size_t next = 0;
  for (int64_t block = 0; block < layout.blockCount(); ++block) {
    ObjectBlock object;
    object.name = {.time = options.time, .block = block};
    if (next < visible.blocks.size() && visible.blocks[next].name.block == block)
      object = visible.blocks[next++];
    if (algorithm == Algorithm::kConventional)
      object.cells = intersect(layout.ownedCells(layout.indexOf(block)), options.crop);
    blocks.push_back(wholeBlock(layout, object));
  }
}

void groupIntoClusters(TexturePlan& plan) {
  std::unordered_map<int64_t, ClusterPosition> cluster_at;  // by linear index in the grid
  int64_t last_linear = -1;  // neighbours in a row share their cluster
  ClusterPosition position;
  for (const BlockPosition i : plan.blocks.indices()) {
    TextureBlock& block = plan.blocks[i];
    const Vec3i index = plan.layout.indexOf(block.name.block) / plan.cluster_blocks;
    const int64_t linear =
        (index.z * plan.cluster_grid.y + index.y) * plan.cluster_grid.x + index.x;
    if (linear != last_linear) {
      const auto [found, fresh] = cluster_at.emplace(linear, plan.clusters.endIndex());
      if (fresh) plan.clusters.push_back({index, {}, {}});
      position = found->second;
      last_linear = linear;
    }
    block.cluster = position;
    plan.clusters[block.cluster].blocks.push_back(i);
  }
}

MergeBlock mergeBlock(const TexturePlan& plan, BlockPosition position) {
  return {position.value(), plan.blocks[position].texels().z};
}

// Each block a chunk.
void addSingleChunks(TexturePlan& plan) {
  reserveLarge(plan.chunks, plan.blocks.size());
  for (const BlockPosition i : plan.blocks.indices()) {
    TextureBlock& block = plan.blocks[i];
    const ChunkPosition position = plan.chunks.endIndex();
    const Vec3i size{plan.layout.size, plan.layout.size, block.texels().z};
    block.chunk = position;
    plan.clusters[block.cluster].chunks.push_back(position);
    plan.chunks.push_back({size, plan.page.pagesOf(size), {i}});
  }
}

// Gives each block its chunk and place, and each cluster of a block the chunk. Whether there are
// two.
bool addChunk(TexturePlan& plan, const MergedChunk& merged) {
  const BlockPosition first(merged.columns[0].blocks[0].block);
  const ClusterPosition first_cluster = plan.blocks[first].cluster;
  bool is_between = false;
  const ChunkPosition number = plan.chunks.endIndex();
  const int64_t side = plan.layout.size;
  Chunk chunk;
  size_t count = 0;
  for (const Column& column : merged.columns) count += column.blocks.size();
  chunk.blocks.reserve(count);
  for (size_t c = 0; c < merged.columns.size(); ++c) {
    int64_t z = 0;
    for (const MergeBlock& piled : merged.columns[c].blocks) {
      const BlockPosition position(piled.block);
      TextureBlock& block = plan.blocks[position];
      block.chunk = number;
      block.at = {static_cast<int64_t>(c) * side, 0, z};
      z += piled.thickness;
      chunk.blocks.push_back(position);
      is_between = is_between || block.cluster != first_cluster;
      std::vector<ChunkPosition>& of_cluster = plan.clusters[block.cluster].chunks;
      if (of_cluster.empty() || of_cluster.back() != number) of_cluster.push_back(number);
    }
  }
  chunk.size_vox = {static_cast<int64_t>(merged.columns.size()) * side, side, merged.thickness()};
  chunk.pages = plan.page.pagesOf(chunk.size_vox);
  plan.chunks.push_back(std::move(chunk));
  return is_between;
}

// Sections 3.2.3.2 and 3.2.3.3.
void mergeChunks(TexturePlan& plan, MergeOrder order) {
  const int64_t limit = plan.layout.size;
  const auto pagesOf = [&](const MergedChunk& chunk) {
    return plan.page.pagesOf(
        {static_cast<int64_t>(chunk.columns.size()) * limit, limit, chunk.thickness()});
  };
  IndexedVector<ClusterPosition, std::vector<MergedChunk>> merged(plan.clusters.size());
  IndexedVector<ClusterPosition, int64_t> pages(plan.clusters.size());
  // By x, y, z of the cluster.
  std::map<std::tuple<int64_t, int64_t, int64_t>, ClusterPosition> by_row;
  for (const ClusterPosition i : plan.clusters.indices()) {
    std::vector<MergeBlock> blocks;
    blocks.reserve(plan.clusters[i].blocks.size());
    for (const BlockPosition position : plan.clusters[i].blocks)
      blocks.push_back(mergeBlock(plan, position));
    merged[i] = mergeInCluster(blocks, limit, order);
    for (const MergedChunk& chunk : merged[i]) pages[i] += pagesOf(chunk);
    const Vec3i index = plan.clusters[i].index;
    by_row[{index.x, index.y, index.z}] = i;
  }
  const auto alone = [](std::vector<MergedChunk>& chunks) {
    return std::find_if(chunks.begin(), chunks.end(),
                        [](const MergedChunk& chunk) { return chunk.isSingleBlock(); });
  };
  for (const auto& [place, i] : by_row) {
    const auto& [x, y, z] = place;
    const auto next = by_row.find({x, y, z + 1});
    if (next == by_row.end()) continue;
    const ClusterPosition j = next->second;
    for (;;) {
      const auto a = alone(merged[i]), b = alone(merged[j]);
      if (a == merged[i].end() || b == merged[j].end()) break;
      MergedChunk both =
          mergeBetweenClusters(a->columns[0].blocks[0], b->columns[0].blocks[0], limit, order);
      // Each cluster now holds the other's block too, and must still fit the cache.
      const int64_t with_both = pagesOf(both);
      const int64_t pages_i = pages[i] - pagesOf(*a) + with_both;
      const int64_t pages_j = pages[j] - pagesOf(*b) + with_both;
      if (std::max(pages_i, pages_j) > plan.page.pages) break;
      pages[i] = pages_i;
      pages[j] = pages_j;
      *a = std::move(both);
      merged[j].erase(b);
    }
  }
  size_t count = 0;
  for (const std::vector<MergedChunk>& chunks : merged) count += chunks.size();
  reserveLarge(plan.chunks, count);
  std::vector<bool> is_between;
  is_between.reserve(count);
  for (const std::vector<MergedChunk>& chunks : merged)
    for (const MergedChunk& chunk : chunks) is_between.push_back(addChunk(plan, chunk));
  // A chunk of two clusters is asked for first, so that what the second of them loads cannot evict
  // it: it is loaded once, in both traversal directions.
  for (Cluster& cluster : plan.clusters)
    std::stable_partition(
        cluster.chunks.begin(), cluster.chunks.end(),
        [&](ChunkPosition position) { return is_between[static_cast<size_t>(position.value())]; });
}

// Smaller is nearer along this axis; two may share a rank only on opposite sides of the eye, where
// neither can hide the other. `cells` is the width of one step of the index.
int64_t rankOf(int64_t index, int64_t cells, const EyePosition& eye, int axis) {
  if (eye.parallel) return eye.index[axis] >= 0 ? index : -index;
  const auto at = static_cast<int64_t>(std::floor(eye.index[axis] / static_cast<double>(cells)));
  return std::abs(index - at);
}

// `ids` by the rank of each, equals in the order given.
template <class Id>
std::vector<Id> sortedByRank(std::span<const Id> ids, const auto& rank_of) {
  std::vector<std::pair<Vec3i, size_t>> ranked(ids.size());
  for (size_t i = 0; i < ids.size(); ++i) ranked[i] = {rank_of(ids[i]), i};
  std::sort(ranked.begin(), ranked.end(), [](const auto& a, const auto& b) {
    return std::tie(a.first.x, a.first.y, a.first.z, a.second) <
           std::tie(b.first.x, b.first.y, b.first.z, b.second);
  });
  std::vector<Id> order;
  order.reserve(ids.size());
  for (const auto& [rank, i] : ranked) order.push_back(ids[i]);
  return order;
}

}  // namespace

std::string_view name(Algorithm algorithm) {
  return kAlgorithmNames[static_cast<size_t>(algorithm)];
}

std::optional<Algorithm> parseAlgorithm(std::string_view text) {
  for (size_t i = 0; i < kAlgorithmNames.size(); ++i)
    if (kAlgorithmNames[i] == text) return static_cast<Algorithm>(i);
  return std::nullopt;
}

int64_t TexturePlan::pageCount() const {
  int64_t pages = 0;
  for (const Chunk& chunk : chunks) pages += chunk.pages;
  return pages;
}

uint64_t TexturePlan::bytes() const {
  return static_cast<uint64_t>(pageCount() * page.pageBytes());
}

LoadBytes TexturePlan::loadBytes(const Chunk& chunk) const {
  const auto bytes = [&](int64_t voxels) {
    return static_cast<uint64_t>(voxels * page.bytes_per_voxel);
  };
  LoadBytes load;
  load.moved = static_cast<uint64_t>(chunk.pages * page.pageBytes());
  int64_t copied = 0;
  for (const BlockPosition position : chunk.blocks) {
    const TextureBlock& block = blocks[position];
    copied += volume(block.texels());
    // Cells interpolate the planes on both sides.
    if (!block.cells.empty()) load.needed += bytes(volume(block.cells.size() + Vec3i{1, 1, 1}));
  }
  load.empty = bytes(copied) - load.needed;
  load.extended = bytes(volume(chunk.size_vox) - copied);
  return load;
}

TexturePlan planTextures(const BlockLayout& layout, const VisibleBlocks& visible,
                         const PageGeometry& page, const PlanOptions& options) {
  const int64_t block_pages = page.pagesOf(Vec3i{layout.size, layout.size, layout.size});
  const int64_t capacity_blocks = page.pages / block_pages;
  if (capacity_blocks < 1)
    fail(
        "a block of {0} x {0} x {0} voxels takes {1} pages and the texture cache has {2}; give "
        "--pages {1} or a smaller --block",
        layout.size, block_pages, page.pages);
  TexturePlan plan;
  plan.layout = layout;
  plan.page = page;
  plan.cluster_blocks = clusterBlocks(layout, capacity_blocks);
  for (int a = 0; a < 3; ++a)
    plan.cluster_grid[a] = ceilDiv(layout.grid[a], plan.cluster_blocks[a]);
  addBlocks(plan, visible, options);
  groupIntoClusters(plan);
  if (options.algorithm == Algorithm::kMerged) {
    mergeChunks(plan, options.merge_order);
  } else {
    addSingleChunks(plan);
  }
  return plan;
}

std::vector<ClusterPosition> clusterOrder(const TexturePlan& plan, const EyePosition& eye) {
  const int64_t cells = plan.layout.cells();
  std::vector<ClusterPosition> all;
  for (const ClusterPosition position : plan.clusters.indices()) all.push_back(position);
  return sortedByRank<ClusterPosition>(all, [&](ClusterPosition position) {
    const Vec3i index = plan.clusters[position].index;
    Vec3i rank;
    for (int a = 0; a < 3; ++a) rank[a] = rankOf(index[a], plan.cluster_blocks[a] * cells, eye, a);
    return rank;
  });
}

std::vector<BlockPosition> blockOrder(const TexturePlan& plan, const Cluster& cluster,
                                      const EyePosition& eye) {
  return sortedByRank<BlockPosition>(cluster.blocks, [&](BlockPosition position) {
    const Vec3i index = plan.layout.indexOf(plan.blocks[position].name.block);
    Vec3i rank;
    for (int a = 0; a < 3; ++a) rank[a] = rankOf(index[a], plan.layout.cells(), eye, a);
    return rank;
  });
}

std::vector<BlockPosition> layerOrder(const TexturePlan& plan,
                                      std::span<const BlockPosition> blocks,
                                      const EyePosition& eye) {
  // Along a ray no axis' rank descends, and one ascends from block to block.
  std::vector<std::pair<int64_t, BlockPosition>> order;
  for (const BlockPosition position : blocks) {
    const Vec3i index = plan.layout.indexOf(plan.blocks[position].name.block);
    int64_t layer = 0;
    for (int a = 0; a < 3; ++a) layer += rankOf(index[a], plan.layout.cells(), eye, a);
    order.emplace_back(layer, position);
  }
  std::sort(order.begin(), order.end());
  std::vector<BlockPosition> positions;
  positions.reserve(order.size());
  for (const auto& [layer, position] : order) positions.push_back(position);
  return positions;
}

}  // namespace sluice
