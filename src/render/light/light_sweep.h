// The light that reaches the texels of a CoarseExtinction from one direction: a sweep over its
// planes, from the side that the light comes from.
//
// The planes are those across the axis along which the light moves most, in texels. A texel lets
//   out = 1 - (1 - in * exp(-extinction * length)) * kept
// through, where `in` is what the last plane let out, linear between the four texels that the way
// to this texel's centre passes, and all light beyond the grid. `length` is the way from plane to
// plane in voxel lengths; `kept` is 1 for a light far away, and less if shadows end.
//
// A texel gets the `in` of the last plane where the way passes it, and not its own, so that a
// surface does not lie in its own shadow.
#pragma once

#include <vector>

#include "src/base/threads/worker_pool.h"
#include "src/render/light/coarse_extinction.h"

namespace sluice {

struct Sweep {
  Vec3d toward;       // where the light comes from, in texels; any length
  double length = 1;  // voxel lengths that a way of `toward` has
  // Voxel lengths after which a shadow has lost all but 1/e of itself; 0: it never ends.
  double reach = 0;
};

// Adds the light of each texel, 0 to 1, times `weight`. Requires: sums.size() == texels.
void addLight(const CoarseExtinction& matter, const Sweep& sweep, float weight, WorkerPool& pool,
              std::vector<float>& sums);

}  // namespace sluice
