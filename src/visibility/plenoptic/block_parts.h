// BlockParts: the least extinction in each part of a block, a few cells a side. The opacity
// functions of a block are computed from them (opacity_function.h), and they occlude when the block
// as a whole has holes.
//
// Cells, not voxels, see the design: a sample in a cell lies between its eight voxels' values. In a
// part, which is connected, it lies between the least and the greatest of its voxels, and each
// value between may occur. So the bound is the least of that interval, and tight. Plain values.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "src/base/values/vec.h"
#include "src/visibility/plenoptic/extinction.h"

namespace sluice {

// How a block is cut into parts: `side` cells each, and the rest in the last part of an axis.
struct PartGrid {
  Vec3i cells;  // the cells that the block owns
  int64_t side = 4;

  Vec3i count() const {
    return {ceilDiv(cells.x, side), ceilDiv(cells.y, side), ceilDiv(cells.z, side)};
  }
  // Relative to the block's first cell.
  Box3 cellsOf(Vec3i part) const {
    const Vec3i lo = part * side;
    return {lo, min(lo + Vec3i{side, side, side}, cells)};
  }
  friend bool operator==(const PartGrid&, const PartGrid&) = default;
};

struct BlockParts {
  PartGrid grid;
  std::vector<float> least;  // extinction a voxel length, x fastest

  bool uniform() const;
  float floor() const;  // the least of all
};

// Made from device voxels: those at the corners of the block's cells, grid.cells + 1 along each
// axis, x fastest with the given strides (in voxels).
template <class T>
BlockParts blockParts(const T* voxels, int64_t row_stride, int64_t plane_stride,
                      const PartGrid& grid, const ExtinctionTable& table);
// The parts of a block of one value.
BlockParts uniformParts(double device, const PartGrid& grid, const ExtinctionTable& table);

}  // namespace sluice
