#include "src/texture/texture_plan.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <map>
#include <tuple>

#include "src/base/error.h"
#include "src/base/memory/large_pages.h"
#include "src/texture/clusters.h"

namespace sluice {
namespace {

constexpr std::array<std::string_view, 4> kAlgorithmNames = {"conventional", "clipped", "trimmed",
                                                             "merged"};

// The most seams that a block has.
int64_t mostSeams(const VisibleBlocks& visible) {
  int64_t most = 0, count = 0;
  for (size_t i = 0; i < visible.seams.size(); ++i) {
    count = i > 0 && visible.seams[i].fine == visible.seams[i - 1].fine ? count + 1 : 1;
    most = std::max(most, count);
  }
  return most;
}

// Without their chunks and clusters.
void addBlocks(TexturePlan& plan, const VisibleBlocks& visible, const PlanOptions& options) {
  int64_t count = static_cast<int64_t>(visible.blocks.size());
  if (loadsEveryBlock(visible, options.algorithm))
    count = visible.share ? static_cast<int64_t>(visible.share->blocks.size())
                          : plan.layout().blockCount();
  count += static_cast<int64_t>(visible.seams.size());
  reserveLarge(plan.blocks, static_cast<size_t>(std::min(count, kMostListedBlocks)));
  visitTextureBlocks(plan.pyramid, visible, options,
                     [&](const TextureBlock& block) { plan.blocks.push_back(block); });
}

// The bits of the numbers by turns, those of z first: neighbours share the leading ones.
uint64_t interleaved(Vec3i index) {
  // Three numbers of 21 bits fill the place. Larger ones lose upper bits: merging then takes some
  // blocks for neighbours that are not, which no picture shows.
  constexpr int kBits = 21;
  uint64_t place = 0;
  for (int bit = 0; bit < kBits; ++bit)
    for (int a = 0; a < 3; ++a)
      place |= static_cast<uint64_t>(index[a] >> bit & 1) << (3 * bit + a);
  return place;
}

MergeBlock mergeBlock(const TexturePlan& plan, BlockPosition position) {
  const TextureBlock& block = plan.blocks[position];
  const Vec3i index = plan.pyramid.of(block.name).blocks.indexOf(block.name.block);
  return {position.value(), block.texels().z, interleaved(index)};
}

// Each block a chunk.
void addSingleChunks(TexturePlan& plan) {
  const int64_t side = sideOf(plan.pyramid);
  reserveLarge(plan.chunks, plan.blocks.size());
  for (const BlockPosition i : plan.blocks.indices()) {
    TextureBlock& block = plan.blocks[i];
    const ChunkPosition position = plan.chunks.endIndex();
    const Vec3i size{side, side, block.texels().z};
    block.chunk = position;
    plan.clusters[block.cluster].chunks.push_back(position);
    const int numbers = plan.pyramid.of(block.name).numbers;
    plan.chunks.push_back({size, numbers * plan.page.pagesOf(size), {i}});
  }
}

// The texels of a chunk of one or two columns. Two lie along y, so that the rows of a block follow
// each other in memory: along x, rows and planes of 64 bytes would use half of the sets of a
// processor's nearest cache. But they lie along x where this takes fewer pages.
Vec3i columnsSize(const TexturePlan& plan, size_t columns, int64_t thickness) {
  const int64_t side = sideOf(plan.pyramid), both = static_cast<int64_t>(columns) * side;
  const Vec3i along_x{both, side, thickness}, along_y{side, both, thickness};
  return plan.page.pagesOf(along_x) < plan.page.pagesOf(along_y) ? along_x : along_y;
}

// Gives each block its chunk and place, and each cluster of a block the chunk. Returns whether
// there are two.
bool addChunk(TexturePlan& plan, const MergedChunk& merged) {
  const BlockPosition first(merged.columns[0].blocks[0].block);
  const ClusterPosition first_cluster = plan.blocks[first].cluster;
  bool is_between = false;
  const ChunkPosition number = plan.chunks.endIndex();
  Chunk chunk;
  chunk.size_vox = columnsSize(plan, merged.columns.size(), merged.thickness());
  const int64_t side = sideOf(plan.pyramid);
  // More than one side wide along x: columnsSize() put two columns side by side there.
  const int across = chunk.size_vox.x > side ? 0 : 1;  // the axis along which columns lie
  size_t count = 0;
  for (const Column& column : merged.columns) count += column.blocks.size();
  chunk.blocks.reserve(count);
  for (size_t c = 0; c < merged.columns.size(); ++c) {
    int64_t z = 0;
    for (const MergeBlock& piled : merged.columns[c].blocks) {
      const BlockPosition position(piled.block);
      TextureBlock& block = plan.blocks[position];
      block.chunk = number;
      block.at = {0, 0, z};
      block.at[across] = static_cast<int64_t>(c) * side;
      z += piled.thickness;
      chunk.blocks.push_back(position);
      is_between = is_between || block.cluster != first_cluster;
      std::vector<ChunkPosition>& of_cluster = plan.clusters[block.cluster].chunks;
      // A chunk may hold several blocks of one cluster, which needs it once. They follow each other
      // within a column.
      if (of_cluster.empty() || of_cluster.back() != number) of_cluster.push_back(number);
    }
  }
  chunk.pages = plan.numbersOf(chunk) * plan.page.pagesOf(chunk.size_vox);
  plan.chunks.push_back(std::move(chunk));
  return is_between;
}

// Blocks of each level by themselves, so that a chunk is of one level.
std::vector<MergedChunk> mergeLevels(const TexturePlan& plan, const Cluster& cluster,
                                     MergeOrder order) {
  std::map<int32_t, std::vector<MergeBlock>> by_level;
  for (const BlockPosition first : cluster.blocks)
    for (int64_t i = 0; i <= plan.seamsOf(first); ++i) {
      const BlockPosition position(first.value() + i);
      by_level[plan.blocks[position].name.level].push_back(mergeBlock(plan, position));
    }
  std::vector<MergedChunk> merged;
  for (const auto& [level, blocks] : by_level)
    for (MergedChunk& chunk : mergeInCluster(blocks, sideOf(plan.pyramid), order))
      merged.push_back(std::move(chunk));
  return merged;
}

// Sections 3.2.3.2 and 3.2.3.3.
void mergeChunks(TexturePlan& plan, MergeOrder order) {
  const int64_t limit = sideOf(plan.pyramid);
  const auto pagesOf = [&](const MergedChunk& chunk) {
    const BlockPosition first(chunk.columns[0].blocks[0].block);
    return plan.pyramid.of(plan.blocks[first].name).numbers *
           plan.page.pagesOf(columnsSize(plan, chunk.columns.size(), chunk.thickness()));
  };
  // All clusters merge in themselves before any two merge with each other.
  IndexedVector<ClusterPosition, std::vector<MergedChunk>> merged(plan.clusters.size());
  IndexedVector<ClusterPosition, int64_t> pages(plan.clusters.size());
  // Clusters by x, y, z. A cluster merges with its neighbour along z, which is visited next to it
  // (3.2.3.3). Clusters of an octree are left out: they are not visited one behind the other along
  // z.
  std::map<std::tuple<int64_t, int64_t, int64_t>, ClusterPosition> by_row;
  const bool merges_between = plan.cluster_grids.size() == 1;
  for (const ClusterPosition i : plan.clusters.indices()) {
    merged[i] = mergeLevels(plan, plan.clusters[i], order);
    for (const MergedChunk& chunk : merged[i]) pages[i] += pagesOf(chunk);
    const Vec3i index = plan.clusters[i].index;
    if (merges_between) by_row[{index.x, index.y, index.z}] = i;
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
  // A chunk of two clusters is requested first, so that loads of the second cluster cannot evict
  // it: it is loaded once, in both traversal directions.
  for (Cluster& cluster : plan.clusters)
    std::stable_partition(
        cluster.chunks.begin(), cluster.chunks.end(),
        [&](ChunkPosition position) { return is_between[static_cast<size_t>(position.value())]; });
}

}  // namespace

std::string_view name(Algorithm algorithm) {
  return kAlgorithmNames[static_cast<size_t>(algorithm)];
}

int64_t TexturePlan::seamsOf(BlockPosition block) const {
  int64_t next = block.value() + 1;
  const auto count = static_cast<int64_t>(blocks.size());
  while (next < count && blocks[BlockPosition(next)].isOfSeam()) ++next;
  return next - block.value() - 1;
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
  const auto bytes = [&, numbers = numbersOf(chunk)](int64_t voxels) {
    return static_cast<uint64_t>(voxels * numbers * page.bytes_per_voxel);
  };
  LoadBytes load;
  load.moved = static_cast<uint64_t>(chunk.pages * page.pageBytes());
  int64_t copied = 0;
  for (const BlockPosition position : chunk.blocks) {
    const TextureBlock& block = blocks[position];
    copied += volume(block.texels());
    // Cells interpolate the planes on both sides.
    if (block.cells.empty()) continue;
    const Box3 needed = pyramid.of(block.name).voxelsUnder(block.cells);
    load.needed += bytes(intersect(needed, block.voxels).count());
  }
  load.empty = bytes(copied) - load.needed;
  load.extended = bytes(volume(chunk.size_vox) - copied);
  return load;
}

int64_t clusterCapacity(const PyramidLayout& pyramid, const VisibleBlocks& visible,
                        const PageGeometry& page) {
  const int64_t side = sideOf(pyramid);
  int numbers = 1;  // the most that a voxel of these blocks has
  for (const ObjectBlock& object : visible.blocks)
    numbers = std::max(numbers, pyramid.of(object.name).numbers);
  const int64_t block_pages = numbers * page.pagesOf(Vec3i{side, side, side});
  const int64_t capacity_blocks = page.pages / block_pages;
  if (capacity_blocks < 1)
    failMemory(
        "a block of {0} x {0} x {0} voxels takes {1} pages and the texture cache has {2}; give "
        "--pages {1} or a smaller --block",
        side, block_pages, page.pages);
  if (const int64_t least = 1 + mostSeams(visible); capacity_blocks < least)
    failMemory(
        "translucent surfaces between levels of resolution need {0} blocks at once, which take {1} "
        "pages, and the texture cache has {2}; give --pages {1}, a smaller --block or --level",
        least, std::bit_ceil(static_cast<uint64_t>(least * block_pages)), page.pages);
  return capacity_blocks;
}

VoxelPlanes planesOn(const LevelPlacement& level, const VoxelPlanes& finest) {
  VoxelPlanes of_level = finest;
  for (int a = 0; a < 3; ++a)
    if (auto& plane = of_level[static_cast<size_t>(a)])
      plane = std::llround((static_cast<double>(*plane) - level.offset[a]) / level.scale[a]);
  return of_level;
}

TexturePlan planTextures(const PyramidLayout& pyramid, const VisibleBlocks& visible,
                         const PageGeometry& page, const PlanOptions& options) {
  const int64_t capacity_blocks = clusterCapacity(pyramid, visible, page);
  TexturePlan plan;
  plan.pyramid = pyramid;
  plan.page = page;
  plan.planes = options.planes;
  addBlocks(plan, visible, options);
  if (options.clusters != nullptr)
    groupAs(*options.clusters, plan);
  else
    groupIntoClusters(plan, capacity_blocks);
  if (options.algorithm == Algorithm::kMerged) {
    mergeChunks(plan, options.merge_order);
  } else {
    addSingleChunks(plan);
  }
  return plan;
}

}  // namespace sluice
