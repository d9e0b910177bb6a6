// narrowMeans: the levels of means and spreads of a cube of voxels of 8 or 16 bits.
//
// Most bytes that LevelMaker (level_maker.h) sees pass here. Sums are whole numbers, taken row by
// row in loops that compilers turn into vector code; the results are those of sums in doubles,
// which hold them exactly. The cube passes a plane of the first level at a time. A plane of a
// coarser level is made as soon as the planes below it are there, so that the sums between two
// levels stay in the cache.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "io/zarr/levels/level_part.h"
#include "src/base/values/vec.h"

namespace sluice {

// Fills the parts of all levels, from fine to coarse. `room` is made as large as narrowMeansRoom();
// its contents do not matter. Requires: along each axis a level's step is 1 or 2 times the one
// before, the first level's 1 or 2.
template <class T>
void narrowMeans(const CubeVoxels<T>& cube, std::span<const LevelPart> levels,
                 std::vector<std::byte>& room);

// Bytes for the sums of a cube of `size` voxels. They grow with the size along x.
uint64_t narrowMeansRoom(Vec3i size, std::span<const Vec3i> steps);

}  // namespace sluice
