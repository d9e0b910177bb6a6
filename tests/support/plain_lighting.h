// Lights samples as the plain device does, in plain loops.
#pragma once

#include "src/device/device.h"

namespace sluice {

// The colour `rgb` of a sample at an index position, lit as described in lighting.h. The gradient
// is in camera space, in device values a world unit.
Vec3d litPlainly(const FrameSetup& setup, Vec3d at, Vec3d rgb, Vec3d gradient, double flatness);

}  // namespace sluice
