// CornerBits: for each voxel of a piece a bit that is set if the voxel is inside the surface, and
// the edges between voxels that the surface crosses as bits too.
//
// Bit operations look at 64 cells at a time, so that cells that the surface does not cross cost
// next to nothing. One thread.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "src/base/values/vec.h"

namespace sluice {

class CornerBits {
 public:
  // `size` voxels along each axis, all outside. Keeps its memory.
  void reset(Vec3i size);

  Vec3i size() const { return size_; }
  int64_t words() const { return words_; }
  // The number of the row of voxels along x.
  size_t rowOf(int64_t y, int64_t z) const { return static_cast<size_t>(z * size_.y + y); }

  // Voxel x of the row is bit x % 64 of word x / 64. One word more, of zeros, ends each row.
  const uint64_t* row(int64_t y, int64_t z) const {
    return bits_.data() + rowOf(y, z) * static_cast<size_t>(words_ + 1);
  }

  // Sets voxels first..last of the row.
  void setInside(int64_t y, int64_t z, int64_t first, int64_t last);
  // Sets those of `count` voxels from `first` on whose values are in lo..hi.
  template <class T>
  void setInside(int64_t y, int64_t z, int64_t first, const T* values, int64_t count, T lo, T hi);

  // Word `word` of the edges that are crossed along the axis from the voxels of a row to the next
  // ones. Requires: the row is not the last one along y, or z.
  uint64_t crossed(int axis, int64_t y, int64_t z, int64_t word) const {
    const uint64_t* const from = row(y, z) + word;
    if (axis == 1) return from[0] ^ row(y + 1, z)[word];
    if (axis == 2) return from[0] ^ row(y, z + 1)[word];
    return (from[0] ^ (from[0] >> 1 | from[1] << 63)) & below(size_.x - 1 - 64 * word);
  }
  // Word `word` of the cells along x that the surface passes through, from the voxels of four rows.
  // Requires: the row is the last one neither along y nor z.
  uint64_t mixedCells(int64_t y, int64_t z, int64_t word) const {
    const uint64_t* const a = row(y, z) + word;
    const uint64_t* const b = row(y + 1, z) + word;
    const uint64_t* const c = row(y, z + 1) + word;
    const uint64_t* const d = row(y + 1, z + 1) + word;
    const uint64_t any = a[0] | b[0] | c[0] | d[0], all = a[0] & b[0] & c[0] & d[0];
    const uint64_t any_next = a[1] | b[1] | c[1] | d[1], all_next = a[1] & b[1] & c[1] & d[1];
    const uint64_t some = any | any >> 1 | any_next << 63;
    const uint64_t whole = all & (all >> 1 | all_next << 63);
    return some & ~whole & below(size_.x - 1 - 64 * word);
  }

  // How many edges are crossed in a row, from bit `from` on (0 or 1).
  int64_t countCrossed(int axis, int64_t y, int64_t z, int64_t from) const;

 private:
  // The lowest `count` bits, of 64 at the most.
  static uint64_t below(int64_t count) {
    return count >= 64 ? ~uint64_t{0} : count <= 0 ? 0 : (uint64_t{1} << count) - 1;
  }
  uint64_t* rowToSet(int64_t y, int64_t z) {
    return bits_.data() + rowOf(y, z) * static_cast<size_t>(words_ + 1);
  }

  Vec3i size_{0, 0, 0};
  int64_t words_ = 0;  // of a row, without the last
  std::vector<uint64_t> bits_;
  std::vector<uint8_t> flags_;  // of a row, a byte a voxel
};

// The number of bits that are set; the instruction for it is not in every processor.
inline int64_t countBits(uint64_t word) {
  word -= word >> 1 & 0x5555555555555555U;
  word = (word & 0x3333333333333333U) + (word >> 2 & 0x3333333333333333U);
  word = (word + (word >> 4)) & 0x0f0f0f0f0f0f0f0fU;
  return static_cast<int64_t>(word * 0x0101010101010101U >> 56);
}

// Calls f(x) for each bit of a word that is set, ascending; bit 0 is voxel 64 * word.
template <class F>
void forEachBit(uint64_t bits, int64_t word, F f) {
  for (; bits != 0; bits &= bits - 1) f(64 * word + std::countr_zero(bits));
}

}  // namespace sluice
