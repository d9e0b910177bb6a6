// A scene that several tests draw: blobs behind a threshold, seen small.
#pragma once

#include <memory>

#include "src/classify/transfer/transfer_makers.h"
#include "tests/render/render_scene.h"
#include "tests/support/random_volume.h"

namespace sluice {

inline std::unique_ptr<MemorySource> blobs(Vec3i dims = {48, 40, 36},
                                           VoxelType type = VoxelType::kU8) {
  return makeSparseBlobs({.dims = dims, .type = type, .blobs = 9});
}

// More of them, in cells that are no cubes.
inline std::unique_ptr<MemorySource> spacedBlobs(VoxelType type = VoxelType::kU8,
                                                 uint64_t seed = 1) {
  return makeSparseBlobs(
      {.dims = {61, 50, 55}, .type = type, .seed = seed, .blobs = 12, .spacing = {1, 1.2, 0.9}});
}

// A transfer function for blobs of bytes.
inline TransferFunction someTransfer(double threshold = 40) {
  return thresholdTransfer(threshold, {0, 200}, 0.2, "viridis");
}

inline FrameOptions smallView(double azimuth_deg = 33) {
  FrameOptions options = obliqueView(Projection::kPerspective, {48, 44});
  options.camera.azimuth_deg = azimuth_deg;
  return options;
}

}  // namespace sluice
