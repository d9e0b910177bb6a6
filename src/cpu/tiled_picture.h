// TiledPicture: the pixels of a frame as the kernels keep them, a tile after another, each packet
// by packet; and what is read from them.
//
// Different tiles may be drawn by different threads at once. All else: one thread, which hands its
// loops to the pool.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "io/pictures/picture.h"
#include "src/base/worker_pool.h"
#include "src/cpu/kernel_values.h"

namespace sluice {

class TiledPicture {
 public:
  explicit TiledPicture(WorkerPool& pool) : pool_(pool) {}

  // Empty pixels, placed as `kernels` want them.
  void clear(const FrameSetup& setup, const Kernels& kernels);

  int tilesAcross() const { return across_; }
  int tilesUp() const { return up_; }
  int64_t tiles() const { return int64_t{across_} * up_; }
  TilePixels tile(int64_t index);

  // See Device.
  std::vector<float> leastOpacity(const MapGrid& grid);
  void stopOpaque(float opacity);
  // Premultiplied, rows downwards; depths where there are some. Into `picture`, whatever it held.
  void copyTo(const FrameSetup& setup, Picture& picture);

 private:
  size_t placeOf(int x, int y) const {
    return static_cast<size_t>(place_[static_cast<size_t>(y * kTileSide + x)]);
  }
  // Floats a tile has, and of them where each array begins.
  size_t floatsATile() const { return arrays_ * kTilePixels; }

  WorkerPool& pool_;
  // Of each pixel of a tile, row after row: Kernels::placeOf().
  std::array<int, kTilePixels> place_{};
  PictureSize size_{0, 0};
  int across_ = 0, up_ = 0;
  size_t arrays_ = 0;
  bool with_depth_ = false;
  std::vector<float> memory_;  // aligned by hand
  float* pixels_ = nullptr;
};

}  // namespace sluice
