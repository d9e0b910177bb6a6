// TexturePlan: level 3 before a byte of it exists (design, point 1).
//
// TexturePlan follows from the classified blocks and the page geometry alone: which part of each
// volume block becomes a texture block, how texture blocks lie in chunks, and which chunks a
// cluster needs (Tong 1999, sections 3.2.2 and 3.2.3). A pure function of its arguments; it touches
// no voxel. The renderer, the simulator and `sluice plan` work from the same plan. Immutable once
// made.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "cache/model/page_geometry.h"
#include "cache/trace/trace.h"
#include "src/classify/blocks/classification.h"
#include "src/texture/merging.h"
#include "src/texture/positions.h"
#include "src/volume/block_side.h"
#include "src/volume/pyramid.h"

namespace sluice {

// The paper's four (section 4): I loads and draws every block whole; II clips drawing to the object
// boxes; III loads trimmed blocks, one a chunk; IV merges them.
enum class Algorithm { kConventional, kClipped, kTrimmed, kMerged };
inline constexpr std::array<Algorithm, 4> kAlgorithms = {
    Algorithm::kConventional, Algorithm::kClipped, Algorithm::kTrimmed, Algorithm::kMerged};
// The name that reports and options have for it.
std::string_view name(Algorithm algorithm);

// The volume axes that become texture x, y and z: a turn that brings the trimming axis to z.
constexpr std::array<int, 3> textureAxes(int trimming_axis) {
  return {(trimming_axis + 1) % 3, (trimming_axis + 2) % 3, trimming_axis};
}
// `volume_size` in texture order.
constexpr Vec3i turned(Vec3i volume_size, int trimming_axis) {
  const auto axes = textureAxes(trimming_axis);
  return {volume_size[axes[0]], volume_size[axes[1]], volume_size[axes[2]]};
}

// A part of a volume block, copied into a chunk.
struct TextureBlock {
  BlockName name;  // the volume block
  Box3 cells;      // cells of the finest level that are resampled, half-open
  Box3 voxels;  // voxels of its own level that are copied; beyond the volume if the block is padded
  int trimming_axis = 2;     // becomes texture z
  unsigned level_faces = 0;  // ObjectBlock::level_faces
  // Not a block of its own, but texels of a coarser one under cells of the block before it, which
  // is drawn with them: the number of the seam in VisibleBlocks::seams; -1: none.
  int32_t seam = -1;
  ChunkPosition chunk;
  Vec3i at;  // texel of voxels.lo in the chunk
  ClusterPosition cluster;

  Vec3i texels() const { return turned(voxels.size(), trimming_axis); }
  bool isOfSeam() const { return seam >= 0; }
};

// A unit of loading into the texture cache: texture blocks and the texels between them.
struct Chunk {
  Vec3i size_vox;     // texels, before rounding up to whole pages
  int64_t pages = 0;  // of the page geometry; twice as many if its texels have two numbers
  std::vector<BlockPosition> blocks;
};

// Blocks that together fill the texture cache at most: u x v blocks of one z index if all blocks
// are of one level, else the blocks in a cell of one of the plan's cluster grids.
struct Cluster {
  size_t grid = 0;                    // index into TexturePlan::cluster_grids
  Vec3i index;                        // in that grid
  std::vector<BlockPosition> blocks;  // blocks of this cluster, without those of seams
  // The chunks that hold these blocks, and those of their seams. A chunk merged between two
  // clusters is in both.
  std::vector<ChunkPosition> chunks;
};

// A grid over the finest cells, whose cells are blocks or clusters: cells of `width` from the
// volume's corner on, the last along an axis with the rest of the volume.
struct VisitGrid {
  Vec3i width, count;

  Vec3i indexOf(Vec3i cell) const { return min(cell / width, count - Vec3i{1, 1, 1}); }
};

// The number of the one voxel plane along each axis whose values all planes have; unset: each plane
// has its own.
using VoxelPlanes = std::array<std::optional<int64_t>, 3>;
// Planes of the finest level among those of another level: the nearest ones.
VoxelPlanes planesOn(const LevelPlacement& level, const VoxelPlanes& finest);

struct TexturePlan {
  PyramidLayout pyramid;
  PageGeometry page;
  VoxelPlanes planes;    // of the finest level
  Vec3i cluster_blocks;  // u, v, 1; of blocks of several levels 1, 1, 1
  // Grids from coarse to fine, each cell of one made of whole cells of the next: the grids of the
  // blocks' levels, and the grids whose cells the clusters are.
  std::vector<VisitGrid> block_grids, cluster_grids;
  IndexedVector<BlockPosition, TextureBlock> blocks;
  IndexedVector<ChunkPosition, Chunk> chunks;
  IndexedVector<ClusterPosition, Cluster> clusters;  // clusters with anything to draw

