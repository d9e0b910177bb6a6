// The light of texels that stand for many values each (ExpectedLook): how much of it comes from
// slopes that the texels around do not show.
//
// A texel whose spread is more than the slope g from texel to texel explains has texture or several
// surfaces. Their slopes count as pointing in all directions, and e^2 is their mean square. Their
// light is the mean over all directions, in which |n.l| is 1/2 and |n.h|^s is 1 / (s + 1). With the
// names of lighting.h, and as light by g and by them mixes with the squares of both:
//   lit = (|g|^2 * lit(n) + e^2 * lit(all directions)) / (|g|^2 + e^2)
//   w = (|g|^2 + e^2) / (|g|^2 + e^2 + flat^2)
// Without it light falls on texture from the direction of g alone, which is little more than noise
// there: lit pictures of coarse levels had rings and grain.
#pragma once

#include <algorithm>

#include "src/device/shading/lighting.h"

namespace sluice {

// With the differences d of values from texel to texel, the mean square of those slopes along one
// axis, in values a texel, is kSpreadPart * spread^2 - kSlopePart * |d|^2, but at least 0: a fifth
// of the variance (spread^2 / 4) without that of an even slope (|d|^2 / 12). The fifth is measured
// on scans, sharp edges and thin shells, with texels of two and of four voxels: a tenth leaves more
// grain on scans, and a half flattens thin shells.
inline constexpr double kSpreadPart = 1.0 / 20, kSlopePart = 1.0 / 60;

// The share of a light that reaches the eye, in the mean over all directions of a surface.
inline double evenDiffuse(const Lighting& lighting, const Light& light) {
  return 0.5 * lighting.diffuse * light.strength;
}
inline double evenSpecular(const Lighting& lighting, const Light& light) {
  return lighting.specular * light.strength / (std::max(lighting.shininess, 0.0) + 1);
}

}  // namespace sluice
