// PieceMesher: the vertices and triangles of one piece, plane by plane along z, from its bits,
// numbers and voxels. It holds the vertices of two planes of voxels and of the edges between them
// alone, so that a piece may have any number of triangles. One thread; keeps its memory from piece
// to piece.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include "io/meshes/mesh_file.h"
#include "src/base/threads/stop_token.h"
#include "src/surface/corner_bits.h"
#include "src/surface/inside_set.h"
#include "src/surface/piece_voxels.h"
#include "src/surface/surface_place.h"
#include "src/surface/vertex_numbers.h"

namespace sluice {

// Takes what was made so far, which stays in order, and leaves the part empty; false ends the work.
using TakePart = std::function<bool(MeshPart& part, bool is_last)>;

struct MeshedPiece {
  const Piece& piece;
  const SurfaceRegion& region;
  const CornerBits& bits;
  const RowNumbers& numbers;
  const PieceVoxels& voxels;
};

class PieceMesher {
 public:
  struct Look {
    SurfacePlace place;
    InsideSet inside;
    double to_lower = -1;  // see VertexMaker
  };
  // `file` encodes; it must outlive the mesher.
  PieceMesher(const MeshFile& file, const Look& look, StopToken stop)
      : file_(file), look_(look), stop_(std::move(stop)) {}

  // Hands over parts of about kPartBytes. False if `take` ended the work. Throws Interrupted and
  // the errors of `take`.
  bool mesh(const MeshedPiece& piece, const TakePart& take);

  static constexpr uint64_t kPartBytes = uint64_t{1} << 20;
  // The most that it holds for a piece of so many voxels.
  static uint64_t heldBytes(Vec3i voxels);

 private:
  // Vertices on the edges that begin in a plane of voxels, in the order of their rows.
  struct Sheet {
    std::vector<MeshVertex> vertices;
    std::vector<uint64_t> numbers;
    // By the axis of the edge and the voxel [y][x] that it begins at: the place in `vertices`, only
    // valid for edges that the surface crosses.
    std::array<std::vector<uint32_t>, 3> places;
  };

  template <class T>
  bool meshAs(const MeshedPiece& piece, const TakePart& take);
  template <class T>
  void addRow(const MeshedPiece& piece, int axis, int64_t y, int64_t z, Sheet& sheet);
  template <class T>
  void addPlane(const MeshedPiece& piece, int64_t z, Sheet& sheet);
  void addTriangles(const MeshedPiece& piece, int64_t z);
  void clear(Sheet& sheet, Vec3i size) const;

  const MeshFile& file_;
  const Look look_;
  const StopToken stop_;
  Sheet lower_, between_, upper_;        // planes z and z + 1 of voxels; edges along z from z on
  std::vector<MeshTriangle> triangles_;  // of a row of cells
  MeshPart part_;
};

}  // namespace sluice
