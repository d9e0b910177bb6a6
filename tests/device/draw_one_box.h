// A picture of one box, for tests of devices.
#pragma once

#include "src/device/device.h"

namespace sluice {

// Makes the chunk resident as `box.chunk`, and evicts it again.
inline Picture drawOneBox(Device& device, const FrameSetup& setup, const ChunkTexelsPtr& chunk,
                          const BoxDraw& box) {
  device.makeResident(box.chunk, chunk);
  device.beginFrame(setup);
  device.draw({&box, 1});
  Picture picture = device.endFrame();
  device.evict(box.chunk);
  return picture;
}

}  // namespace sluice
