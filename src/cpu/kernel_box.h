// Boxes as the kernels take them. Pure functions.
#pragma once

#include <vector>

#include "src/cpu/kernel_values.h"
#include "src/cpu/leap_grid.h"
#include "src/device/chunk_texels.h"

namespace sluice {

// Appends the box to `out`, in parts, front to back, where offsets of its texels would not be exact
// in single precision; nothing where no pixel can see it. `bytes` are the chunk's texels, at least
// four bytes, `leaps` the chunk's where the frame leaps; all may be null where samples are only
// counted.
void appendBox(const FrameSetup& setup, const BoxDraw& box, const ChunkTexels* chunk,
               const std::byte* bytes, const LeapGrid* leaps, std::vector<KernelBox>& out);

}  // namespace sluice
