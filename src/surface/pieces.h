// Pieces: the parts that a surface is made in, rows of neighbouring blocks along x.
//
// Pieces lie on a regular grid, so that each face of a piece is a face of one neighbour at the
// most. Edges of cells on a face belong to the piece that comes first, and so do the vertices on
// them. Plain values and pure functions.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "src/surface/block_states.h"
#include "src/volume/block_layout.h"

namespace sluice {

// The cells that the surface is made of, not empty.
struct SurfaceRegion {
  Box3 cells;
  // The surface is closed along the border: there, one layer of cells more ends in voxels that are
  // outside.
  bool is_closed = false;

  // The voxels at the cells' corners, without that layer.
  Box3 voxels() const { return {cells.lo, cells.hi + Vec3i{1, 1, 1}}; }
};

struct Piece {
  Vec3i index;                                     // in the grid of pieces
  Box3 blocks;                                     // by their indices; one along y and z
  Box3 cells;                                      // the layer around a closed region included
  std::array<bool, 3> has_before{}, has_behind{};  // neighbours along each axis

  // Along each axis of the voxels at the cells' corners.
  Vec3i voxels() const { return cells.size() + Vec3i{1, 1, 1}; }
};

class PieceGrid {
 public:
  // `row_blocks`: blocks of a piece along x.
  PieceGrid(const BlockLayout& layout, const SurfaceRegion& region, int64_t row_blocks)
      : layout_(layout),
        region_(region),
        row_blocks_(row_blocks),
        size_{ceilDiv(layout.grid.x, row_blocks), layout.grid.y, layout.grid.z} {}

  const BlockLayout& layout() const { return layout_; }
  const SurfaceRegion& region() const { return region_; }
  int64_t idOf(Vec3i index) const { return (index.z * size_.y + index.y) * size_.x + index.x; }
  // Its cells are empty if it does not reach into the region.
  Piece piece(int64_t id) const;
  // The ids of the pieces that have a mixed block in the region, ascending.
  std::vector<int64_t> mixedPieces(const BlockStates& states) const;

 private:
  BlockLayout layout_;
  SurfaceRegion region_;
  int64_t row_blocks_;
  Vec3i size_;  // pieces along each axis
};

}  // namespace sluice
