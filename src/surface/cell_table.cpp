#include "src/surface/cell_table.h"

#include <algorithm>
#include <bit>
#include <utility>
#include <vector>

#include "src/base/error.h"

namespace sluice {
namespace {

constexpr int kEdges = 12, kFaces = 6;
using Loop = std::vector<int>;  // edges

int edgeBetween(int a, int b) {
  const int axis = std::countr_zero(static_cast<unsigned>(a ^ b));
  const int corner = std::min(a, b);
  const int low = corner & ((1 << axis) - 1), high = corner >> (axis + 1);
  return 4 * axis + (high << axis | low);
}

// The corners of a face, counterclockwise when they are seen from outside the cell.
std::array<int, 4> faceCorners(int face) {
  const int axis = face / 2, side = face % 2;
  const int u = 1 << (axis + 1) % 3, v = 1 << (axis + 2) % 3, at = side << axis;
  std::array<int, 4> corners{at, at | u, at | u | v, at | v};
  if (side == 0) std::ranges::reverse(corners);
  return corners;
}

bool areOnOneFace(int a, int b) {
  for (int face = 0; face < kFaces; ++face) {
    const std::array<int, 4> corners = faceCorners(face);
    const auto has = [&](int edge) {
      for (size_t i = 0; i < 4; ++i)
        if (edgeBetween(corners[i], corners[(i + 1) % 4]) == edge) return true;
      return false;
    };
    if (has(a) && has(b)) return true;
  }
  return false;
}

// The surface's boundary within a face leads from each crossed edge to the edge listed here; edges
// that are not crossed have -1. Every crossed edge lies on two faces: it begins the segment of one
// and ends that of the other.
std::array<int, kEdges> segmentsOf(int inside) {
  std::array<int, kEdges> next{};
  next.fill(-1);
  const auto isInside = [&](int corner) { return (inside >> corner & 1) != 0; };
  for (int face = 0; face < kFaces; ++face) {
    const std::array<int, 4> corners = faceCorners(face);
    for (size_t i = 0; i < 4; ++i) {
      // Each segment is found once, at the edge where the way around the face leaves the inside.
      if (isInside(corners[i]) || !isInside(corners[(i + 1) % 4])) continue;
      // Here the way around the face comes inside; looking back, it is where it last went outside
      // that is joined, so that two corners inside are not cut apart.
      size_t out = i;
      do {
        out = (out + 3) % 4;
      } while (!isInside(corners[out]) || isInside(corners[(out + 1) % 4]));
      next[static_cast<size_t>(edgeBetween(corners[i], corners[(i + 1) % 4]))] =
          edgeBetween(corners[out], corners[(out + 1) % 4]);
    }
  }
  return next;
}

// Cuts the part of a loop from `first` to `last` into triangles; false if that needs a side within
// a face.
bool cut(const Loop& loop, size_t first, size_t last, CellCase& out) {
  if (last - first < 2) return true;
  const auto mayJoin = [&](size_t a, size_t b) {
    return b - a == 1 || !areOnOneFace(loop[a], loop[b]);
  };
  // Any cut without a side within a face will do: the first one is taken.
  for (size_t third = first + 1; third < last; ++third) {
    if (!mayJoin(first, third) || !mayJoin(third, last)) continue;
    const CellCase before = out;
    if (cut(loop, first, third, out) && cut(loop, third, last, out)) {
      out.triangles.at(out.count++) = {static_cast<uint8_t>(loop[first]),
                                       static_cast<uint8_t>(loop[third]),
                                       static_cast<uint8_t>(loop[last])};
      return true;
    }
    out = before;
  }
  return false;
}

CellCase caseOf(int inside) {
  // Each crossed edge has one segment that begins and one that ends there: following them always
  // comes back to the edge where the loop began.
  std::array<int, kEdges> next = segmentsOf(inside);
  CellCase result;
  for (int begin = 0; begin < kEdges; ++begin) {
    Loop loop;
    for (int edge = begin; next[static_cast<size_t>(edge)] >= 0;) {
      loop.push_back(edge);
      edge = std::exchange(next[static_cast<size_t>(edge)], -1);
    }
    if (loop.empty()) continue;
    const bool is_cut = cut(loop, 0, loop.size() - 1, result);
    SLUICE_CHECK(is_cut);
  }
  return result;
}

}  // namespace

const CellTable& cellTable() {
  static const CellTable table = [] {
    CellTable made;
    for (int inside = 0; inside < 256; ++inside) made[static_cast<size_t>(inside)] = caseOf(inside);
    return made;
  }();
  return table;
}

}  // namespace sluice
