// PyramidLayout: how the levels of a volume are cut into blocks that nest.
//
// Every level has blocks of the same size in its own voxels (block_layout.h). The finest cells that
// a block stands for, its region, are `width` a side: the regions of a level tile the volume, and
// each is made of whole regions of the next finer level, so that a picture may show any part of the
// volume at any level and the parts meet exactly. A level whose voxels lie elsewhere than a whole
// multiple of the next finer ones do cannot be cut like that and is left out; a shift of up to a
// voxel, as an average has, is no obstacle: a block's ghost layer holds the voxels beyond its own
// planes.
//
// Plain values and pure functions.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "src/base/sources/volume_levels.h"
#include "src/volume/block_layout.h"
#include "src/volume/block_name.h"

namespace sluice {

struct LevelLayout {
  BlockLayout blocks;        // in the level's own voxels
  LevelPlacement placement;  // place of these voxels among the finest
  Vec3i width;               // finest cells from one block to the next
  int numbers = 1;           // a voxel: 2 if it has a mean and a spread

  friend bool operator==(const LevelLayout&, const LevelLayout&) = default;

  // The level's voxels that interpolation within these finest cells uses, those beyond the volume
  // included.
  Box3 voxelsUnder(const Box3& cells) const;
  // The finest cells that these cells of the level touch, those beyond the volume included.
  Box3 cellsOver(const Box3& level_cells) const;
  // The finest cells around the places that these voxels of the level stand for, half a voxel to
  // each side, those beyond the volume included.
  Box3 cellsAround(const Box3& level_voxels) const;
};

class PyramidLayout {
 public:
  PyramidLayout() = default;
  // A volume of one level.
  PyramidLayout(const BlockLayout& finest);  // NOLINT: stands for it
  friend bool operator==(const PyramidLayout&, const PyramidLayout&) = default;

  int levels() const { return static_cast<int>(levels_.size()); }
  const LevelLayout& level(int number) const { return levels_[static_cast<size_t>(number)]; }
  const LevelLayout& of(const BlockName& name) const { return level(name.level); }
  const BlockLayout& finest() const { return levels_.front().blocks; }

  // Adds a level above the coarsest one, of volumes of `dims` voxels. Returns why it does not nest,
  // in a few words, and adds nothing then; empty: it was added.
  // Requires: a ghost layer around each block; 1 or 2 numbers a voxel.
  std::string add(Vec3i dims, const LevelPlacement& placement, int numbers = 1);

  // The finest cells that a block stands for, cut by the volume. The last block along an axis has
  // the rest of it.
  Box3 regionOf(const BlockName& name) const;
  Box3 regionOf(int level, Vec3i index) const;
  // The voxels of the level that exist of the block's cube.
  Box3 storedVoxels(const BlockName& name) const;
  // The blocks of the next finer level in the region of a block, by their indices. Requires: level
  // > 0.
  Box3 childrenOf(int level, Vec3i index) const;
  // The blocks of the finest level in the region of a block, by their indices.
  Box3 finestBlocksOf(const BlockName& name) const;

 private:
  std::vector<LevelLayout> levels_;  // the finest first
};

// The usual ghost layers around blocks of several levels.
inline constexpr int kGhostOfLevels = 2;
// The ghost layers around blocks of `block` voxels a side of a volume with these levels: 2, or 3 if
// more of the levels nest in such blocks, as those of sizes that were halved and rounded down may.
int ghostOfLevels(Vec3i dims, int64_t block, std::span<const CoarserLevel> levels);

// The number of levels, from the finest on, that both have alike: cut into the same blocks, of
// voxels at the same places. Their voxels may have more or fewer numbers.
int levelsInCommon(const PyramidLayout& a, const PyramidLayout& b);

}  // namespace sluice
