#include "src/cpu/tile_bins.h"

namespace sluice {
namespace {

template <class Visit>
void eachTile(const KernelBox& box, int tiles_across, Visit&& visit) {
  for (int y = box.y_lo / kTileSide; y <= (box.y_hi - 1) / kTileSide; ++y)
    for (int x = box.x_lo / kTileSide; x <= (box.x_hi - 1) / kTileSide; ++x)
      visit(static_cast<size_t>(y) * static_cast<size_t>(tiles_across) + static_cast<size_t>(x));
}

}  // namespace

TileBins tileBins(std::span<const KernelBox> boxes, int tiles_across, int tiles_up) {
  const size_t tiles = static_cast<size_t>(tiles_across) * static_cast<size_t>(tiles_up);
  TileBins bins;
  bins.first.assign(tiles + 1, 0);
  for (const KernelBox& box : boxes)
    eachTile(box, tiles_across, [&](size_t tile) { ++bins.first[tile + 1]; });
  for (size_t tile = 0; tile < tiles; ++tile) bins.first[tile + 1] += bins.first[tile];
  bins.boxes.resize(bins.first[tiles]);
  std::vector<size_t> next(bins.first.begin(), bins.first.end() - 1);
  for (size_t i = 0; i < boxes.size(); ++i)
    eachTile(boxes[i], tiles_across,
             [&](size_t tile) { bins.boxes[next[tile]++] = static_cast<uint32_t>(i); });
  return bins;
}

}  // namespace sluice
