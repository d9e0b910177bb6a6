// A scene that several tests draw: blobs behind a threshold, seen small.
#pragma once

#include <fmt/format.h>

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

// Calls `draw` with blobs of three types of voxels, light or none, and views of each projection.
// Their steps take turns: over the three types, each meets every light and projection.
template <class Draw>
void drawBlobsOfAllKinds(const Draw& draw) {
  constexpr double kSteps[] = {0.5, 1.0, 1.7};
  size_t turn = 0;
  for (const VoxelType type : {VoxelType::kU8, VoxelType::kI16, VoxelType::kF32}) {
    const auto source = spacedBlobs(type);
    for (const bool lit : {false, true})
      for (const Projection projection : kProjections) {
        FrameOptions options = obliqueView(projection, {64, 60});
        options.step_vox = kSteps[turn++ % 3];
        SCOPED_TRACE(fmt::format("{}, lit {}, projection {}, step {}", name(type), lit,
                                 static_cast<int>(projection), options.step_vox));
        draw(*source, options, lit);
      }
  }
}

}  // namespace sluice
