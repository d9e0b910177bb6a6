// The outline of a box in the world that planes cut, for the reference renderer: polygons cut by
// one plane after another (Sutherland and Hodgman 1974).
#pragma once

#include <vector>

#include "tests/support/reference_renderer.h"

namespace sluice {

// Points whose hull is what the planes leave of the box with these corners, of which bit a of a
// corner's number says on which side it lies along axis a; empty if they leave nothing.
std::vector<Vec3d> clippedPoints(const std::vector<Vec3d>& corners,
                                 const std::vector<ReferenceClipPlane>& planes);

}  // namespace sluice
