// Whether a coarse block loses part of a surface that the finest level has: a sheet, or a gap,
// whose coarse voxels have means on one side of the surface's value only. Pure functions of the
// block's voxels and of the finest level's ranges; any thread may call them.
#pragma once

#include <cstdint>

#include "src/volume/pyramid.h"
#include "src/volume/ranges/slice_ranges.h"
#include "src/volume/volume_buffer.h"

namespace sluice {

// A coarse voxel with a spread may hold values up to so many standard deviations from its mean. A
// sheet that fills a share p of it, with values that differ by d from those around it, moves the
// mean by p d and gives a deviation of d sqrt(p (1 - p)): with 1.25, a surface half way up is found
// if p is at least 0.11. Of 270 blocks at level 1 of a walnut, a bonsai and a head that lose part
// of ten surfaces, the test misses 26, 10 and 5 with 1, 1.25 and 1.5, and it counts 7, 12 and 22
// others.
inline constexpr double kLostDeviations = 1.25;

struct SurfaceQuestion {
  const PyramidLayout& pyramid;
  const SliceRanges& finest;  // ranges of the finest level of the block's time step
  Box3 cells;                 // finest cells that are looked at
  double value = 0;           // of the surface, a device value
};

// Whether the surface is lost somewhere in the cells. It is lost in a cell of the block's level if
// the means pass its value neither in this cell nor in those around it, a surface being free to
// move by a voxel, although
// - the spreads of the cell's voxels, if the level has any, say that values on both sides of the
//   surface lie there (kLostDeviations), or
// - the cell lies in the object box of a finest block in which the finest level passes the value,
//   and the same holds for all cells of this box.
// Requires: the block is of a coarser level, and has a ghost layer of two voxels.
bool losesSurface(const BlockName& name, const VolumeBlock& block, const SurfaceQuestion& asked);
// The most bytes that it holds for a block with so many voxels a side, ghost layers included.
constexpr uint64_t judgingBytes(int64_t side) {
  return 2 * static_cast<uint64_t>(side * side * side);
}

}  // namespace sluice
