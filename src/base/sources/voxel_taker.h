// VoxelTaker: takes part in a pass over a volume's voxels that is made anyway, such as the pass
// that makes the min-max arrays (src/volume/ranges/slice_ranges.h).
//
// The pass hands over each voxel once, in pieces: boxes that begin and end at multiples of side(),
// or at the volume's end, in layers of side() planes from the first to the last. take() is called
// from any thread, on several at once; layersBefore() from one thread, while no take() runs.
#pragma once

#include <cstddef>
#include <cstdint>

#include "src/base/values/vec.h"

namespace sluice {

// A box of stored voxels in memory, x fastest, with its strides in voxels.
struct VoxelPiece {
  Box3 box;
  const std::byte* voxels = nullptr;
  int64_t row_stride = 0, plane_stride = 0;
};

class VoxelTaker {
 public:
  virtual ~VoxelTaker() = default;
  // Voxels, constant.
  virtual int64_t side() const = 0;
  // Whether the pieces of the layer that begins at plane `z` are needed.
  virtual bool wantsLayer(int64_t z) = 0;
  // Called for every piece of a layer that is wanted; a piece of background that the source does
  // not store may be left out. Throws Interrupted.
  virtual void take(const VoxelPiece& piece) = 0;
  // All pieces of the planes before `end` have been taken: a layer's end. Throws Interrupted.
  virtual void layersBefore(int64_t end) = 0;
};

}  // namespace sluice
