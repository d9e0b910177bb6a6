// SurfacePlace: where the voxels of a level lie in the world, for positions and normals. A plain
// value and pure functions.
#pragma once

#include <array>

#include "io/meshes/mesh_file.h"
#include "src/base/sources/volume_levels.h"
#include "src/base/sources/volume_source.h"

namespace sluice {

struct SurfacePlace {
  Vec3d origin;               // of voxel (0, 0, 0)
  std::array<Vec3d, 3> step;  // to the next voxel along each axis
  // By which the derivatives of a value along the voxel axes become its gradient in the world.
  std::array<Vec3d, 3> slope;
  bool is_mirrored = false;  // the axes are left-handed

  Vec3d worldFromVoxel(Vec3d at) const {
    return origin + step[0] * at.x + step[1] * at.y + step[2] * at.z;
  }
  Vec3d gradient(Vec3d derivatives) const {
    return slope[0] * derivatives.x + slope[1] * derivatives.y + slope[2] * derivatives.z;
  }
};

// Requires: axes that span the space.
inline SurfacePlace surfacePlace(const VolumeLayout& finest, const LevelPlacement& level) {
  SurfacePlace place;
  std::array<Vec3d, 3> step;
  for (int a = 0; a < 3; ++a)
    step[static_cast<size_t>(a)] = finest.axes[static_cast<size_t>(a)] * finest.spacing[a];
  place.origin = finest.origin + step[0] * level.offset.x + step[1] * level.offset.y +
                 step[2] * level.offset.z;
  for (int a = 0; a < 3; ++a)
    place.step[static_cast<size_t>(a)] = step[static_cast<size_t>(a)] * level.scale[a];
  const double extent = dot(place.step[0], cross(place.step[1], place.step[2]));
  place.is_mirrored = extent < 0;
  for (size_t a = 0; a < 3; ++a)
    place.slope[a] = cross(place.step[(a + 1) % 3], place.step[(a + 2) % 3]) / extent;
  return place;
}

// A vector of any length but 0 as three floats of length 1.
inline std::array<float, 3> unitFloats(Vec3d v) {
  const double by = 1 / length(v);
  return {static_cast<float>(v.x * by), static_cast<float>(v.y * by), static_cast<float>(v.z * by)};
}
inline std::array<float, 3> floatsOf(Vec3d v) {
  return {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)};
}

}  // namespace sluice
