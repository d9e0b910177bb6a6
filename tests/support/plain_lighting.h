// Lights samples as the plain device does, in plain loops.
#pragma once

#include "src/device/device.h"

namespace sluice {

// The gradient at a sample in camera space, in device values a world unit, and the mean square of
// the slopes in all directions around it, in the same unit.
struct PlainSlopes {
  Vec3d gradient;
  double rough = 0;
  double here = 1;  // the share of the gradient's square that counts, see rough_light.h
};

// The colour `rgb` of a sample at an index position, lit as lighting.h and rough_light.h say.
Vec3d litPlainly(const FrameSetup& setup, Vec3d at, Vec3d rgb, const PlainSlopes& slopes,
                 double flatness);

}  // namespace sluice
