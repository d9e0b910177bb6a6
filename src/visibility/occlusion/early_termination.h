// Early ray termination at block level: which blocks a picture needs if every ray stops before the
// first block that it reaches opaque, by looking at every sample of every ray. The limit of culling
// blocks (Gao 2004, section 7, Figure 11), at the cost of reading everything: estimates are
// measured against it. Pure, on all threads of the pool.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "src/base/threads/worker_pool.h"
#include "src/classify/transfer/opacity_table.h"
#include "src/visibility/plenoptic/visibility_estimate.h"
#include "src/volume/voxels/device_voxel.h"

namespace sluice {

// A whole time step in device form, x fastest.
struct WholeStep {
  Vec3i dims;
  DeviceType type = DeviceType::kU8;
  std::span<const std::byte> voxels;
};

// For each block of `block_cells` cells a side, by id: whether a ray with less than the threshold's
// opacity in front of the block has a sample in it. Samples, opacities and their sum follow a
// composite picture without gradients.
std::vector<bool> reachedByRays(const WholeStep& step, int64_t block_cells,
                                const OpacityTable& table, const EstimateView& view,
                                double opacity_threshold, WorkerPool& pool);

}  // namespace sluice
