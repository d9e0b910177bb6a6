// Finds the surfaces that a ray meets within a slice, as the plain device does, in plain loops.
#pragma once

#include <functional>
#include <vector>

#include "src/device/device.h"

namespace sluice {

struct PlainSurface {
  double part = 0;  // of the slice's way, 0 to 1
  SurfaceLevel level;
  Vec3d gradient;  // camera space, device values a world unit
};

// The surfaces on a slice's way, in its order. `place_at`: the index position at a part of it.
std::vector<PlainSurface> surfacesBetween(const FrameSetup& setup, const TexelMap& texels,
                                          const ChunkTexels& chunk,
                                          const std::function<Vec3d(double part)>& place_at);

}  // namespace sluice
