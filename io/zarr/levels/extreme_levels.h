// extremeLevels: the levels of maxima or minima of a cube of voxels.
//
// The extreme of extremes is that of the voxels, so each level is made of the one before it, row by
// row, in loops that compilers turn into vector code. NaN counts only if a block has nothing else.
#pragma once

#include <span>

#include "io/zarr/levels/level_part.h"
#include "io/zarr/levels/level_shape.h"

namespace sluice {

// Fills the parts of all levels, from fine to coarse. Takes no memory of its own. Requires: `how`
// is kMax or kMin; along each axis a level's step is 1 or 2 times the one before, the first
// level's 1 or 2.
template <class T>
void extremeLevels(const CubeVoxels<T>& cube, std::span<const LevelPart> levels, Downsample how);

}  // namespace sluice
