#include "io/zarr/levels/level_shape.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace sluice {
namespace {

constexpr std::pair<Downsample, LevelValues> kWays[] = {{Downsample::kMean, LevelValues::kMeans},
                                                        {Downsample::kMax, LevelValues::kMaxima},
                                                        {Downsample::kMin, LevelValues::kMinima},
                                                        {Downsample::kMode, LevelValues::kModes}};

}  // namespace

LevelValues valuesOf(Downsample how) {
  for (const auto& [way, values] : kWays)
    if (way == how) return values;
  return LevelValues::kUnknown;
}

Downsample downsampleFor(LevelValues values) {
  for (const auto& [way, of_way] : kWays)
    if (of_way == values) return way;
  return Downsample::kMean;
}

LevelPlacement placementOf(const LevelShape& shape) {
  const Vec3d step = toDouble(shape.step);
  return {step, (step - Vec3d{1, 1, 1}) * 0.5};
}

std::vector<LevelShape> levelShapes(const VolumeLayout& layout, int64_t chunk_voxels,
                                    std::optional<int64_t> most) {
  std::vector<LevelShape> levels;
  LevelShape level{layout.dims, {1, 1, 1}};
  Vec3d spacing = layout.spacing;
  const auto isEnough = [&] {
    if (most) return static_cast<int64_t>(levels.size()) >= *most;
    return std::max({level.dims.x, level.dims.y, level.dims.z}) <= kCoarsestSide;
  };
  while (!isEnough()) {
    // Axes whose voxels are within half an octave of the shortest that can still be halved.
    double shortest = std::numeric_limits<double>::infinity();
    const auto canHalve = [&](int a) {
      // A chunk of level 0 must make whole voxels of each level (LevelMaker).
      return level.dims[a] > 1 && chunk_voxels % (2 * level.step[a]) == 0;
    };
    for (int a = 0; a < 3; ++a)
      if (canHalve(a)) shortest = std::min(shortest, spacing[a]);
    if (std::isinf(shortest)) break;
    for (int a = 0; a < 3; ++a) {
      // Halving only the finely sampled axes makes voxels of coarser levels closer to cubes.
      if (!canHalve(a) || spacing[a] > shortest * std::sqrt(2.0)) continue;
      level.step[a] *= 2;
      level.dims[a] = ceilDiv(layout.dims[a], level.step[a]);
      spacing[a] *= 2;
    }
    levels.push_back(level);
  }
  return levels;
}

}  // namespace sluice
