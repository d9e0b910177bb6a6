// VertexNumbers: gives the vertices of all pieces their numbers in the file, each vertex one.
//
// Vertices are numbered piece by piece, so that the file is the same for any number of threads. A
// vertex on a face between pieces belongs to the earlier one, and its number follows from that of
// the first vertex in its row of edges: both pieces see the same edges there. Pieces pass on these
// first numbers of the rows on their faces, a few kilobytes a piece; the vertices themselves are
// not kept. number() may be called from any thread, once for each piece, and waits for the pieces
// before.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <utility>
#include <vector>

#include "src/base/threads/mutex.h"
#include "src/surface/corner_bits.h"
#include "src/surface/pieces.h"

namespace sluice {

struct RowNumbers {
  // By the axis of the edges and the row of voxels that they begin in (CornerBits::rowOf): the
  // number of the first vertex of the row that lies at x > 0, or at any x of a piece that has none
  // before it along x.
  std::array<std::vector<uint64_t>, 3> first;
  // The number of the vertex at x = 0 of the rows along y and z, of the other pieces.
  std::array<std::vector<uint64_t>, 3> left;
  uint64_t count = 0;  // vertices that belong to the piece
};

// Whether the edges along the axis that begin in a row belong to the piece, but for those at x = 0.
inline bool ownsRow(const Piece& piece, int axis, int64_t y, int64_t z) {
  const bool is_before_y = axis != 1 && y == 0 && piece.has_before[1];
  const bool is_before_z = axis != 2 && z == 0 && piece.has_before[2];
  return !is_before_y && !is_before_z;
}
// The first voxel along x from which edges of the axis belong to the piece.
inline int64_t firstOwned(const Piece& piece, int axis) {
  return axis != 0 && piece.has_before[0] ? 1 : 0;
}

// Numbers from 0 in the order of the file: plane by plane of voxels along z, of each the rows'
// edges along x and y, then the edges to the next plane. Keeps its memory. Pure otherwise.
void countVertices(const Piece& piece, const CornerBits& bits, RowNumbers& numbers);

class VertexNumbers {
 public:
  // `pieces`: the ids of all pieces that are numbered, ascending; both must outlive it.
  VertexNumbers(const PieceGrid& grid, std::span<const int64_t> pieces)
      : grid_(grid), pieces_(pieces) {}

  // Makes the numbers of countVertices() those of the file. `at`: the position of the piece in
  // `pieces`. False if the work was given up.
  bool number(size_t at, const Piece& piece, const CornerBits& bits, RowNumbers& numbers);
  // Ends all waiting.
  void giveUp();
  // Vertices that have numbers.
  uint64_t count() const;

 private:
  // The face that a piece passes on to the next one along an axis.
  using Face = std::pair<int64_t, int>;  // the id of the next one, and the axis

  bool isNumbered(int64_t id) const;
  void takeFaces(int64_t id, Vec3i size, RowNumbers& numbers) SLUICE_REQUIRES(mutex_);
  void passFaces(const Piece& piece, const CornerBits& bits, const RowNumbers& numbers)
      SLUICE_REQUIRES(mutex_);

  const PieceGrid& grid_;
  const std::span<const int64_t> pieces_;
  mutable Mutex mutex_;
  Condition changed_;
  size_t turn_ SLUICE_GUARDED_BY(mutex_) = 0;
  bool is_given_up_ SLUICE_GUARDED_BY(mutex_) = false;
  uint64_t count_ SLUICE_GUARDED_BY(mutex_) = 0;
  std::map<Face, std::vector<uint64_t>> faces_ SLUICE_GUARDED_BY(mutex_);
};

}  // namespace sluice
