// LeastOpacity: the least opacity of the pixels around each cell of a grid, see
// Device::leastOpacity(), gathered tile by tile by the threads that draw them.
#pragma once

#include <atomic>
#include <cstdint>
#include <vector>

#include "src/base/values/vec.h"
#include "src/cpu/tiled_picture.h"
#include "src/device/frame_values.h"

namespace sluice {

class LeastOpacity {
 public:
  LeastOpacity(const MapGrid& grid, PictureSize size);

  // The pixels of a tile, as they are now; without colours nothing was drawn there. Any thread.
  void add(const TiledPicture& picture, const TilePixels& pixels);
  // The least opacity of each cell, row after row.
  std::vector<float> cells() const;

 private:
  const PictureSize size_;
  const int side_;
  Vec3d to_u_, to_v_, to_w_;                  // rows that take (clip x, clip y, 1) to the map
  std::vector<std::atomic<uint32_t>> cells_;  // bits of floats that are not negative
};

}  // namespace sluice
