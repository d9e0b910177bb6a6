// gatheredLevels: the levels of means with their spreads, or of modes with their shares, of a cube
// of voxels of any type. Block by block in doubles; narrow_means.h does the same for most bytes,
// faster.
#pragma once

#include <span>
#include <vector>

#include "io/zarr/levels/block_sums.h"
#include "io/zarr/levels/level_part.h"
#include "io/zarr/levels/level_shape.h"

namespace sluice {

// Work space that is passed on from cube to cube: the blocks of a level and of the one before it.
struct GatheredRoom {
  std::vector<BlockSums> coarser, finer;
};

// Fills the parts of all levels, from fine to coarse. Requires: `how` is kMean or kMode; along each
// axis a level's step is 1 or 2 times the one before, the first level's 1 or 2; parts have spreads
// if levels keep them.
template <class T>
void gatheredLevels(const CubeVoxels<T>& cube, std::span<const LevelPart> levels, Downsample how,
                    GatheredRoom& room);

}  // namespace sluice
