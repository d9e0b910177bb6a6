// Blocks of 2 x 2 x 2 unsigned bytes: their sums, squares, means and spreads, with vector
// instructions. Seven of eight voxels that level_maker.h makes of a CT scan are such blocks, and
// seven of eight others are blocks of eight of them.
#pragma once

#include <array>
#include <cstdint>

namespace sluice {

// Where the numbers of a row of blocks go, one of each kind a block.
struct ByteBlocks {
  int32_t* sums = nullptr;     // of the eight bytes
  int32_t* squares = nullptr;  // the sum of their squares
  uint8_t* means = nullptr;    // sums / 8, ties to the even number
  uint8_t* spreads = nullptr;  // twice the standard deviation, ties to the even number
};

// Makes the first blocks of a row from its four rows of bytes, and returns how many: `blocks`
// rounded down to whole vectors; 0 on processors without AVX2.
int64_t makeByteBlocks(const std::array<const uint8_t*, 4>& rows, int64_t blocks,
                       const ByteBlocks& to);

// The same of the next coarser level, whose blocks are of 2 x 2 x 2 such blocks: 64 bytes.
struct FinerByteBlocks {
  std::array<const int32_t*, 4> sums, squares;  // four rows each
};
struct CoarserByteBlocks {
  double* sums = nullptr;
  double* squares = nullptr;
  uint8_t* means = nullptr;
  uint8_t* spreads = nullptr;
};
int64_t makeCoarserByteBlocks(const FinerByteBlocks& rows, int64_t blocks,
                              const CoarserByteBlocks& to);

}  // namespace sluice
