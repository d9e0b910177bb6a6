// DirectionGrid: viewing directions in a table over spherical coordinates (theta, phi) (Gao 2004,
// section 4, Figure 1). Directions are of index space, along the ray; a ray and its opposite pass
// through the same voxels, so that theta from the z axis to the horizon is enough.
//
// A cell of the table stands for all directions in it, not for its middle: the values kept for a
// cell hold between the samples too. Plain values, any thread.
#pragma once

#include <cstdint>
#include <vector>

#include "src/base/values/vec.h"

namespace sluice {

// The directions of a cell seen along one axis of the block: how far they go along the two others,
// in cells, for each cell along this one.
struct DirectionSlopes {
  int axis = 2;                                   // the one that the cell's middle runs along most
  double u_lo = 0, u_hi = 0, v_lo = 0, v_hi = 0;  // along axes (axis + 1) % 3 and (axis + 2) % 3
};

struct DirectionGrid {
  int rows = 4;  // rows of theta, from 0 to 90 degrees; four columns of phi for each: square cells

  int columns() const { return 4 * rows; }
  int count() const { return rows * columns(); }
  // Requires: direction is not 0.
  int cellOf(Vec3d direction) const;
  DirectionSlopes slopesOf(int cell) const;
  // The cells, ascending, in which lie all directions from `eye` to a point of the box lo..hi; all
  // cells if the eye is in the box or near it.
  std::vector<int> cellsToward(Vec3d eye, Vec3d lo, Vec3d hi) const;
  friend bool operator==(const DirectionGrid&, const DirectionGrid&) = default;
};

}  // namespace sluice
