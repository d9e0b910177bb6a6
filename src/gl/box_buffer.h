// BoxBuffer: boxes to draw as the vertex shader reads them, and the index list of a cube.
//
// A box becomes kTexelsPerBox RGBA float texels: eight corners in clip space (x, y, w; and
// outerFaces(), bits 0 to 2 for x, y and z below, 3 to 5 above), the two faces relative to the
// rays' origin (and the first slice, the turn), and the texel ray at the first slice with its
// change a pixel (and the three texel coordinates of the box's lower corner). Everything is
// computed in double precision relative to the box, so that single precision is enough in the
// shader however far from the origin the box lies.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "src/device/frame_values.h"

namespace sluice {

inline constexpr int kTexelsPerBox = 13;

// Triangles of a cube whose corner i has bit a set if it lies on the upper face of axis a;
// counter-clockwise seen from outside.
inline constexpr std::array<uint8_t, 36> kCubeTriangles = {0, 4, 6, 0, 6, 2, 1, 3, 7, 1, 7, 5,
                                                           0, 1, 5, 0, 5, 4, 2, 6, 7, 2, 7, 3,
                                                           0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6};

// kTexelsPerBox * 4 floats a box.
std::vector<float> boxTexels(const FrameSetup& setup, std::span<const BoxDraw> boxes);

// True when index space is mirrored in the picture, so that a cube's triangles turn the other way.
bool isMirrored(const FrameSetup& setup);

}  // namespace sluice
