#include "src/cpu/tile_bins.h"

#include <algorithm>

namespace sluice {
namespace {

struct TileGrid {
  int across, up, lowest;
};

template <class Visit>
void eachTile(const KernelBox& box, const TileGrid& grid, Visit&& visit) {
  const int top = std::min((box.y_hi - 1) / kTileSide, grid.lowest + grid.up - 1);
  for (int y = std::max(box.y_lo / kTileSide, grid.lowest); y <= top; ++y)
    for (int x = box.x_lo / kTileSide; x <= (box.x_hi - 1) / kTileSide; ++x)
      visit(static_cast<size_t>(y - grid.lowest) * static_cast<size_t>(grid.across) +
            static_cast<size_t>(x));
}

}  // namespace

TileBins tileBins(std::span<const KernelBox> boxes, int tiles_across, int tiles_up, int lowest) {
  const TileGrid grid{tiles_across, tiles_up, lowest};
  const size_t tiles = static_cast<size_t>(tiles_across) * static_cast<size_t>(tiles_up);
  TileBins bins;
  bins.first.assign(tiles + 1, 0);
  for (const KernelBox& box : boxes)
    eachTile(box, grid, [&](size_t tile) { ++bins.first[tile + 1]; });
  for (size_t tile = 0; tile < tiles; ++tile) bins.first[tile + 1] += bins.first[tile];
  bins.boxes.resize(bins.first[tiles]);
  std::vector<size_t> next(bins.first.begin(), bins.first.end() - 1);
  for (size_t i = 0; i < boxes.size(); ++i)
    eachTile(boxes[i], grid,
             [&](size_t tile) { bins.boxes[next[tile]++] = static_cast<uint32_t>(i); });
  return bins;
}

}  // namespace sluice
