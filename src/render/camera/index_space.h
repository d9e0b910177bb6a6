// The way between world and index space of a volume. Pure functions.
#pragma once

#include <algorithm>

#include "src/base/sources/volume_source.h"
#include "src/base/values/vec.h"

namespace sluice {

// The place in the world of an index position: whole numbers are voxels, 0 is the first.
inline Vec3d worldFromIndex(const VolumeLayout& layout, Vec3d index) {
  Vec3d world = layout.origin;
  for (int a = 0; a < 3; ++a)
    world = world + layout.axes[static_cast<size_t>(a)] * (layout.spacing[a] * index[a]);
  return world;
}

// Converts a direction, so the origin does not matter.
inline Vec3d indexFromWorldDirection(const VolumeLayout& layout, Vec3d world) {
  const auto& [x, y, z] = layout.axes;
  const double determinant = dot(cross(x, y), z);
  const Vec3d along =
      Vec3d{dot(cross(y, z), world), dot(cross(z, x), world), dot(cross(x, y), world)} /
      determinant;
  return along / layout.spacing;
}

// The reverse of worldFromIndex(). Requires: the axes span the space.
inline Vec3d indexFromWorld(const VolumeLayout& layout, Vec3d world) {
  return indexFromWorldDirection(layout, world - layout.origin);
}

// The least distance between neighbouring voxels along an axis, in units of the world.
inline double finestSpacing(const VolumeLayout& layout) {
  return std::min({layout.spacing.x, layout.spacing.y, layout.spacing.z});
}

}  // namespace sluice
