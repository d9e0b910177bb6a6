// blockRanges: the three min-max arrays of one block from its voxels; the inner loop of
// slice_ranges.cpp, in a form that compilers turn into vector code for every voxel type.
#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>
#include <vector>

#include "src/base/values/vec.h"
#include "src/volume/slice_ranges.h"

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

// Work space for the ranges of blocks of up to `side` planes. One thread.
template <class T>
class BlockRanges {
 public:
  explicit BlockRanges(int64_t side)
      : side_(side),
        z_lo_(static_cast<size_t>(side)),
        z_hi_(z_lo_.size()),
        x_lo_(z_lo_.size()),
        x_hi_(z_lo_.size()),
        y_lo_(z_lo_.size() * z_lo_.size()),
        y_hi_(y_lo_.size()) {}

  // `voxels`: x fastest with the given strides, `size` of them along each axis. Fills out[3][side]
  // (planes that do not exist get kNoVoxels) and returns the range of all.
  PlaneRange<T> of(const T* voxels, Vec3i size, int64_t row_stride, int64_t plane_stride,
                   PlaneRange<T>* out) {
    std::fill(out, out + 3 * side_, kNoVoxels<T>);
    reset(x_lo_, x_hi_);
    reset(y_lo_, y_hi_);
    for (int64_t z = 0; z < size.z; ++z) {
      reset(z_lo_, z_hi_);
      for (int64_t y = 0; y < size.y; ++y) {
        const T* row = voxels + z * plane_stride + y * row_stride;
        widenRow(z_lo_.data(), z_hi_.data(), row, size.x);
        widenRow(y_lo_.data() + y * side_, y_hi_.data() + y * side_, row, size.x);
      }
      widenRow(x_lo_.data(), x_hi_.data(), z_lo_.data(), size.x);
      widenRow(x_lo_.data(), x_hi_.data(), z_hi_.data(), size.x);
      out[2 * side_ + z] = reduce(z_lo_.data(), z_hi_.data(), size.x);
    }
    for (int64_t y = 0; y < size.y; ++y)
      out[side_ + y] = reduce(y_lo_.data() + y * side_, y_hi_.data() + y * side_, size.x);
    PlaneRange<T> total = kNoVoxels<T>;
    for (int64_t x = 0; x < size.x; ++x) {
      out[x] = {x_lo_[static_cast<size_t>(x)], x_hi_[static_cast<size_t>(x)]};
      widen(total, out[x]);
    }
    return total;
  }

 private:
  static void reset(std::vector<T>& lo, std::vector<T>& hi) {
    std::fill(lo.begin(), lo.end(), kNoVoxels<T>.lo);
    std::fill(hi.begin(), hi.end(), kNoVoxels<T>.hi);
  }
  // Element by element; a min over a row would be a chain that no vector unit likes.
  static void widenRow(T* __restrict lo, T* __restrict hi, const T* __restrict row, int64_t count) {
    for (int64_t i = 0; i < count; ++i) {
      lo[i] = row[i] < lo[i] ? row[i] : lo[i];
      hi[i] = row[i] > hi[i] ? row[i] : hi[i];
    }
  }
  static PlaneRange<T> reduce(const T* lo, const T* hi, int64_t count) {
    PlaneRange<T> range = kNoVoxels<T>;
    for (int64_t i = 0; i < count; ++i) widen(range, {lo[i], hi[i]});
    return range;
  }

  const int64_t side_;
  std::vector<T> z_lo_, z_hi_, x_lo_, x_hi_;  // a plane's or the block's columns
  std::vector<T> y_lo_, y_hi_;                // [y][x]
};

}  // namespace sluice
