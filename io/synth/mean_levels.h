// MeanLevels: coarser levels of a volume, computed as they are read: each voxel of a level is the
// mean of a cube of voxels of the volume itself, rounded once.
//
// For synthetic volumes and tests. Nothing is kept: reading a level, or its spreads, reads what it
// is made of. Any thread may read.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "src/base/sources/volume_levels.h"
#include "src/base/sources/volume_source.h"

namespace sluice {

// Whether levels have spreads too (CoarserLevel).
enum class Spreads { kNone, kKept };

class MeanLevels {
 public:
  // Levels of cubes of 2, 4, 8, ... voxels a side above `finest`, which must outlive them: together
  // `count` levels with it. Voxels that fill no whole cube at the upper ends are left out. Throws
  // Error if a level would have fewer than 2 voxels along an axis.
  MeanLevels(VolumeSource& finest, int64_t count, Spreads spreads = Spreads::kNone);

  std::span<const CoarserLevel> levels() const { return levels_; }

 private:
  std::vector<std::unique_ptr<VolumeSource>> sources_;
  std::vector<CoarserLevel> levels_;
};

}  // namespace sluice
