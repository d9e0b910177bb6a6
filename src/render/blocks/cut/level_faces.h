// Faces at which blocks of different levels of resolution meet. Pure functions.
#pragma once

#include <functional>
#include <vector>

#include "src/classify/blocks/classification.h"
#include "src/volume/pyramid.h"

namespace sluice {

// Sets ObjectBlock::level_faces of a cut's blocks. Faces of the volume border nothing.
void setLevelFaces(const PyramidLayout& pyramid, std::vector<ObjectBlock>& blocks);

// Which seams a cut has.
struct SeamQuestion {
  Box3 crop;                // cells that may show
  bool with_edges = false;  // at edges and corners, too: opaque surfaces need them
  // Blocks that the picture does not show stay coarse, and must not fade into what it shows: these
  // have no seams.
  std::function<bool(const BlockName&)> is_in_picture;
};
// The seams of a cut whose blocks ascend, where the finer block shows something next to the coarser
// one. They are as wide as the coarser block's texels reach, at most a voxel of its level. A block
// that meets another one at a face has no further seam with it. Extends the coarser blocks' object
// boxes to the seams.
std::vector<LevelSeam> takeLevelSeams(const PyramidLayout& pyramid, const SeamQuestion& question,
                                      std::vector<ObjectBlock>& blocks);

}  // namespace sluice
