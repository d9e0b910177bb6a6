// The corners of a box of cells that clip planes cut. A pure function.
#pragma once

#include <span>
#include <vector>

#include "src/device/frame_values.h"

namespace sluice {

// The corners of the convex body that the planes leave of the box, in index space; empty if they
// leave nothing. A corner in which more than three faces meet may be there several times.
std::vector<Vec3d> clippedCorners(const Box3& box, std::span<const ClipPlane> planes);

}  // namespace sluice
