// BlockLayout: how a volume is cut into volume blocks (Tong 1999, section 3.2.1).
//
// A block is a cube of 2^d voxels a side. Neighbours share their boundary voxel plane, so that
// interpolation never needs two blocks: a block owns the 2^d - 1 cells between its planes, and the
// grid has ceil((l-1) / (2^d-1)) blocks along an axis of l voxels (formula 1). With `ghost` = 1 the
// outermost voxel layer is a border for central differences (lit pictures): the block owns 2^d - 3
// cells and its first stored plane lies one before its first cell. A volume of several levels has a
// layer more, or two (pyramid.h). Beyond the volume a block is padded. Cells are classified and
// drawn: cell i lies between voxel planes i and i+1.
#pragma once

#include <cstdint>

#include "src/base/values/vec.h"

namespace sluice {

struct BlockLayout {
  Vec3i dims;         // voxels of the volume, each >= 2
  int64_t size = 64;  // 2^d voxels a side
  int ghost = 0;      // layers: 0, 1, or 2 or 3 if lit blocks of several levels meet
  Vec3i grid;         // blocks along each axis

  friend bool operator==(const BlockLayout&, const BlockLayout&) = default;

  // Owned cells along each axis of an inner block.
  int64_t cells() const { return size - 1 - 2 * ghost; }
  // Owned voxel planes along each axis: elements of one min-max array.
  int64_t planes() const { return cells() + 1; }
  int64_t blockCount() const { return volume(grid); }

  Vec3i indexOf(int64_t block) const {
    return {block % grid.x, block / grid.x % grid.y, block / (grid.x * grid.y)};
  }
  int64_t idOf(Vec3i index) const { return (index.z * grid.y + index.y) * grid.x + index.x; }

  // The cells that the block owns, clipped to the volume; disjoint, and together all cells.
  Box3 ownedCells(Vec3i index) const {
    const Vec3i lo = index * cells();
    return {lo, min(lo + Vec3i{cells(), cells(), cells()}, dims - Vec3i{1, 1, 1})};
  }
  // The voxel planes between which these cells lie.
  Box3 ownedVoxels(Vec3i index) const {
    const Box3 cells = ownedCells(index);
    return {cells.lo, cells.hi + Vec3i{1, 1, 1}};
  }
  // The 2^d cube of voxels, ghost layer and padding included; may reach beyond the volume.
  Box3 cube(Vec3i index) const {
    const Vec3i lo = index * cells() - Vec3i{ghost, ghost, ghost};
    return {lo, lo + Vec3i{size, size, size}};
  }
  // The voxels that exist of the cube.
  Box3 storedVoxels(Vec3i index) const { return intersect(cube(index), boxOf(dims)); }
};

// Whether blocks of so many voxels a side own a cell between their ghost layers.
constexpr bool hasRoom(int64_t block, int ghost) {
  return block - 1 - 2 * ghost >= 1;
}

// Throws Error when an axis has fewer than 2 voxels, or there are more blocks than 63 bits count
// (`where` starts the line).
// Requires: size a power of two, hasRoom(size, ghost), ghost 0 to 3.
BlockLayout blockLayout(Vec3i dims, int64_t size, int ghost, const char* where = "volume");

// Tong's two rules: the smallest power-of-two cube that holds at least one page of page_vox voxels.
int64_t blockSizeFor(Vec3i page_vox);

}  // namespace sluice
