// Faces at which blocks of different levels of resolution meet. A pure function.
#pragma once

#include <vector>

#include "src/classify/blocks/classification.h"
#include "src/volume/pyramid.h"

namespace sluice {

// Sets ObjectBlock::level_faces of a cut's blocks. Faces of the volume border nothing.
void setLevelFaces(const PyramidLayout& pyramid, std::vector<ObjectBlock>& blocks);

}  // namespace sluice
