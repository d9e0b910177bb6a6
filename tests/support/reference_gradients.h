// The gradients of a volume for the reference renderer, in world directions.
#pragma once

#include "src/classify/transfer/transfer_function.h"
#include "tests/support/reference_values.h"

namespace sluice {

class ReferenceGradients {
 public:
  // All must outlive it.
  ReferenceGradients(const VolumeLayout& layout, const TransferFunction& transfer,
                     const ReferenceValues& values)
      : layout_(layout), transfer_(transfer), values_(values) {}

  // Value units a world unit at a position in voxels, by central differences.
  Vec3d at(Vec3d p) const;
  // Opacities a world unit, of labels: Sobel's weights (1, 2, 1) across an axis and (-1, 0, 1)
  // along it at each voxel around, whose sums are interpolated.
  Vec3d ofLabels(Vec3d p) const;
  // Value units a world unit from the corners of a cube of a voxel a side. `value` is at its
  // middle.
  Vec3d overCube(Vec3d p, double value) const;

 private:
  const VolumeLayout& layout_;
  const TransferFunction& transfer_;
  const ReferenceValues& values_;
};

}  // namespace sluice
