// transposedCopy: a plane of numbers whose rows become columns, as the voxels of a block do if its
// trimming axis is not z.
//
// Squares of numbers are transposed in registers: read one by one, each number of a row lies in a
// cache line of its own. Pure functions.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <utility>

#include "src/base/vector_of.h"

namespace sluice {

// Numbers of a plane in memory, rows `stride` numbers apart.
template <class T>
struct TransposedPlane {
  const T* in;  // the first number to copy
  int64_t stride;
  // Numbers that may be read of each row: those before `in`, and those from it on.
  int64_t before, after;
};

namespace internal {

inline constexpr size_t kRowBytes = 16;
template <class T>
inline constexpr size_t kLanes = kRowBytes / sizeof(T);

template <class T>
struct Square {
  std::array<typename VectorOf<T, kRowBytes>::Type, kLanes<T>> rows;
};

// The lanes of the lower or the upper halves of two rows by turns.
template <size_t kFrom, class Row, size_t... kLane>
Row interleaved(Row a, Row b, std::index_sequence<kLane...>) {
  return __builtin_shufflevector(
      a, b, static_cast<int>(kFrom + kLane / 2 + kLane % 2 * sizeof...(kLane))...);
}

template <class T>
void transpose(Square<T>& square) {
  constexpr size_t kHalf = kLanes<T> / 2;
  constexpr auto kAll = std::make_index_sequence<kLanes<T>>();
  // Each round turns the place of a number, the bits of its row and its lane, by one bit.
  for (size_t round = 1; round < kLanes<T>; round *= 2) {
    Square<T> next;
    for (size_t i = 0; i < kHalf; ++i) {
      const auto a = square.rows[i], b = square.rows[i + kHalf];
      next.rows[2 * i] = interleaved<0>(a, b, kAll);
      next.rows[2 * i + 1] = interleaved<kHalf>(a, b, kAll);
    }
    square = next;
  }
}

}  // namespace internal

// Number y of row x becomes number x of row y: out[y * out_stride + x * kNumbers], for x < width
// and y < height. Requires: height <= plane.after.
template <int kNumbers, class T>
void transposedCopy(const TransposedPlane<T>& plane, int64_t width, int64_t height,
                    int64_t out_stride, T* out) {
  constexpr auto kSide = static_cast<int64_t>(internal::kLanes<T>);
  if (width < kSide || plane.before + plane.after < kSide) {
    for (int64_t y = 0; y < height; ++y)
      for (int64_t x = 0; x < width; ++x)
        out[y * out_stride + x * kNumbers] = plane.in[x * plane.stride + y];
    return;
  }
  for (int64_t y = 0; y < height; y += kSide) {
    // Squares that would reach beyond the rows begin before, and not all of them is copied.
    const int64_t skipped = std::max<int64_t>(0, y + kSide - plane.after);
    const int64_t rows = std::min(kSide, height - y);
    for (int64_t x = 0; x < width; x += kSide) {
      const int64_t left = std::min(x, width - kSide);
      internal::Square<T> square;
      const T* from = plane.in + left * plane.stride + y - skipped;
      for (auto& row : square.rows) {
        std::memcpy(&row, from, sizeof row);
        from += plane.stride;
      }
      internal::transpose(square);
      T* to = out + y * out_stride + left * kNumbers;
      for (int64_t i = skipped; i < skipped + rows; ++i, to += out_stride) {
        const auto& row = square.rows[static_cast<size_t>(i)];
        if constexpr (kNumbers == 1)
          std::memcpy(to, &row, sizeof row);
        else
          for (int64_t lane = 0; lane < kSide; ++lane) to[lane * kNumbers] = row[lane];
      }
    }
  }
}

}  // namespace sluice
