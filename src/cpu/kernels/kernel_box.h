// Boxes as the kernels take them. Pure functions.
#pragma once

#include <span>
#include <vector>

#include "src/cpu/kernels/kernel_values.h"
#include "src/cpu/leap_grid.h"
#include "src/device/chunk_texels.h"

namespace sluice {

// Appends the box to `out`, in parts, front to back, if offsets of its texels would not be exact in
// single precision; nothing if no pixel can see it. `leaps` are the chunk's if the frame leaps;
// both may be null if samples are only counted. Requires: the chunk has the texels around the box's
// cells, see BoxDraw.
void appendBox(const FrameSetup& setup, const BoxDraw& box, const ChunkTexels* chunk,
               const LeapGrid* leaps, std::vector<KernelBox>& out);

// A box of one of several channels, with its chunk.
struct ChannelBox {
  BoxDraw box;
  const ChunkTexels* chunk = nullptr;
  const LeapGrid* leaps = nullptr;
};
// The same for a block's boxes, which join the first of them.
void appendJoined(const FrameSetup& setup, std::span<const ChannelBox> boxes,
                  std::vector<KernelBox>& out);

}  // namespace sluice
