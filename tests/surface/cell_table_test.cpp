#include "src/surface/cell_table.h"

#include <gtest/gtest.h>

#include <bit>
#include <map>
#include <set>
#include <utility>
#include <vector>

#include "src/base/values/vec.h"

namespace sluice {
namespace {

using Side = std::pair<int, int>;  // from edge to edge

Vec3d cornerAt(int corner) {
  return {static_cast<double>(corner & 1), static_cast<double>(corner >> 1 & 1),
          static_cast<double>(corner >> 2)};
}
Vec3d middleOf(int edge) {
  const auto [axis, corner] = cellEdge(edge);
  Vec3d at = cornerAt(corner);
  at[axis] += 0.5;
  return at;
}
bool isCrossed(int inside, int edge) {
  const auto [axis, corner] = cellEdge(edge);
  return ((inside >> corner ^ inside >> (corner | 1 << axis)) & 1) != 0;
}
// The face that has both edges, as 2 * axis + side; -1 if none has.
int faceOf(int a, int b) {
  const Vec3d u = middleOf(a), v = middleOf(b);
  for (int axis = 0; axis < 3; ++axis)
    for (int side = 0; side < 2; ++side)
      if (u[axis] == side && v[axis] == side) return 2 * axis + side;
  return -1;
}
// The sides of a case's triangles that no other triangle of the cell shares.
std::set<Side> openSides(int inside) {
  std::set<Side> open;
  const CellCase& of_cell = cellTable()[static_cast<size_t>(inside)];
  for (size_t t = 0; t < of_cell.count; ++t)
    for (size_t i = 0; i < 3; ++i) {
      const Side side{of_cell.triangles[t][i], of_cell.triangles[t][(i + 1) % 3]};
      if (open.erase({side.second, side.first}) > 0) continue;
      EXPECT_TRUE(open.insert(side).second);
    }
  return open;
}

TEST(CellTable, edgesBeginAtTheCornersInOrder) {
  std::set<std::pair<int, int>> seen;
  for (int edge = 0; edge < 12; ++edge) {
    const auto [axis, corner] = cellEdge(edge);
    EXPECT_EQ(corner >> axis & 1, 0);
    EXPECT_TRUE(seen.insert({axis, corner}).second);
  }
}

TEST(CellTable, trianglesHaveAVertexOnEachEdgeThatIsCrossedAndOnNoOther) {
  for (int inside = 0; inside < 256; ++inside) {
    const CellCase& of_cell = cellTable()[static_cast<size_t>(inside)];
    std::set<int> used;
    for (size_t t = 0; t < of_cell.count; ++t)
      for (const uint8_t edge : of_cell.triangles[t]) used.insert(edge);
    for (int edge = 0; edge < 12; ++edge)
      EXPECT_EQ(used.count(edge) == 1, isCrossed(inside, edge)) << inside << " " << edge;
  }
}

TEST(CellTable, openSidesLieInFacesAndInnerSidesDoNot) {
  for (int inside = 0; inside < 256; ++inside) {
    const std::set<Side> open = openSides(inside);
    for (const auto& [a, b] : open) EXPECT_GE(faceOf(a, b), 0) << inside;
    const CellCase& of_cell = cellTable()[static_cast<size_t>(inside)];
    for (size_t t = 0; t < of_cell.count; ++t)
      for (size_t i = 0; i < 3; ++i) {
        const Side side{of_cell.triangles[t][i], of_cell.triangles[t][(i + 1) % 3]};
        if (open.count(side) > 0) continue;
        EXPECT_EQ(faceOf(side.first, side.second), -1) << inside;
      }
  }
}

// The sides on a face, with edges named by their places in the plane of the face.
std::set<std::pair<std::pair<double, double>, std::pair<double, double>>> sidesOn(int inside,
                                                                                  int face) {
  std::set<std::pair<std::pair<double, double>, std::pair<double, double>>> sides;
  const int u = (face / 2 + 1) % 3, v = (face / 2 + 2) % 3;
  const auto place = [&](int edge) {
    const Vec3d at = middleOf(edge);
    return std::pair(at[u], at[v]);
  };
  for (const auto& [a, b] : openSides(inside))
    if (faceOf(a, b) == face) sides.insert({place(a), place(b)});
  return sides;
}

TEST(CellTable, bothCellsBesideAFaceHaveTheSameSidesInOppositeDirections) {
  for (int axis = 0; axis < 3; ++axis) {
    // By the corners of the face: bits of the four corners, ascending.
    std::map<int, decltype(sidesOn(0, 0))> of_face;
    for (int inside = 0; inside < 256; ++inside)
      for (int side = 0; side < 2; ++side) {
        int corners = 0, bit = 0;
        for (int corner = 0; corner < 8; ++corner)
          if ((corner >> axis & 1) == side) corners |= (inside >> corner & 1) << bit++;
        auto sides = sidesOn(inside, 2 * axis + side);
        if (side == 0) {
          decltype(sides) turned;
          for (const auto& [a, b] : sides) turned.insert({b, a});
          sides = turned;
        }
        const auto [known, is_new] = of_face.try_emplace(corners, sides);
        EXPECT_EQ(known->second, sides) << inside << " axis " << axis << " side " << side;
      }
    EXPECT_EQ(of_face.size(), 16U);
  }
}

TEST(CellTable, trianglesAreSeenCounterclockwiseFromOutside) {
  for (int corner = 0; corner < 8; ++corner)
    for (const bool is_inside : {true, false}) {
      const int inside = is_inside ? 1 << corner : 255 ^ 1 << corner;
      const CellCase& of_cell = cellTable()[static_cast<size_t>(inside)];
      ASSERT_EQ(of_cell.count, 1);
      const Vec3d a = middleOf(of_cell.triangles[0][0]), b = middleOf(of_cell.triangles[0][1]),
                  c = middleOf(of_cell.triangles[0][2]);
      const Vec3d from_corner = (a + b + c) / 3.0 - cornerAt(corner);
      EXPECT_GT(dot(cross(b - a, c - a), from_corner) * (is_inside ? 1 : -1), 0) << corner;
    }
}

TEST(CellTable, cornersInsideAreJoinedAcrossAFace) {
  // Two corners inside at opposite ends of a face: one piece of surface around both.
  EXPECT_EQ(cellTable()[0b00001001].count, 4);
  // Two corners outside likewise: a piece of surface around each.
  EXPECT_EQ(cellTable()[255 ^ 0b00001001].count, 2);
}

}  // namespace
}  // namespace sluice
