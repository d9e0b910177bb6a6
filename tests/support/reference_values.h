// A time step's values for the reference renderer, read by their position in voxels.
#pragma once

#include <cstddef>
#include <vector>

#include "src/base/sources/volume_source.h"

namespace sluice {

// The nearest position between the voxels of a box.
Vec3d clampedTo(const Box3& box, Vec3d p);

class ReferenceValues {
 public:
  // Reads the whole time step into memory.
  ReferenceValues(VolumeSource& source, int64_t time);

  // The value with the greatest weight among the eight voxels around p, and by how much it leads.
  // Requires: as at().
  struct Label {
    double value, lead;
  };
  Label labelAt(Vec3d p) const;

  // Trilinear between the eight voxels around p. Requires: 0 <= p[a] <= dims[a] - 1, dims >= 2.
  double at(Vec3d p) const;

 private:
  const VolumeLayout& layout_;
  std::vector<std::byte> bytes_;
  Label (*label_)(const std::byte*, Vec3i, Vec3d) = nullptr;
  double (*trilinear_)(const std::byte*, Vec3i, Vec3d) = nullptr;
};

}  // namespace sluice
