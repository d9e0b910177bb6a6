// Blocks of 2 x 2 x 2 voxels of 16 bits: their sums, squares, means and spreads, with vector
// instructions. As byte_blocks.h, for the scans of more than 8 bits.
#pragma once

#include <array>
#include <cstdint>

namespace sluice {

// The places for the numbers of a row of blocks, one of each kind a block. T: uint16_t or int16_t.
template <class T>
struct ShortBlocks {
  int32_t* sums = nullptr;      // of the eight voxels
  uint64_t* squares = nullptr;  // the sum of their squares
  T* means = nullptr;           // sums / 8, ties to the even number
  uint16_t* spreads = nullptr;  // twice the standard deviation, ties to the even number
};

// Makes the first blocks of a row from its four rows of voxels, and returns how many: `blocks`
// rounded down to whole vectors; 0 on processors without AVX2.
template <class T>
int64_t makeShortBlocks(const std::array<const T*, 4>& rows, int64_t blocks,
                        const ShortBlocks<T>& to);

}  // namespace sluice
