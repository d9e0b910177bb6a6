#include "src/surface/corner_bits.h"

#include <algorithm>
#include <cstring>

namespace sluice {
namespace {

// The bits of 64 bytes that are 0 or 1.
uint64_t packed(const uint8_t* flags) {
  uint64_t word = 0;
  for (int i = 0; i < 8; ++i) {
    uint64_t eight = 0;
    if constexpr (std::endian::native == std::endian::little) {
      std::memcpy(&eight, flags + 8 * i, sizeof eight);
    } else {
      for (int j = 0; j < 8; ++j) eight |= uint64_t{flags[8 * i + j]} << (8 * j);
    }
    // Moves byte j's bit to bit 56 + j; no two meet on the way.
    constexpr uint64_t kGather = 0x0102040810204080U;
    word |= (eight * kGather >> 56) << (8 * i);
  }
  return word;
}

}  // namespace

void CornerBits::reset(Vec3i size) {
  size_ = size;
  words_ = ceilDiv(size.x, 64);
  // The word of zeros at the end of each row lets a cell take its pair of bits from two words
  // without a test for the last one.
  bits_.assign(static_cast<size_t>((words_ + 1) * size.y * size.z), 0);
  flags_.resize(static_cast<size_t>(64 * words_));
}

void CornerBits::setInside(int64_t y, int64_t z, int64_t first, int64_t last) {
  uint64_t* const row = rowToSet(y, z);
  for (int64_t word = first / 64; word <= last / 64; ++word)
    row[word] |= below(last + 1 - 64 * word) & ~below(first - 64 * word);
}

template <class T>
void CornerBits::setInside(int64_t y, int64_t z, int64_t first, const T* values, int64_t count,
                           T lo, T hi) {
  const int64_t begin = first / 64 * 64, end = std::min(ceilDiv(first + count, 64), words_) * 64;
  uint8_t* const flags = flags_.data();
  // The flags still hold the row before. Those of the first and the last word are packed with this
  // one's, and must be 0.
  std::memset(flags + begin, 0, static_cast<size_t>(first - begin));
  std::memset(flags + first + count, 0, static_cast<size_t>(end - first - count));
  // The loop has no branch and writes no memory that it reads, so that the compiler compares many
  // voxels at once.
  uint8_t* __restrict const to = flags + first;
  for (int64_t i = 0; i < count; ++i)
    to[i] =
        static_cast<uint8_t>(static_cast<int>(values[i] >= lo) & static_cast<int>(values[i] <= hi));
  uint64_t* const row = rowToSet(y, z);
  // Runs of the same row, or a block that is known to be inside, may share a word.
  for (int64_t at = begin; at < end; at += 64) row[at / 64] |= packed(flags + at);
}
template void CornerBits::setInside(int64_t, int64_t, int64_t, const uint8_t*, int64_t, uint8_t,
                                    uint8_t);
template void CornerBits::setInside(int64_t, int64_t, int64_t, const uint16_t*, int64_t, uint16_t,
                                    uint16_t);
template void CornerBits::setInside(int64_t, int64_t, int64_t, const float*, int64_t, float, float);

int64_t CornerBits::countCrossed(int axis, int64_t y, int64_t z, int64_t from) const {
  int64_t count = 0;
  for (int64_t word = 0; word < words_; ++word) {
    uint64_t bits = crossed(axis, y, z, word);
    // The edges at x = 0 belong to the piece before.
    if (word == 0 && from == 1) bits &= ~uint64_t{1};
    count += countBits(bits);
  }
  return count;
}

}  // namespace sluice
