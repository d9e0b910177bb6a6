// The light of texels that stand for many values each (ExpectedLook): how much of it comes from
// slopes that the texels around do not show.
//
// A texel whose spread is more than the slope g from texel to texel explains has texture or several
// surfaces. Their slopes count as pointing in all directions, and e^2 is their mean square. Their
// light is the mean over all directions, in which |n.l| is 1/2 and |n.h|^s is 1 / (s + 1). With the
// names of lighting.h, and as light by g and by them mixes with the squares of both,
//   G = here * |g|^2 / narrow^2,   lit = (G * lit(n) + e^2 * lit(all directions)) / (G + e^2)
//   w = (seen * G + e^2) / (G + e^2 + flat^2)
//
// A texel may be wider than an edge, and central differences of such edges turn with the place of
// the edge in its texel, which shows as rings. So g comes from Sobel's operator at the eight texels
// around, interpolated. It reaches more than a texel into the even matter beside an edge, where
// level 0 has no slope. What the 64 texels of that operator tell of the edge corrects this: the
// mean m and the variance v of their values, by the weights of its mean, the height h from their
// least to their greatest mean, and how full the place is, q = (m - least) / h.
//
// Values that are either the least or the greatest have v = h^2 * q * (1 - q), and those of an even
// slope a third of it or less. `sharp` goes from 0 to 1 with that share. Light on a sharp edge
// falls on a layer of some voxels, however wide the texels are. As |g| over all places adds up to
// h, wherever the edge lies, the layer's share of a place is p = kEdgeVoxels * |g| / h, with |g| in
// values a voxel:
//   narrow = mix(1, min(1, p), sharp): the layer is as much steeper than g;
//   seen = mix(1, min(1, p / (2 q)), sharp): half of the layer is in the fuller part of the place,
//     which is what shows if the other side is empty.
// An edge beside the place shows where nothing is sharp: v is more than an even slope and the
// texel's own spread bring about.
//   here = mix(min(1, (kEvenPart * |g|^2 + kOwnPart * spread^2) / v)^3, 1, sharp).
//
// In e^2, spread^2 is at most 4 v - 3 |g|^2, with g from texel to texel: an edge in the texel has
// no more variance than g explains, wherever it lies. Noise is in every texel, and its slopes are
// as steep as voxels are small. So the least spread of the 64 texels, without that of an even
// slope, adds to e^2 by the voxel, and the spread of the place by the texel.
//
// So that the least and the greatest do not jump from cell to cell, the first of four texels along
// an axis becomes its neighbour while the place goes from the middle of the cell to its end, and
// the last one from its beginning to its middle; axis after axis. Of chunks of floats, where one of
// the 64 texels is no number, g is the central difference, and light falls as on matter that is not
// sharp.
#pragma once

#include <algorithm>

#include "src/device/shading/label_shares.h"
#include "src/device/shading/lighting.h"

namespace sluice {

// With the differences d of values from texel to texel, the mean square of those slopes along one
// axis, in values a texel, is kSpreadPart * spread^2 - kSlopePart * |d|^2, but at least 0: a fifth
// of the variance (spread^2 / 4) without that of an even slope (|d|^2 / 12). The fifth is measured
// on scans, sharp edges and thin shells, with texels of two and of four voxels: a tenth leaves more
// grain on scans, and a half flattens thin shells.
inline constexpr double kSpreadPart = 1.0 / 20, kSlopePart = 1.0 / 60;
// The same of the least spread, in values a voxel.
inline constexpr double kNoisePart = 0.08;

// An even slope d has a variance of |d|^2 / 12 within texels, and among the 64 means of |d|^2 / 2
// by the weights 1/4, 1/2 and 1/4 and of |d|^2 / 4 at most by interpolation. The variance in a
// texel is spread^2 / 4: it counts twice, and the power is the third, since of scans, sharp edges
// and thin shells with texels of four voxels these are closest to level 0.
inline constexpr double kEvenPart = 5.0 / 6, kOwnPart = 1.0 / 2;
// Four times kEvenPart, less the kSlopePart / kSpreadPart that e^2 takes away.
inline constexpr double kEdgePart = 3;

// Sharp edges of phantoms and soft ones of scans, with texels of two, four and eight voxels, are
// closest to level 0 with a layer of ten voxels: central differences see a step in three, and
// scanners blur it. `sharp` is 0 and 1 from these shares of the variance on.
inline constexpr double kEdgeVoxels = 10, kSoftShare = 0.2, kSharpShare = 0.7;
// Bounds that keep the quotients finite: of q and of q * (1 - q), of h in the volume's values, and
// of narrow.
inline constexpr double kLeastPart = 0.02, kLeastProduct = 1e-3, kLeastHeight = 1e-6,
                        kLeastLayer = 0.01;

// For texels of this scale, in texels a voxel: kEdgeVoxels in texels, and kNoisePart with slopes in
// values a texel.
inline double edgeTexels(Vec3d scale) {
  return kEdgeVoxels / texelLength(scale);
}
inline double noisePart(Vec3d scale) {
  return kNoisePart * texelLength(scale) * texelLength(scale);
}

// The share of a light that reaches the eye, in the mean over all directions of a surface.
inline double evenDiffuse(const Lighting& lighting, const Light& light) {
  return 0.5 * lighting.diffuse * light.strength;
}
inline double evenSpecular(const Lighting& lighting, const Light& light) {
  return lighting.specular * light.strength / (std::max(lighting.shininess, 0.0) + 1);
}

}  // namespace sluice
