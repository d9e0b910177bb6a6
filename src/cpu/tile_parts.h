// TileParts: what the tiles of a frame's part show, layer by layer (partial_picture.h): a layer of
// a tile is drawn, taken out packed, and gone from the tile's pixels.
//
// What was taken out still stops rays: where the layers in front are opaque, of this part alone, no
// more samples are taken. Different tiles may be drawn by different threads at once.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "src/cpu/kernel_values.h"
#include "src/device/partial_picture.h"

namespace sluice {

static_assert(kTileSide == kPartSide);

class TileParts {
 public:
  // For a frame; `kernels` must outlive it.
  void begin(const FrameSetup& setup, const KernelFrame& frame, const Kernels& kernels);
  // Composite: draws these boxes of one tile, whose pixels are empty before and after.
  void draw(int64_t index, const std::vector<KernelBox>& boxes, std::span<const uint32_t> of_tile,
            TilePixels& tile);
  // Other modes, once, of what all boxes left in the tile's pixels.
  void takeOut(int64_t index, const TilePixels& tile);
  uint64_t bytes() const { return picture_.bytes(); }
  PartialPicture end() { return std::move(picture_); }

 private:
  void append(int64_t index, uint32_t layer, const TilePixels& tile);

  const FrameSetup* setup_ = nullptr;
  const KernelFrame* frame_ = nullptr;
  const Kernels* kernels_ = nullptr;
  std::array<int, kTilePixels> place_{};  // in a tile's arrays, of pixels row after row
  PartialPicture picture_;
  std::vector<float> through_;  // of each pixel of each tile, what lies in front lets through
};

}  // namespace sluice
