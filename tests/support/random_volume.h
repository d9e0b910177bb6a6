// Seeded random volumes: the same seed gives the same voxels everywhere.
#pragma once

#include <cstdint>
#include <memory>

#include "tests/support/memory_source.h"

namespace sluice {

struct BlobOptions {
  Vec3i dims{48, 40, 36};
  VoxelType type = VoxelType::kU8;
  uint64_t seed = 1;
  int blobs = 6;           // soft balls; 0 leaves the volume empty
  double radius_vox = 7;   // radius of the largest; the smallest has half of it
  double drift_vox = 1.5;  // how far a blob goes from one time step to the next, at most
  int64_t time_steps = 1;
  Vec3d spacing{1, 1, 1};
};

// Soft balls that rise to 200 of 255 (of the type's largest value for other integers, of 1 for
// floats) in exact zeros. Blobs may stick out of the volume.
std::unique_ptr<MemorySource> makeSparseBlobs(const BlobOptions& options);

// Every voxel independent and uniform over the type's values (0..1 for floats): the worst case for
// anything that hopes for coherence.
std::unique_ptr<MemorySource> makeWhiteNoise(Vec3i dims, VoxelType type, uint64_t seed);

}  // namespace sluice
