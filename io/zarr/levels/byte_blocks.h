// Blocks of 2 x 2 x 2 unsigned bytes: their sums, squares, means and spreads, with vector
// instructions. Seven of eight voxels that level_maker.h makes of a CT scan are such blocks, and
// seven of eight others are blocks of eight of them.
#pragma once

#include <array>
#include <cstdint>

namespace sluice {

// The places for the numbers of a row of blocks, one of each kind a block.
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

// Two levels at once: blocks of 4 x 4 x 4 bytes, each of which is 2 x 2 x 2 of the blocks above.
// The sums of the finer level stay in registers.
struct TwoLevelsOfBytes {
  std::array<uint8_t*, 4> means, spreads;  // the finer level's rows, in the order of `rows`
  // The coarser level's row.
  int32_t* coarser_sums = nullptr;
  int32_t* coarser_squares = nullptr;
  uint8_t* coarser_means = nullptr;
  uint8_t* coarser_spreads = nullptr;
};
// `rows`: four for each row of finer blocks. Returns how many blocks of the coarser level it has
// made: `blocks` rounded down to whole vectors; 0 on processors without AVX2.
int64_t makeTwoLevelsOfBytes(const std::array<const uint8_t*, 16>& rows, int64_t blocks,
                             const TwoLevelsOfBytes& to);

}  // namespace sluice
