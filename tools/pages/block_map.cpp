#include "tools/pages/block_map.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace sluice {
namespace {

constexpr int64_t kWidth = 1000, kMostHeight = 1000;  // pixels
constexpr int64_t kMostSide = 24;                     // pixels of a block
constexpr int64_t kGap = 2;                           // pixels between layers

using Rgba = std::array<uint8_t, 4>;
constexpr Rgba kWhite{138, 143, 152, 90}, kGrey{86, 180, 233, 255}, kBlack{42, 120, 184, 255};

Rgba colorOf(BlockClass kind) {
  switch (kind) {
    case BlockClass::kGrey:
      return kGrey;
    case BlockClass::kBlack:
      return kBlack;
    case BlockClass::kWhite:
      break;
  }
  return kWhite;
}

// How layers are laid out: `side` pixels a block, every `stride`th layer.
struct Sheet {
  int64_t side = 1, stride = 1, columns = 1, rows = 1;
};

int64_t layersOf(Vec3i grid, int64_t stride) {
  return (grid.z + stride - 1) / stride;
}

std::optional<Sheet> sheetFor(Vec3i grid) {
  if (grid.x > kWidth || grid.y > kMostHeight) return std::nullopt;
  // The fewest layers are left out, and then blocks are as large as the sheet allows.
  for (int64_t stride = 1; stride <= grid.z; ++stride)
    for (int64_t side = kMostSide; side >= 1; --side) {
      Sheet sheet{side, stride, 1, 1};
      sheet.columns = (kWidth + kGap) / (grid.x * side + kGap);
      if (sheet.columns == 0) continue;
      const int64_t layers = layersOf(grid, stride);
      sheet.columns = std::min(sheet.columns, layers);
      sheet.rows = (layers + sheet.columns - 1) / sheet.columns;
      if (sheet.rows * (grid.y * side + kGap) <= kMostHeight + kGap) return sheet;
    }
  return std::nullopt;
}

}  // namespace

std::optional<BlockMap> blockMap(Vec3i grid, const VisibleBlocks& blocks) {
  const std::optional<Sheet> sheet = sheetFor(grid);
  if (!sheet) return std::nullopt;
  const Vec3i tile{grid.x * sheet->side + kGap, grid.y * sheet->side + kGap, 1};
  BlockMap map;
  map.picture.width = static_cast<int>(tile.x * sheet->columns - kGap);
  map.picture.height = static_cast<int>(tile.y * sheet->rows - kGap);
  map.picture.rgba.resize(static_cast<size_t>(map.picture.width) *
                          static_cast<size_t>(map.picture.height) * 4);
  // Rows of pictures go down, y goes up.
  const auto paint = [&](Vec3i block, const Rgba& color) {
    const int64_t layer = block.z / sheet->stride;
    const int64_t x0 = layer % sheet->columns * tile.x + block.x * sheet->side;
    const int64_t y0 = layer / sheet->columns * tile.y + (grid.y - 1 - block.y) * sheet->side;
    for (int64_t y = y0; y < y0 + sheet->side; ++y)
      for (int64_t x = x0; x < x0 + sheet->side; ++x)
        std::copy(color.begin(), color.end(),
                  map.picture.rgba.begin() + (y * map.picture.width + x) * 4);
  };
  for (int64_t z = 0; z < grid.z; z += sheet->stride)
    for (int64_t y = 0; y < grid.y; ++y)
      for (int64_t x = 0; x < grid.x; ++x) paint({x, y, z}, kWhite);
  for (const ObjectBlock& block : blocks.blocks) {
    const Vec3i at{block.name.block % grid.x, block.name.block / grid.x % grid.y,
                   block.name.block / (grid.x * grid.y)};
    if (at.z % sheet->stride == 0) paint(at, colorOf(block.kind));
  }
  map.caption = fmt::format("{} x {} x {} blocks, a layer along z after another, y upwards", grid.x,
                            grid.y, grid.z);
  if (sheet->stride > 1) map.caption += fmt::format("; every {}th layer", sheet->stride);
  return map;
}

}  // namespace sluice
