// The light of a sample for the reference renderer, as src/device/lighting.h defines it.
#pragma once

#include "tests/support/reference_renderer.h"

namespace sluice {

// `gradient`: value units a world unit, in world directions. `finest`: the finest spacing.
// Requires: scene.lighting.
Vec3d litReference(const ReferenceScene& scene, const View& view, double finest, Vec3d gradient,
                   Vec3d rgb);

}  // namespace sluice
