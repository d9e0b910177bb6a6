// CellTable: the triangles of the surface in a cell, for each of the 256 ways in which its corners
// lie inside or outside (Lorensen and Cline 1987, "Marching cubes").
//
// The table is derived, not listed. On each face of the cell the surface leaves segments between
// the edges that it crosses; where four are crossed, the corners inside are joined. The rule looks
// at the face alone, so both cells beside it agree and the surface has no cracks. The segments make
// closed loops, which are cut into triangles so that no triangle has a side within a face unless
// the side is a segment: sides that two cells share are then shared by exactly two triangles.
// Triangles turn counterclockwise when they are seen from outside, in the space of x, y and z.
//
// Corner c has bits x = c & 1, y = c >> 1 & 1, z = c >> 2. Edge 4 * axis + k runs along the axis
// from the k-th corner without that axis's bit, in ascending order.
#pragma once

#include <array>
#include <cstdint>

namespace sluice {

inline constexpr int kMostCellTriangles = 5;

struct CellCase {
  uint8_t count = 0;                                                   // triangles
  std::array<std::array<uint8_t, 3>, kMostCellTriangles> triangles{};  // by edges
};
// By a bit for each corner that is inside.
using CellTable = std::array<CellCase, 256>;
const CellTable& cellTable();

// The corner of the cell that an edge begins at, and its axis.
struct CellEdge {
  int axis = 0, corner = 0;
};
constexpr CellEdge cellEdge(int edge) {
  const int axis = edge / 4, k = edge % 4;
  const int low = k & ((1 << axis) - 1), high = k >> axis;
  return {axis, high << (axis + 1) | low};
}

}  // namespace sluice
