// LightSquares: the second number of a LightVolume, arranged so that the eight texels around a
// place are two reads of 64 bits in place of four: texel (x, y, z) has the numbers of (x, y, z),
// (x + 1, y, z), (x, y + 1, z) and (x + 1, y + 1, z) side by side. Frames share it. It is made only
// of volumes whose key light does not vary, which stay the same from frame to frame: making it for
// a light that moves with the camera would cost more than it saves.
#pragma once

#include <cstdint>
#include <vector>

#include "src/base/threads/worker_pool.h"
#include "src/device/shading/light_volume.h"

namespace sluice {

class LightSquares {
 public:
  // Makes the squares of this volume unless it has them. One thread calls; null: forgets them.
  void take(const LightVolumePtr& light, WorkerPool& pool);
  // Null if the volume that was taken last has none. Four numbers a texel, x fastest.
  const uint64_t* texels() const { return texels_.empty() ? nullptr : texels_.data(); }

 private:
  LightVolumePtr of_;
  std::vector<uint64_t> texels_;
};

}  // namespace sluice
