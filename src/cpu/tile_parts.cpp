#include "src/cpu/tile_parts.h"

#include <algorithm>

namespace sluice {

void TileParts::begin(const FrameSetup& setup, const FrameKernels& kernels) {
  setup_ = &setup;
  kernels_ = &kernels;
  for (int i = 0; i < kTilePixels; ++i)
    place_[static_cast<size_t>(i)] = kernels.kernels->placeOf(i % kTileSide, i / kTileSide);
  picture_ = emptyPartialPicture(setup.size);
  through_.assign(traitsOf(setup.mode).needs_order ? picture_.tiles.size() * kTilePixels : 0, 1.0F);
}

void TileParts::draw(int64_t index, const std::vector<KernelBox>& boxes,
                     std::span<const uint32_t> of_tile, TilePixels& tile) {
  // Along each ray layers ascend already.
  std::vector<uint32_t> order(of_tile.begin(), of_tile.end());
  std::stable_sort(order.begin(), order.end(),
                   [&boxes](uint32_t a, uint32_t b) { return boxes[a].layer < boxes[b].layer; });
  // The transparency of each pixel in front of the next layer: a layer is drawn alone, on an empty
  // tile.
  float* through = through_.data() + static_cast<size_t>(index) * kTilePixels;
  for (size_t from = 0; from < order.size();) {
    const uint32_t layer = boxes[order[from]].layer;
    size_t to = from;
    while (to < order.size() && boxes[order[to]].layer == layer) ++to;
    kernels_->draw(boxes.data(), order.data() + from, to - from, tile);
    from = to;
    append(index, layer, tile);
    for (size_t i = 0; i < kTilePixels; ++i) {
      through[i] *= 1 - tile.color[3][i];
      // A pixel that is opaque through the layers before takes no more samples.
      tile.stopped[i] = 1 - through[i] >= kernels_->frame().ray_opacity ? 1.0F : 0.0F;
    }
    for (float* channel : tile.color) std::fill_n(channel, kTilePixels, 0.0F);
    if (tile.depth_sum != nullptr) std::fill_n(tile.depth_sum, kTilePixels, 0.0F);
  }
}

void TileParts::takeOut(int64_t index, const TilePixels& tile) {
  append(index, 0, tile);
}

void TileParts::append(int64_t index, uint32_t layer, const TilePixels& tile) {
  const ModeTraits& traits = traitsOf(setup_->mode);
  std::array<const float*, kMostPartChannels> channels{tile.color[0], tile.color[1], tile.color[2],
                                                       tile.color[3], tile.depth_sum};
  const int width = std::min(kTileSide, setup_->size.width - tile.x);
  const int height = std::min(kTileSide, setup_->size.height - tile.y);
  packPart(
      picture_.tiles[static_cast<size_t>(index)], layer, partChannels(*setup_),
      [&](int pixel) {
        // Pixels beyond the picture's edge are no part of it.
        return pixel % kTileSide < width && pixel / kTileSide < height &&
               channels[traits.telling_number][place_[static_cast<size_t>(pixel)]] !=
                   traits.first_value;
      },
      [&](int pixel, int channel) {
        return channels[static_cast<size_t>(channel)][place_[static_cast<size_t>(pixel)]];
      });
}

}  // namespace sluice
