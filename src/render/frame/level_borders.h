// Boxes beside a block in which its opaque surfaces are drawn, too (BoxDraw::beside). They close
// the cracks between blocks of different levels of resolution: the means of two levels differ, so
// that a surface may lie on one side of a face by the one level and on its other side by the other.
// They reach as far as the texels around the block do, and at most a voxel of its level. Pure
// functions.
#pragma once

#include <vector>

#include "src/device/frame_values.h"
#include "src/texture/texture_plan.h"

namespace sluice {

struct LevelBorders {
  std::vector<BoxDraw> before, behind;  // in front of the block as the eye sees it, and behind it
};

// Whether rays pass what lies below a plane across the axis before what lies above it.
bool passesLowerFirst(const EyePosition& eye, int axis, int64_t plane);

// `box`: the block's, with its chunk. `shown`: cells that may show. Faces that the object box does
// not reach have none.
LevelBorders levelBorders(const PyramidLayout& pyramid, const TextureBlock& block,
                          const BoxDraw& box, const Box3& shown, const EyePosition& eye);

// The cells that a block is drawn in with its borders.
Box3 cellsWithBorders(const PyramidLayout& pyramid, const TextureBlock& block, const Box3& shown);

}  // namespace sluice
