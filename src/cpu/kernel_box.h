// Boxes as the kernels take them. Pure functions.
#pragma once

#include <vector>

#include "src/cpu/kernel_values.h"
#include "src/cpu/leap_grid.h"
#include "src/device/chunk_texels.h"

namespace sluice {

// Appends the box to `out`, in parts, front to back, if offsets of its texels would not be exact in
// single precision; nothing if no pixel can see it. `leaps` are the chunk's if the frame leaps;
// both may be null if samples are only counted. Requires: the chunk has the texels around the box's
// cells, see BoxDraw.
void appendBox(const FrameSetup& setup, const BoxDraw& box, const ChunkTexels* chunk,
               const LeapGrid* leaps, std::vector<KernelBox>& out);

}  // namespace sluice
