// Boxes beside a block in which its opaque surfaces are drawn, too (BoxDraw::beside), where no
// block of another level is drawn. They close the cracks between blocks of different levels of
// resolution: the means of two levels differ, so that a surface may lie on one side of a face by
// the one level and on its other side by the other. They reach as far as the texels around the
// block do, and at most a voxel of its level. Where a block of another level is drawn, both draw
// their surfaces in the cells of a seam (level_fades.h). Pure functions.
#pragma once

#include <vector>

#include "src/device/frame_values.h"
#include "src/render/frame/level_fades.h"
#include "src/texture/texture_plan.h"

namespace sluice {

struct LevelBorders {
  std::vector<BoxDraw> before, behind;  // in front of the block as the eye sees it, and behind it
};

// `box`: the block's, with its chunk. `shown`: cells that may show. Faces that the object box does
// not reach have none.
LevelBorders levelBorders(const PyramidLayout& pyramid, const TextureBlock& block,
                          const BoxDraw& box, const LevelFades& fades, const Box3& shown,
                          const EyePosition& eye);

// The cells that a block is drawn in with its borders.
Box3 cellsWithBorders(const PyramidLayout& pyramid, const TextureBlock& block, const Box3& shown);

}  // namespace sluice
