// Lights samples as the plain device does, in plain loops.
#pragma once

#include "src/device/device.h"

namespace sluice {

// The gradient at a sample in camera space, in device values a world unit, and the mean square of
// the slopes in all directions around it, in the same unit.
struct PlainSlopes {
  Vec3d gradient;
  double rough = 0;
  // See rough_light.h: what counts of the gradient's square, and the share of that whose light is
  // seen.
  double here = 1, seen = 1;
};

// The colour `rgb` of a sample at an index position, lit as lighting.h and rough_light.h say.
Vec3d litPlainly(const FrameSetup& setup, Vec3d at, Vec3d rgb, const PlainSlopes& slopes,
                 double flatness);

}  // namespace sluice
