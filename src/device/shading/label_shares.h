// The look of labels in coarse voxels, each of which has its most frequent label and that label's
// share of the finest voxels in it (ChunkTexels).
//
// A label that shows nothing, of opacity 0, does not compete for a sample: the sample takes the
// label of the greatest weight among those of the eight texels around it that show. `share` is what
// the shown labels have there,
//   sum of weight * (the texel's label shows ? its share : body * (1 - its share)).
// The rest of a voxel, which a hidden label leaves, belongs to the body beside it; without that,
// the outer voxels of a body, less than half of which it fills, would be holes around it. A label
// is as much of a body as it fills the fullest of the eight texels that show:
//   body = clamp(4 * the greatest share of them - 2, 0, 1).
// A plate or a vessel that fills half of each voxel at the most is none. What hidden labels leave
// beside it may be another hidden label's.
//
// Interpolating shares spreads the edge of a body over two voxels, and hides more behind it than
// the body does. So a body's share counts as a step around one half, where the surface of the
// finest voxels lies:
//   part = (1 - body) * share + body * clamp(2 * share - 1/2, 0, 1).
//
// The labels of bodies are no fog: what hides a ray in the front half of a voxel hides the back
// half, too. So the part applies to the opacity of a whole voxel, and not to that of a unit length:
// a sample of l unit lengths in voxels of v has the opacity 1 - (1 - part * a)^(l / v), where a is
// the opacity of v unit lengths.
//
// Light falls on the slopes of the labels' opacity, see lighting.h; around a place where one label
// alone shows, on those of its opacity times its share, or times what hidden labels leave to a
// body, or the surface would have the steps of the coarse voxels. Between two labels that show,
// each voxel counts whole: their shares would make a furrow there.
#pragma once

#include <cmath>

#include "src/base/values/vec.h"

namespace sluice {

// The side of a cube as large as a texel, in voxels of level 0. `scale`: texels a voxel, along each
// axis.
inline double texelLength(Vec3d scale) {
  return 1 / std::cbrt(std::abs(scale.x * scale.y * scale.z));
}

}  // namespace sluice
