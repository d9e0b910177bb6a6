// BrickGrid: the intervals of the values and of the gradient magnitudes in each small brick of
// cells of one block. All that growing boxes and their tree need to know of the voxels, in a
// thousandth of their number.
//
// Cells, not voxels (design, point 2): a brick's interval includes every voxel that a corner of its
// cells touches, so it bounds every sample interpolated inside, faces included. Gradients are
// central differences with the outermost voxels repeated, as lit chunks hold them; their interval
// bounds the magnitude of an interpolated gradient and of interpolated magnitudes alike. Immutable
// once built; any thread may read.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "src/base/values/vec.h"
#include "src/volume/voxels/device_voxel.h"

namespace sluice {

// Closed intervals: device values, and device values a voxel length of the finest spacing.
struct CellRange {
  float lo = 0, hi = 0;
  float gradient_lo = 0, gradient_hi = 0;

  float width() const { return hi - lo; }
  friend bool operator==(const CellRange&, const CellRange&) = default;
};
inline CellRange unite(const CellRange& a, const CellRange& b) {
  return {std::min(a.lo, b.lo), std::max(a.hi, b.hi), std::min(a.gradient_lo, b.gradient_lo),
          std::max(a.gradient_hi, b.gradient_hi)};
}

// Device voxels in memory, x fastest and packed; not owned.
struct VoxelSpan {
  Box3 voxels;
  DeviceType type = DeviceType::kU8;
  const std::byte* bytes = nullptr;
};

struct BrickGrid {
  Box3 cells;                     // the block's cells, in the volume
  int64_t side = 4;               // cells of a brick; the last ones of a row may have fewer
  Vec3i size;                     // bricks along each axis
  std::vector<CellRange> bricks;  // x fastest

  const CellRange& at(Vec3i brick) const {
    return bricks[static_cast<size_t>((brick.z * size.y + brick.y) * size.x + brick.x)];
  }
  // The cells of a box of bricks, relative to cells.lo.
  Box3 cellsOf(const Box3& box) const { return {box.lo * side, min(box.hi * side, cells.size())}; }
  // The bricks that hold a box of cells relative to cells.lo.
  Box3 bricksOf(const Box3& local) const {
    const Vec3i up{side - 1, side - 1, side - 1}, by{side, side, side};
    return {local.lo / by, (local.hi + up) / by};
  }
};
// The range over all cells of a box of bricks. Requires: not empty.
CellRange rangeOf(const BrickGrid& grid, const Box3& bricks);

// Limit of bricks along an axis: the side is doubled until it holds.
inline constexpr int64_t kMostBricks = 64;

// `voxels` holds every corner of `cells`, and one layer around them wherever the volume goes on: a
// missing layer counts as the volume's edge. `voxel_size`: spacing in units of the finest.
// Requires: cells not empty, side >= 1.
BrickGrid brickGrid(const VoxelSpan& voxels, const Box3& cells, int64_t side,
                    Vec3d voxel_size = {1, 1, 1});

}  // namespace sluice