  const BlockLayout& layout() const { return pyramid.finest(); }
  // How many blocks of seams follow a block, whose they are.
  int64_t seamsOf(BlockPosition block) const;
  // Numbers a texel of a chunk, all of whose blocks are of one level.
  int numbersOf(const Chunk& chunk) const {
    return pyramid.of(blocks[chunk.blocks.front()].name).numbers;
  }
  // Pages of the texture cache that all chunks take together.
  int64_t pageCount() const;
  // The bytes that one load of a chunk moves, by cause.
  LoadBytes loadBytes(const Chunk& chunk) const;
  // Bytes of all chunks in whole pages.
  uint64_t bytes() const;
};
using TexturePlanPtr = std::shared_ptr<const TexturePlan>;

struct PlanOptions {
  Algorithm algorithm = Algorithm::kMerged;
  MergeOrder merge_order = MergeOrder::kPaper;  // for kMerged
  int64_t time = 0;  // time step of blocks that are loaded although nothing of them is visible
  Box3 crop;         // cells that may show
  // The clusters are those of this plan of the same blocks and perhaps more, of a volume that has
  // their levels in common with this one (levelsInCommon()), and no cluster of it has more blocks
  // than the texture cache holds; null: they follow from the blocks.
  const TexturePlan* clusters = nullptr;
  VoxelPlanes planes = {};  // TexturePlan::planes
};

// The voxels along a side of all blocks: the 2^d of the paper, or less in a volume that is smaller.
inline int64_t sideOf(const PyramidLayout& pyramid) {
  return blockSide(pyramid.finest(), pyramid.levels());
}
// The most blocks that a plan may list if it loads all of them.
inline constexpr int64_t kMostListedBlocks = int64_t{1} << 26;

// Whether an algorithm loads blocks whole, and not trimmed.
constexpr bool loadsWholeBlocks(Algorithm algorithm) {
  return algorithm == Algorithm::kConventional || algorithm == Algorithm::kClipped;
}
// Whether the whole picture, of which these may be a rank's blocks, shows coarser levels.
bool areOfSeveralLevels(const VisibleBlocks& visible);
// Whether a plan loads all blocks of the finest level, visible or not, or all of this rank's share
// of them. Blocks of several levels are loaded only if they are visible, by all algorithms.
bool loadsEveryBlock(const VisibleBlocks& visible, Algorithm algorithm);
// Throws Error when all blocks of this layout are more than a plan can list.
void requireListable(const BlockLayout& layout, Algorithm algorithm);

// Calls `visit` with each texture block of a plan, in the plan's order, before it has a chunk and a
// cluster: each block's seams (TextureBlock::isOfSeam()) come behind it. Holds no list of them.
// Throws Error when all blocks are loaded and are more than a plan can list.
void visitTextureBlocks(const PyramidLayout& pyramid, const VisibleBlocks& visible,
                        const PlanOptions& options,
                        const std::function<void(const TextureBlock&)>& visit);

// The most blocks that a cluster has: as many as fit the texture cache, which count with their
// seams. Throws Error when that has fewer pages than one block with its seams.
int64_t clusterCapacity(const PyramidLayout& pyramid, const VisibleBlocks& visible,
                        const PageGeometry& page);

// Throws what visitTextureBlocks() and clusterCapacity() do. Requires: the regions of the visible
// blocks (pyramid.h) are disjoint.
TexturePlan planTextures(const PyramidLayout& pyramid, const VisibleBlocks& visible,
                         const PageGeometry& page, const PlanOptions& options);

// The eye's place among the cells of the volume, or the viewing direction of a parallel view.
struct EyePosition {
  bool parallel = true;
  Vec3d index;  // parallel: the viewing direction; otherwise the eye, both in index space
};
// The orders below go down the grids of the plan from coarse to fine, as an octree is traversed:
// cells of a grid front to back, then the contents of each cell. Blocks of one level are one grid.
// If two cells may come in either order, neither hides the other.
//
// Front to back: along z first, then y, then x (section 3.2.3.3).
std::vector<ClusterPosition> clusterOrder(const TexturePlan& plan, const EyePosition& eye);
// The blocks of one cluster, front to back.
std::vector<BlockPosition> blockOrder(const TexturePlan& plan, const Cluster& cluster,
                                      const EyePosition& eye);
// Any blocks, front to back in layers across the view: blocks in front are drawn all over the
// picture before those behind them.
std::vector<BlockPosition> layerOrder(const TexturePlan& plan,
                                      std::span<const BlockPosition> blocks,
                                      const EyePosition& eye);

}  // namespace sluice
