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
//
// A texel of more than 8 voxels may be wider than an edge. Central differences of such edges turn
// with the place of the edge in its texel, which shows as rings, and reach more than a texel into
// the even matter beside them, where level 0 has no slope. So there g comes from Sobel's operator
// at the eight texels around, interpolated, and |g|^2 in the formulas above is multiplied by
//   here = min(1, (kEvenPart * |d|^2 + kOwnPart * spread^2) / v)^3,
// in which v is the variance of the values in the 4 x 4 x 4 texels of that operator: of their
// means, and within them, by the weights of its mean. A v of more than an even slope and the
// texel's own spread bring about tells of an edge beside the place. In e^2, spread^2 is at most
// 4 v - 3 |d|^2: an edge in the texel has no more variance than g explains, wherever it lies. Of
// chunks of floats, where one of the 64 is no number, all is as with narrow texels.
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

// An even slope d has a variance of |d|^2 / 12 within texels, and among the 64 means of |d|^2 / 2
// by the weights 1/4, 1/2 and 1/4 and of |d|^2 / 4 at most by interpolation. The variance in a
// texel is spread^2 / 4: it counts twice, and the power is the third, since of scans, sharp edges
// and thin shells with texels of four voxels these are closest to level 0.
inline constexpr double kEvenPart = 5.0 / 6, kOwnPart = 1.0 / 2;
// Four times kEvenPart, less the kSlopePart / kSpreadPart that e^2 takes away.
inline constexpr double kEdgePart = 3;

// Whether light falls on texels of this scale, in texels a voxel, as on those of more than 8
// voxels.
inline bool hasWideTexels(Vec3d scale) {
  constexpr double kRounding = 0.005;
  return scale.x * scale.y * scale.z < 1.0 / 8 - kRounding;
}

// The share of a light that reaches the eye, in the mean over all directions of a surface.
inline double evenDiffuse(const Lighting& lighting, const Light& light) {
  return 0.5 * lighting.diffuse * light.strength;
}
inline double evenSpecular(const Lighting& lighting, const Light& light) {
  return lighting.specular * light.strength / (std::max(lighting.shininess, 0.0) + 1);
}

}  // namespace sluice
