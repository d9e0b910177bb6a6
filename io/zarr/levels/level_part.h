// A cube of finest voxels, and the places that levels have for what is made of it.
#pragma once

#include <cstddef>
#include <cstdint>

#include "src/base/values/vec.h"

namespace sluice {

// Voxels of a cube, x fastest, with their strides in voxels.
template <class T>
struct CubeVoxels {
  Vec3i size;
  const T* voxels = nullptr;
  int64_t row_stride = 0, plane_stride = 0;
};

// The part of a level that a cube makes. Strides are in voxels of the level.
struct LevelPart {
  Vec3i step;                    // finest voxels of a voxel of the level
  std::byte* voxels = nullptr;   // the first of them
  std::byte* spreads = nullptr;  // of the same voxel, or its share; null: the level has none
  int64_t row_stride = 0, plane_stride = 0;
};

// The voxels of a level that `size` finest ones make, the last of them perhaps of fewer.
inline Vec3i blocksOf(Vec3i size, Vec3i step) {
  return {ceilDiv(size.x, step.x), ceilDiv(size.y, step.y), ceilDiv(size.z, step.z)};
}

}  // namespace sluice
