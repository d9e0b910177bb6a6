// makeLevelRegion: a part of a coarse level, made of the finest voxels where it is asked for.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "io/zarr/levels/level_shape.h"
#include "src/base/sources/volume_source.h"

namespace sluice {

// The voxels of a box of one level, and their spreads or shares if it has some, made of the finest
// voxels alone: for a level that cannot be read. Reads level.step times as many voxels along each
// axis, a cube of 64 at a time at the most. `voxels` and `spreads` are packed, x fastest; one of
// them may be empty, and is then not filled. Throws Error from the source. Requires: the box is
// inside the level.
void makeLevelRegion(VolumeSource& finest, int64_t time, const LevelShape& level, Downsample how,
                     const Box3& box, std::span<std::byte> voxels, std::span<std::byte> spreads);

}  // namespace sluice
