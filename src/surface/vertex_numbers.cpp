#include "src/surface/vertex_numbers.h"

#include <algorithm>
#include <utility>

namespace sluice {
namespace {

// The next piece along an axis.
Vec3i behind(const Piece& piece, int axis) {
  Vec3i index = piece.index;
  ++index[axis];
  return index;
}

// Calls f(axis, row) for each row of edges on a face across y or z, in an order that is the same
// seen from both sides. `at`: the place of the face along `across`.
template <class F>
void forEachRowOnFace(Vec3i size, int across, int64_t at, F f) {
  const int along = across == 1 ? 2 : 1;  // the other axis of the rows' grid
  for (int64_t i = 0; i < size[along]; ++i) {
    const size_t row = static_cast<size_t>(across == 1 ? i * size.y + at : at * size.y + i);
    f(0, row);
    if (i + 1 < size[along]) f(along, row);
  }
}

}  // namespace

void countVertices(const Piece& piece, const CornerBits& bits, RowNumbers& numbers) {
  const Vec3i size = bits.size();
  const auto rows = static_cast<size_t>(size.y * size.z);
  for (auto& of_axis : numbers.first) of_axis.assign(rows, 0);
  // The vertices at x = 0 of these rows belong to the piece before, so that their numbers do not
  // follow from those of this piece.
  for (auto& of_axis : numbers.left) of_axis.assign(piece.has_before[0] ? rows : 0, 0);
  numbers.count = 0;
  const auto countRow = [&](int axis, int64_t y, int64_t z) {
    // The numbers of other pieces' rows come with their faces, see takeFaces().
    if (!ownsRow(piece, axis, y, z)) return;
    numbers.first[static_cast<size_t>(axis)][bits.rowOf(y, z)] = numbers.count;
    numbers.count += static_cast<uint64_t>(bits.countCrossed(axis, y, z, firstOwned(piece, axis)));
  };
  for (int64_t z = 0; z < size.z; ++z) {
    for (int64_t y = 0; y < size.y; ++y) {
      countRow(0, y, z);
      if (y + 1 < size.y) countRow(1, y, z);
    }
    if (z + 1 < size.z)
      for (int64_t y = 0; y < size.y; ++y) countRow(2, y, z);
  }
}

bool VertexNumbers::number(size_t at, const Piece& piece, const CornerBits& bits,
                           RowNumbers& numbers) {
  MutexLock lock(mutex_);
  while (turn_ != at && !is_given_up_) changed_.wait(lock);
  // A piece before this one has failed on another thread, and will never be numbered.
  if (is_given_up_) return false;
  for (auto& of_axis : numbers.first)
    for (uint64_t& first : of_axis) first += count_;
  count_ += numbers.count;
  takeFaces(pieces_[at], bits.size(), numbers);
  passFaces(piece, bits, numbers);
  ++turn_;
  changed_.notifyAll();
  return true;
}

bool VertexNumbers::isNumbered(int64_t id) const {
  return std::ranges::binary_search(pieces_, id);
}

void VertexNumbers::takeFaces(int64_t id, Vec3i size, RowNumbers& numbers) {
  for (int across = 0; across < 3; ++across) {
    const auto found = faces_.find({id, across});
    // A piece that passed on no face is not mixed: the surface crosses no edge between it and this
    // one.
    if (found == faces_.end()) continue;
    const std::vector<uint64_t> face = std::move(found->second);
    faces_.erase(found);
    size_t next = 0;
    if (across == 0) {
      for (size_t axis = 1; axis < 3; ++axis)
        for (uint64_t& number : numbers.left[axis]) number = face.at(next++);
    } else {
      forEachRowOnFace(size, across, 0, [&](int axis, size_t row) {
        numbers.first[static_cast<size_t>(axis)][row] = face.at(next++);
      });
    }
  }
}

void VertexNumbers::passFaces(const Piece& piece, const CornerBits& bits,
                              const RowNumbers& numbers) {
  const Vec3i size = bits.size();
  for (int across = 0; across < 3; ++across) {
    if (!piece.has_behind[static_cast<size_t>(across)]) continue;
    const int64_t next = grid_.idOf(behind(piece, across));
    // A piece that is not numbered would never take its face.
    if (!isNumbered(next)) continue;
    std::vector<uint64_t>& face = faces_[{next, across}];
    if (across != 0) {
      forEachRowOnFace(size, across, size[across] - 1, [&](int axis, size_t row) {
        face.push_back(numbers.first[static_cast<size_t>(axis)][row]);
      });
      continue;
    }
    // The vertex at the last x is the last one of its row.
    for (int axis = 1; axis < 3; ++axis)
      for (int64_t z = 0; z < size.z; ++z)
        for (int64_t y = 0; y < size.y; ++y) {
          const bool has_edges = axis == 1 ? y + 1 < size.y : z + 1 < size.z;
          // A row that the surface does not cross passes on a number that nobody reads.
          const int64_t count =
              has_edges ? bits.countCrossed(axis, y, z, firstOwned(piece, axis)) : 0;
          face.push_back(numbers.first[static_cast<size_t>(axis)][bits.rowOf(y, z)] +
                         static_cast<uint64_t>(std::max<int64_t>(count, 1) - 1));
        }
  }
}

void VertexNumbers::giveUp() {
  const MutexLock lock(mutex_);
  is_given_up_ = true;
  changed_.notifyAll();
}

uint64_t VertexNumbers::count() const {
  const MutexLock lock(mutex_);
  return count_;
}

}  // namespace sluice
