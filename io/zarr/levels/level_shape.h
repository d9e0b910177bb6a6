// The shapes of the coarser levels that sluice makes: how many there are, how many finest voxels a
// voxel of each stands for, and how its value follows from theirs. Pure functions.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "src/base/sources/volume_levels.h"
#include "src/base/sources/volume_source.h"
#include "src/base/values/vec.h"

namespace sluice {

// The value of a coarse voxel, from its block of finer ones. NaN counts only if a block has nothing
// else. If several values are most frequent, kMode takes the least.
enum class Downsample { kMean, kMax, kMin, kMode };
// Whether the levels have a second number for each voxel (CoarserLevel::spreads).
constexpr bool keepsSpreads(Downsample how) {
  return how == Downsample::kMean || how == Downsample::kMode;
}
LevelValues valuesOf(Downsample how);
// The way to make levels of these values; kMean if they are unknown.
Downsample downsampleFor(LevelValues values);

struct LevelShape {
  Vec3i dims;  // voxels
  Vec3i step;  // finest voxels of one along each axis, powers of two
};
LevelPlacement placementOf(const LevelShape& shape);

// The coarser levels of a volume for chunks of `chunk_voxels` a side, from fine to coarse: each
// halves the axes whose voxels are short, so that voxels get closer to cubes. `most`: that many;
// without, until the longest side has at most kCoarsestSide voxels. Ends if a voxel would stand for
// more than a chunk's side, or if no axis can be halved. Requires: chunk_voxels > 0.
std::vector<LevelShape> levelShapes(const VolumeLayout& layout, int64_t chunk_voxels,
                                    std::optional<int64_t> most);
inline constexpr int64_t kCoarsestSide = 64;

}  // namespace sluice
