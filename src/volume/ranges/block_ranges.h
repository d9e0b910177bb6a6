// RowRanges: the three min-max arrays of the blocks of a row from their voxels; the inner loop of
// slice_ranges.cpp, in a form that compilers turn into vector code for every voxel type.
#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "src/base/values/vec.h"
#include "src/volume/ranges/slice_ranges.h"

namespace sluice {

// The range of no voxel at all.
template <class T>
constexpr PlaneRange<T> kNoVoxels{std::numeric_limits<T>::max(), std::numeric_limits<T>::lowest()};

template <class T>
void widen(PlaneRange<T>& range, PlaneRange<T> by) {
  range.lo = std::min(range.lo, by.lo);
  range.hi = std::max(range.hi, by.hi);
}

// The range of a box of voxels, x fastest with the given strides. It is reduced element by element
// across rows, because a minimum along a row would be a chain that does not vectorise.
template <class T>
PlaneRange<T> rangeOf(const T* voxels, Vec3i size, int64_t row_stride, int64_t plane_stride) {
  const auto columns = static_cast<size_t>(size.x);
  std::vector<T> lo(columns, kNoVoxels<T>.lo), hi(columns, kNoVoxels<T>.hi);
  for (int64_t z = 0; z < size.z; ++z)
    for (int64_t y = 0; y < size.y; ++y) {
      const T* __restrict row = voxels + z * plane_stride + y * row_stride;
      for (size_t x = 0; x < columns; ++x) {
        lo[x] = row[x] < lo[x] ? row[x] : lo[x];
        hi[x] = row[x] > hi[x] ? row[x] : hi[x];
      }
    }
  PlaneRange<T> range = kNoVoxels<T>;
  for (size_t x = 0; x < columns; ++x) widen(range, {lo[x], hi[x]});
  return range;
}

// The columns of a block's voxels among those of a row of blocks.
struct BlockColumns {
  int64_t first = 0, count = 0;
};

// Work space for the ranges of rows of blocks of up to `side` planes. One thread.
//
// Voxels are taken row by row over all blocks side by side, since rows of one block are too short
// for the caches and leave vectors half full.
template <class T>
class RowRanges {
 public:
  explicit RowRanges(int64_t side) : side_(side) {}

  // `voxels`: x fastest with the given strides, `size` of them along each axis. Fills out[block]
  // [3][side] (planes that do not exist get kNoVoxels) and `totals`, the range of each block.
  void of(const T* voxels, Vec3i size, int64_t row_stride, int64_t plane_stride,
          std::span<const BlockColumns> blocks, PlaneRange<T>* out, PlaneRange<T>* totals) {
    const auto columns = static_cast<size_t>(size.x);
    std::fill(out, out + 3 * side_ * static_cast<int64_t>(blocks.size()), kNoVoxels<T>);
    x_.reset(columns);
    y_.reset(columns * static_cast<size_t>(size.y));
    for (int64_t z = 0; z < size.z; ++z) {
      z_.reset(columns);
      for (int64_t y = 0; y < size.y; ++y)
        widenRow(voxels + z * plane_stride + y * row_stride, size.x, z_.lo.data(), z_.hi.data(),
                 y_.lo.data() + y * size.x, y_.hi.data() + y * size.x);
      for (size_t x = 0; x < columns; ++x) widen(x_, x, {z_.lo[x], z_.hi[x]});
      for (size_t i = 0; i < blocks.size(); ++i)
        planes(out, i, 2)[z] = reduce(z_, blocks[i].first, blocks[i].count);
    }
    for (size_t i = 0; i < blocks.size(); ++i) {
      const BlockColumns& block = blocks[i];
      for (int64_t y = 0; y < size.y; ++y)
        planes(out, i, 1)[y] = reduce(y_, y * size.x + block.first, block.count);
      for (int64_t x = 0; x < block.count; ++x)
        planes(out, i, 0)[x] = reduce(x_, block.first + x, 1);
      totals[i] = reduce(x_, block.first, block.count);
    }
  }

 private:
  // Ends of ranges, apart from each other as vector units like it.
  struct Ends {
    std::vector<T> lo, hi;
    void reset(size_t count) {
      lo.assign(count, kNoVoxels<T>.lo);
      hi.assign(count, kNoVoxels<T>.hi);
    }
  };

  static void widen(Ends& ends, size_t at, PlaneRange<T> by) {
    ends.lo[at] = by.lo < ends.lo[at] ? by.lo : ends.lo[at];
    ends.hi[at] = by.hi > ends.hi[at] ? by.hi : ends.hi[at];
  }
  // Element by element; a min over a row would be a chain that no vector unit likes.
  static void widenRow(const T* __restrict row, int64_t count, T* __restrict z_lo,
                       T* __restrict z_hi, T* __restrict y_lo, T* __restrict y_hi) {
    for (int64_t i = 0; i < count; ++i) {
      const T value = row[i];
      z_lo[i] = value < z_lo[i] ? value : z_lo[i];
      z_hi[i] = value > z_hi[i] ? value : z_hi[i];
      y_lo[i] = value < y_lo[i] ? value : y_lo[i];
      y_hi[i] = value > y_hi[i] ? value : y_hi[i];
    }
  }
  static PlaneRange<T> reduce(const Ends& ends, int64_t first, int64_t count) {
    T lo = kNoVoxels<T>.lo, hi = kNoVoxels<T>.hi;
    const T* const low = ends.lo.data() + first;
    const T* const high = ends.hi.data() + first;
    for (int64_t i = 0; i < count; ++i) lo = low[i] < lo ? low[i] : lo;
    for (int64_t i = 0; i < count; ++i) hi = high[i] > hi ? high[i] : hi;
    return {lo, hi};
  }
  PlaneRange<T>* planes(PlaneRange<T>* out, size_t block, int64_t axis) const {
    return out + (static_cast<int64_t>(block) * 3 + axis) * side_;
  }

  const int64_t side_;
  Ends x_, z_;  // of the columns of all voxels, and of a plane
  Ends y_;      // [y][x]
};

}  // namespace sluice
