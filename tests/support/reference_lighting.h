// The light of a sample for the reference renderer, as src/device/shading/lighting.h defines it.
#pragma once

#include <array>

#include "tests/support/reference_renderer.h"

namespace sluice {

// Lighting's `flat` of samples, value units a world unit; of labels, opacities a world unit.
// `finest`: the finest spacing.
double flatReference(const ReferenceScene& scene, double finest);
// `gradient`: value units a world unit, in world directions. Requires: scene.lighting.
Vec3d litReference(const ReferenceScene& scene, const View& view, double flat, Vec3d gradient,
                   Vec3d rgb, std::array<double, 2> arriving = {1, 1});

}  // namespace sluice
