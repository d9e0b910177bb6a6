// A view as the 4 x 4 matrices that compositing programs know, row after row, for row vectors from
// the left: (x, y, z, 1) * M. Pure functions.
#pragma once

#include <array>

#include "src/render/camera/camera.h"

namespace sluice {

using Matrix4 = std::array<float, 16>;

// World to camera: x right, y up, z along the view from the eye; left-handed, as in OpenEXR and
// RenderMan.
Matrix4 cameraFromWorld(const View& view);

// World to the picture: after division by the fourth, (0, 0) is its upper left and (1, 1) its lower
// right corner. The third is the depth of a parallel view; of a perspective one it is 0 at the
// first slice in front of the eye and 1 infinitely far.
Matrix4 ndcFromWorld(const View& view);

// How wide the picture is in the world at distance 1 from a perspective eye; 1 for a parallel view.
float screenWindowWidth(const View& view);

}  // namespace sluice
