// The values on both sides of surfaces, as looks of their own. A sheet of matter, or a gap in it,
// that is thinner than a coarse voxel shows in them: the means of such voxels may pass a surface's
// value nowhere although the finest level does. A pure function.
#pragma once

#include <vector>

#include "src/render/blocks/look.h"

namespace sluice {

// Returns two looks for each surface of a look, which show the values from its own on, and those
// below it, and the look without its surfaces if it shows something else. They are for choosing
// blocks alone: their `look_up` is empty.
std::vector<LookPtr> looksBesideSurfaces(const TimeStep& step, const Look& look);

}  // namespace sluice
