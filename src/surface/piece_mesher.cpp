#include "src/surface/piece_mesher.h"

#include <algorithm>
#include <utility>

#include "src/surface/cell_table.h"
#include "src/surface/vertex_maker.h"

namespace sluice {

uint64_t PieceMesher::heldBytes(Vec3i voxels) {
  const auto plane = static_cast<uint64_t>(voxels.x * voxels.y);
  constexpr uint64_t kEdges = 5;      // a voxel of two planes, and between them
  constexpr uint64_t kEncoded = 256;  // of a cell's triangles and vertices as text
  const uint64_t vertices = kEdges * plane * (sizeof(MeshVertex) + sizeof(uint64_t));
  const uint64_t row = static_cast<uint64_t>(voxels.x) * kMostCellTriangles;
  // A part ends with a plane of cells.
  return vertices + kEdges * plane * sizeof(uint32_t) + row * sizeof(MeshTriangle) +
         2 * (kPartBytes + plane * kEncoded);
}

bool PieceMesher::mesh(const MeshedPiece& piece, const TakePart& take) {
  return visitDeviceType(piece.voxels.type(),
                         [&](auto tag) { return meshAs<decltype(tag)>(piece, take); });
}

template <class T>
bool PieceMesher::meshAs(const MeshedPiece& piece, const TakePart& take) {
  const Vec3i size = piece.bits.size();
  clear(upper_, size);
  addPlane<T>(piece, 0, upper_);
  for (int64_t z = 0; z + 1 < size.z; ++z) {
    stop_.throwIfStopped();
    // The upper plane of the last cells is the lower one of the next: each vertex is made once.
    std::swap(lower_, upper_);
    clear(between_, size);
    for (int64_t y = 0; y < size.y; ++y) addRow<T>(piece, 2, y, z, between_);
    clear(upper_, size);
    addPlane<T>(piece, z + 1, upper_);
    addTriangles(piece, z);
    // A part leaves only between two planes of cells, so that heldBytes() can tell how far it may
    // exceed its size.
    if (part_.bytes() >= kPartBytes && !take(part_, false)) return false;
  }
  return take(part_, true);
}

void PieceMesher::clear(Sheet& sheet, Vec3i size) const {
  sheet.vertices.clear();
  sheet.numbers.clear();
  for (auto& places : sheet.places) places.resize(static_cast<size_t>(size.x * size.y));
}

template <class T>
void PieceMesher::addPlane(const MeshedPiece& piece, int64_t z, Sheet& sheet) {
  const int64_t rows = piece.bits.size().y;
  for (int64_t y = 0; y < rows; ++y) {
    addRow<T>(piece, 0, y, z, sheet);
    if (y + 1 < rows) addRow<T>(piece, 1, y, z, sheet);
  }
}

template <class T>
void PieceMesher::addRow(const MeshedPiece& piece, int axis, int64_t y, int64_t z, Sheet& sheet) {
  const VertexMaker<T> maker(look_.place, look_.inside, look_.to_lower);
  const auto of_axis = static_cast<size_t>(axis);
  const size_t row = piece.bits.rowOf(y, z);
  const size_t begin = sheet.vertices.size();
  uint32_t* const places = sheet.places[of_axis].data() + y * piece.bits.size().x;
  const int64_t first = firstOwned(piece.piece, axis);
  uint64_t number = piece.numbers.first[of_axis][row];
  size_t left = 0;  // vertices at x = 0 that belong to the piece before
  const Box3 existing = piece.region.voxels();
  auto run = piece.voxels.runs().begin();
  for (int64_t word = 0; word < piece.bits.words(); ++word)
    forEachBit(piece.bits.crossed(axis, y, z, word), word, [&](int64_t x) {
      places[x] = static_cast<uint32_t>(sheet.vertices.size());
      const Vec3i voxel = piece.piece.cells.lo + Vec3i{x, y, z};
      Vec3i next = voxel;
      ++next[axis];
      // In the layer that closes the surface, one end of an edge lies outside the volume and has no
      // value to interpolate.
      if (!existing.contains(voxel)) {
        sheet.vertices.push_back(borderVertex(look_.place, next, axis, false));
      } else if (!existing.contains(next)) {
        sheet.vertices.push_back(borderVertex(look_.place, voxel, axis, true));
      } else {
        // The runs of a piece and the edges of a row both ascend along x.
        while (run + 1 != piece.voxels.runs().end() && voxel.x > run->cells.hi.x) ++run;
        sheet.vertices.push_back(maker.onEdge(*run, voxel, axis));
      }
      const bool is_left = x < first;
      left += is_left ? 1 : 0;
      // A vertex at x = 0 of another piece is only referred to: that piece has written it.
      sheet.numbers.push_back(is_left ? piece.numbers.left[of_axis][row] : number++);
    });
  // The rows on a face towards a piece before are made again, for the triangles, and not written.
  if (ownsRow(piece.piece, axis, y, z))
    file_.encode(std::span<const MeshVertex>(sheet.vertices).subspan(begin + left), part_);
}

void PieceMesher::addTriangles(const MeshedPiece& piece, int64_t z) {
  const CornerBits& bits = piece.bits;
  const Vec3i size = bits.size();
  const CellTable& table = cellTable();
  for (int64_t y = 0; y + 1 < size.y; ++y) {
    // The place of the vertex of each edge of the row's first cell.
    struct Edge {
      const Sheet* sheet;
      const uint32_t* places;
    };
    std::array<Edge, 12> edges{};
    for (int e = 0; e < 12; ++e) {
      const auto [axis, corner] = cellEdge(e);
      const Sheet& sheet = axis == 2 ? between_ : corner >= 4 ? upper_ : lower_;
      edges[static_cast<size_t>(e)] = {&sheet, sheet.places[static_cast<size_t>(axis)].data() +
                                                   (y + (corner >> 1 & 1)) * size.x + (corner & 1)};
    }
    const std::array<const uint64_t*, 4> rows{bits.row(y, z), bits.row(y + 1, z),
                                              bits.row(y, z + 1), bits.row(y + 1, z + 1)};
    triangles_.clear();
    for (int64_t word = 0; word < bits.words(); ++word)
      forEachBit(bits.mixedCells(y, z, word), word, [&](int64_t x) {
        const int64_t bit = x % 64;
        size_t inside = 0;
        for (size_t r = 0; r < 4; ++r) {
          const uint64_t here = rows[r][word] >> bit;
          // The cell at a word's last bit has its other corner in the next word.
          const uint64_t pair = bit == 63 ? (here & 1) | rows[r][word + 1] << 1 : here;
          inside |= static_cast<size_t>(pair & 3) << (2 * r);
        }
        const CellCase& of_cell = table[inside];
        for (size_t t = 0; t < of_cell.count; ++t) {
          MeshTriangle& triangle = triangles_.emplace_back();
          for (size_t c = 0; c < 3; ++c) {
            const Edge& edge = edges[of_cell.triangles[t][c]];
            const uint32_t place = edge.places[x];
            triangle[c] = {&edge.sheet->vertices[place], edge.sheet->numbers[place]};
          }
          // The table's triangles turn counterclockwise in the space of x, y and z, which a mirror
          // reverses.
          if (look_.place.is_mirrored) std::swap(triangle[1], triangle[2]);
        }
      });
    file_.encode(std::span<const MeshTriangle>(triangles_), part_);
  }
}

}  // namespace sluice
