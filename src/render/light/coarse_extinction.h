// CoarseExtinction: how opaque the parts of a volume are for a look, in few texels. It is what
// shadows and ambient occlusion are computed from.
//
// A texel stands for a box of finest voxels. It has the mean of their extinctions, -ln(1 - opacity)
// of a voxel length, at most that of which 2^-16 passes. The voxels are the finest ones, or for
// pictures that are drawn from coarser levels those of the coarsest level that has one in each
// texel, with their spreads if it has these (expected_look.h). A surface adds the extinction of a
// meeting times its area. The voxels around it share it by how far from it they are, which follows
// from their values and gradients.
//
// Pure functions. They read voxels, part by part, on all threads of the pool.
#pragma once

#include <memory>
#include <vector>

#include "src/base/threads/stop_token.h"
#include "src/base/threads/worker_pool.h"
#include "src/device/frame_values.h"
#include "src/render/blocks/look.h"
#include "src/render/blocks/time_step.h"
#include "src/texture/texture_plan.h"

namespace sluice {

inline constexpr int64_t kMostLightTexels = 128;  // along an axis
// A thread reads at most so many at once.
inline constexpr int64_t kMostCoarseVoxelsRead = int64_t{1} << 21;

struct CoarseGrid {
  Vec3i texels;           // each at least 2
  Vec3i voxels{1, 1, 1};  // finest ones of a texel, along each axis
  int64_t count() const { return texels.x * texels.y * texels.z; }
  // The index position of a texel's centre.
  Vec3d centerOf(Vec3i texel) const {
    return toDouble(texel) * toDouble(voxels) + toDouble(voxels - Vec3i{1, 1, 1}) * 0.5;
  }
};
// Texels that are about as wide along each axis in the world.
CoarseGrid coarseGrid(const VolumeLayout& layout);

struct CoarseExtinction {
  CoarseGrid grid;
  std::vector<float> per_length;  // of a voxel length of the finest spacing; x fastest
};
using CoarseExtinctionPtr = std::shared_ptr<const CoarseExtinction>;

enum class MatterFrom { kFinest, kLevels };

// Throws Error if the opacities depend on gradients: plans refuse what pictures would.
void requireFollowedByLight(const TransferFunction& transfer, const VolumeLayout& volume);

// `planes`: those that a crop shows one voxel thick (planesOf()), whose values all of the volume
// then has; texels beside them stay empty. Throws as requireFollowedByLight(), Interrupted, and
// what the sources throw.
CoarseExtinction coarseExtinction(const TimeStep& step, const Look& look, MatterFrom from,
                                  WorkerPool& pool, const StopToken& stop,
                                  const VoxelPlanes& planes = {});

// The same without what the planes cut away, and a texel through which one goes in proportion.
CoarseExtinction within(const CoarseExtinction& whole, const std::vector<ClipPlane>& shown);

}  // namespace sluice
