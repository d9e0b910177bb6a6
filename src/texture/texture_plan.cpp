#include "src/texture/texture_plan.h"

#include <algorithm>
#include <cmath>
#include <unordered_map>

#include "src/base/error.h"

namespace sluice {
namespace {

constexpr std::array<std::string_view, 4> kAlgorithmNames = {"conventional", "clipped", "trimmed",
                                                             "merged"};
// Most blocks that the conventional algorithm may list.
constexpr int64_t kMostBlocks = int64_t{1} << 26;

// u and v: a square as nearly as powers of two allow, never wider than the grid.
Vec3i clusterBlocks(const BlockLayout& layout, int64_t capacity_blocks) {
  int64_t u = 1;
  while (4 * u * u <= capacity_blocks) u *= 2;
  u = std::min(u, layout.grid.x);
  const int64_t v = std::min(capacity_blocks / u, layout.grid.y);
  return {std::min(capacity_blocks / v, layout.grid.x), v, 1};
}

// The whole block, drawn whole (I) or clipped to its object box (II).
TextureBlock wholeBlock(const BlockLayout& layout, int64_t block, const Box3& cells) {
  TextureBlock result;
  result.block = block;
  result.voxels = layout.cube(layout.indexOf(block));
  result.cells = cells;
  return result;
}

// Section 3.2.2: trimmed along one axis, 2^d along the others.
TextureBlock trimmedBlock(const BlockLayout& layout, const ObjectBlock& object) {
  TextureBlock result = wholeBlock(layout, object.block, object.cells);
  const int axis = result.trimming_axis = object.trimming_axis;
  result.voxels.lo[axis] = object.cells.lo[axis] - layout.ghost;
  result.voxels.hi[axis] = object.cells.hi[axis] + 1 + layout.ghost;
  return result;
}

std::vector<TextureBlock> textureBlocks(const BlockLayout& layout,
                                        const Classification& classification, Algorithm algorithm,
                                        const Box3& crop) {
  std::vector<TextureBlock> blocks;
  if (algorithm == Algorithm::kTrimmed || algorithm == Algorithm::kMerged) {
    blocks.reserve(classification.visible.size());
    for (const ObjectBlock& object : classification.visible)
      blocks.push_back(trimmedBlock(layout, object));
    return blocks;
  }
  if (layout.blockCount() > kMostBlocks)
    fail("--algorithm {} loads every block, here {}; use trimmed or merged", name(algorithm),
         layout.blockCount());
  size_t next = 0;
  for (int64_t block = 0; block < layout.blockCount(); ++block) {
    Box3 cells;
    if (next < classification.visible.size() && classification.visible[next].block == block)
      cells = classification.visible[next++].cells;
    if (algorithm == Algorithm::kConventional)
      cells = intersect(layout.ownedCells(layout.indexOf(block)), crop);
    blocks.push_back(wholeBlock(layout, block, cells));
  }
  return blocks;
}

// Smaller is nearer along this axis; two may share a rank only on opposite sides of the eye, where
// neither can hide the other. `cells` is the width of one step of the index.
int64_t rankOf(int64_t index, int64_t cells, const EyePosition& eye, int axis) {
  if (eye.parallel) return eye.index[axis] >= 0 ? index : -index;
  const auto at = static_cast<int64_t>(std::floor(eye.index[axis] / static_cast<double>(cells)));
  return std::abs(index - at);
}

std::vector<int64_t> sortedByRank(size_t count, const auto& rank_at) {
  std::vector<std::pair<Vec3i, int64_t>> ranked(count);
  for (size_t i = 0; i < count; ++i) ranked[i] = {rank_at(i), static_cast<int64_t>(i)};
  std::sort(ranked.begin(), ranked.end(), [](const auto& a, const auto& b) {
    return std::tie(a.first.x, a.first.y, a.first.z, a.second) <
           std::tie(b.first.x, b.first.y, b.first.z, b.second);
  });
  std::vector<int64_t> order(count);
  for (size_t i = 0; i < count; ++i) order[i] = ranked[i].second;
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

TexturePlan planTextures(const BlockLayout& layout, const Classification& classification,
                         const PageGeometry& page, Algorithm algorithm, int64_t time,
                         const Box3& crop) {
  const int64_t block_pages = page.pagesOf(Vec3i{layout.size, layout.size, layout.size});
  const int64_t capacity_blocks = page.pages / block_pages;
  if (capacity_blocks < 1)
    fail(
        "a block of {0} x {0} x {0} voxels takes {1} pages and the texture cache has {2}; give "
        "--pages {1} or a smaller --block",
        layout.size, block_pages, page.pages);
  TexturePlan plan{layout, page, algorithm, time, clusterBlocks(layout, capacity_blocks),
                   {},     {},   {},        {}};
  for (int a = 0; a < 3; ++a)
    plan.cluster_grid[a] = ceilDiv(layout.grid[a], plan.cluster_blocks[a]);
  plan.blocks = textureBlocks(layout, classification, algorithm, crop);

  std::unordered_map<int64_t, int64_t> cluster_at;  // linear index in the grid -> position
  for (size_t i = 0; i < plan.blocks.size(); ++i) {
    TextureBlock& block = plan.blocks[i];
    const Vec3i index = layout.indexOf(block.block) / plan.cluster_blocks;
    const int64_t linear =
        (index.z * plan.cluster_grid.y + index.y) * plan.cluster_grid.x + index.x;
    const auto [found, fresh] =
        cluster_at.emplace(linear, static_cast<int64_t>(plan.clusters.size()));
    if (fresh) plan.clusters.push_back({index, {}, {}});
    block.cluster = found->second;
    block.chunk = static_cast<int64_t>(i);
    Cluster& cluster = plan.clusters[static_cast<size_t>(block.cluster)];
    cluster.blocks.push_back(static_cast<int64_t>(i));
    cluster.chunks.push_back(block.chunk);
    plan.chunks.push_back(
        {block.texels(), page.pagesOf(block.texels()), {static_cast<int64_t>(i)}});
  }
  return plan;
}

std::vector<int64_t> clusterOrder(const TexturePlan& plan, const EyePosition& eye) {
  const int64_t cells = plan.layout.cells();
  return sortedByRank(plan.clusters.size(), [&](size_t i) {
    const Vec3i index = plan.clusters[i].index;
    Vec3i rank;
    for (int a = 0; a < 3; ++a) rank[a] = rankOf(index[a], plan.cluster_blocks[a] * cells, eye, a);
    return rank;
  });
}

std::vector<int64_t> blockOrder(const TexturePlan& plan, const Cluster& cluster,
                                const EyePosition& eye) {
  std::vector<int64_t> order = sortedByRank(cluster.blocks.size(), [&](size_t i) {
    const TextureBlock& block = plan.blocks[static_cast<size_t>(cluster.blocks[i])];
    const Vec3i index = plan.layout.indexOf(block.block);
    Vec3i rank;
    for (int a = 0; a < 3; ++a) rank[a] = rankOf(index[a], plan.layout.cells(), eye, a);
    return rank;
  });
  for (int64_t& position : order) position = cluster.blocks[static_cast<size_t>(position)];
  return order;
}

}  // namespace sluice
