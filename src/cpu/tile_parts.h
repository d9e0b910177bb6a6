// TileParts: the visible part of the tiles of a frame's part, layer by layer (partial_picture.h): a
// layer of a tile is drawn, taken out packed, and gone from the tile's pixels.
//
// Opacity that was taken out still stops rays: a ray takes no more samples once the layers in
// front, of this part alone, are opaque. Different tiles may be drawn by different threads at once.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "src/cpu/kernels/kernel_values.h"
#include "src/device/pictures/partial_picture.h"

namespace sluice {

static_assert(kTileSide == kPartSide);

class TileParts {
 public:
  // To be called for each frame; `setup` and `kernels` must outlive it.
  void begin(const FrameSetup& setup, const FrameKernels& kernels);
  // Modes that need an order: draws these boxes of one tile, whose pixels are empty before and
  // after.
  void draw(int64_t index, const std::vector<KernelBox>& boxes, std::span<const uint32_t> of_tile,
            TilePixels& tile);
  // Other modes: called once, for the pixels that all boxes left in the tile.
  void takeOut(int64_t index, const TilePixels& tile);
  uint64_t bytes() const { return picture_.bytes(); }
  PartialPicture end() { return std::move(picture_); }

 private:
  void append(int64_t index, uint32_t layer, const TilePixels& tile);

  const FrameSetup* setup_ = nullptr;
  const FrameKernels* kernels_ = nullptr;
  std::array<int, kTilePixels> place_{};  // in a tile's arrays, of pixels row after row
  PartialPicture picture_;
  std::vector<float> through_;  // transmittance of what lies in front, for each pixel of each tile
};

}  // namespace sluice
