#include "io/zarr/levels/byte_blocks.h"

#include <cstring>

#include "src/base/wide_vectors.h"

#if defined(__x86_64__)
#include <immintrin.h>
#endif

namespace sluice {

#if defined(__x86_64__)
namespace {

// Unpacking works within the halves of a vector. Of 16 blocks, "low" numbers are those of blocks 0
// to 3 and 8 to 11, "high" ones the others; packing puts them in order again.
struct Halves {
  __m256i low, high;
};

[[gnu::target("avx2")]] inline __m256i loaded(const uint8_t* from) {
  return _mm256_loadu_si256(reinterpret_cast<const __m256i*>(from));
}

// Stores 16 numbers in the order of their blocks.
[[gnu::target("avx2")]] inline void store(const Halves& numbers, int32_t* to) {
  auto* const first = reinterpret_cast<__m256i*>(to);
  _mm256_storeu_si256(first, _mm256_permute2x128_si256(numbers.low, numbers.high, 0x20));
  _mm256_storeu_si256(first + 1, _mm256_permute2x128_si256(numbers.low, numbers.high, 0x31));
}

// The same of 16-bit numbers below 256 in order, as bytes.
[[gnu::target("avx2")]] inline void store(__m256i numbers, uint8_t* to) {
  const __m256i bytes = _mm256_permute4x64_epi64(_mm256_packus_epi16(numbers, numbers), 0x08);
  _mm_storeu_si128(reinterpret_cast<__m128i*>(to), _mm256_castsi256_si128(bytes));
}

// The variances of blocks of eight bytes, 64 times as large: 8 squares - sum^2. Both products are
// below 2^24, so that floats hold them.
[[gnu::target("avx2")]] inline __m256i variancesOf(__m256i sums, __m256i squares) {
  return _mm256_sub_epi32(_mm256_slli_epi32(squares, 3), _mm256_madd_epi16(sums, sums));
}

// Twice the standard deviations.
[[gnu::target("avx2")]] inline __m256i spreadsOf(__m256i variances) {
  const __m256 root = _mm256_sqrt_ps(_mm256_cvtepi32_ps(variances));
  return _mm256_cvtps_epi32(_mm256_mul_ps(root, _mm256_set1_ps(0.25F)));
}

// A vector of bytes from each of four rows.
struct Bytes {
  __m256i a, b, c, d;
};

[[gnu::target("avx2")]] inline bool areAll(uint8_t byte, const Bytes& rows) {
  const __m256i value = _mm256_set1_epi8(static_cast<char>(byte));
  const __m256i others = _mm256_or_si256(
      _mm256_or_si256(_mm256_xor_si256(rows.a, value), _mm256_xor_si256(rows.b, value)),
      _mm256_or_si256(_mm256_xor_si256(rows.c, value), _mm256_xor_si256(rows.d, value)));
  return _mm256_testz_si256(others, others) != 0;
}

// The sums of 16 blocks of eight bytes, and of their squares.
struct BlockNumbers {
  __m256i sums;  // 16 bits each, in the order of the blocks
  Halves squares;
};

[[gnu::target("avx2")]] inline BlockNumbers sumsOf(const Bytes& numbers) {
  const __m256i zero = _mm256_setzero_si256(), ones = _mm256_set1_epi8(1);
  BlockNumbers blocks{zero, {zero, zero}};
  for (const __m256i bytes : {numbers.a, numbers.b, numbers.c, numbers.d}) {
    const Halves wide{_mm256_unpacklo_epi8(bytes, zero), _mm256_unpackhi_epi8(bytes, zero)};
    blocks.sums = _mm256_add_epi16(blocks.sums, _mm256_maddubs_epi16(bytes, ones));
    blocks.squares.low =
        _mm256_add_epi32(blocks.squares.low, _mm256_madd_epi16(wide.low, wide.low));
    blocks.squares.high =
        _mm256_add_epi32(blocks.squares.high, _mm256_madd_epi16(wide.high, wide.high));
  }
  return blocks;
}

// The means and the spreads of 16 blocks.
[[gnu::target("avx2")]] inline void finish(const BlockNumbers& blocks, uint8_t* means,
                                           uint8_t* spreads) {
  const __m256i zero = _mm256_setzero_si256(), sums = blocks.sums;
  // Half of the divisor less one, and one more if the mean is odd: ties go to the even mean.
  const __m256i is_odd = _mm256_and_si256(_mm256_srli_epi16(sums, 3), _mm256_set1_epi16(1));
  store(
      _mm256_srli_epi16(_mm256_add_epi16(_mm256_add_epi16(sums, _mm256_set1_epi16(3)), is_odd), 3),
      means);
  const Halves wide{_mm256_unpacklo_epi16(sums, zero), _mm256_unpackhi_epi16(sums, zero)};
  const Halves variances{variancesOf(wide.low, blocks.squares.low),
                         variancesOf(wide.high, blocks.squares.high)};
  store(_mm256_packs_epi32(spreadsOf(variances.low), spreadsOf(variances.high)), spreads);
}

[[gnu::target("avx2")]] inline void finishOneValue(uint8_t value, uint8_t* means,
                                                   uint8_t* spreads) {
  _mm_storeu_si128(reinterpret_cast<__m128i*>(means), _mm_set1_epi8(static_cast<char>(value)));
  _mm_storeu_si128(reinterpret_cast<__m128i*>(spreads), _mm_setzero_si128());
}

[[gnu::target("avx2")]] int64_t makeWide(const std::array<const uint8_t*, 4>& rows, int64_t blocks,
                                         const ByteBlocks& to) {
  constexpr int64_t kBlocks = 16;
  const __m256i zero = _mm256_setzero_si256();
  int64_t x = 0;
  // The remainder is left to the caller's plain loop, whose numbers are the same to the bit.
  for (; x + kBlocks <= blocks; x += kBlocks) {
    const Bytes numbers{loaded(rows[0] + 2 * x), loaded(rows[1] + 2 * x), loaded(rows[2] + 2 * x),
                        loaded(rows[3] + 2 * x)};
    const BlockNumbers made = sumsOf(numbers);
    store({_mm256_unpacklo_epi16(made.sums, zero), _mm256_unpackhi_epi16(made.sums, zero)},
          to.sums + x);
    store(made.squares, to.squares + x);
    finish(made, to.means + x, to.spreads + x);
  }
  return x;
}

// Eight numbers.
[[gnu::target("avx2")]] inline void store(__m256i numbers, int32_t* to) {
  _mm256_storeu_si256(reinterpret_cast<__m256i*>(to), numbers);
}

// Eight numbers below 256 as bytes.
[[gnu::target("avx2")]] inline void storeBytes(__m128i low, __m128i high, uint8_t* to) {
  const __m128i words = _mm_packus_epi32(low, high);
  _mm_storel_epi64(reinterpret_cast<__m128i*>(to), _mm_packus_epi16(words, words));
}

// Twice the standard deviations, from variances 64^2 times as large.
[[gnu::target("avx2")]] inline __m128i coarserSpreadsOf(__m128i variances) {
  const __m256d root = _mm256_sqrt_pd(_mm256_cvtepi32_pd(variances));
  return _mm256_cvtpd_epi32(_mm256_mul_pd(root, _mm256_set1_pd(2.0 / 64)));
}

// Eight blocks of 64 bytes.
[[gnu::target("avx2")]] inline void finishCoarser(__m256i sums, __m256i squares, int64_t at,
                                                  const TwoLevelsOfBytes& to) {
  store(sums, to.coarser_sums + at);
  store(squares, to.coarser_squares + at);
  const __m256i is_odd = _mm256_and_si256(_mm256_srli_epi32(sums, 6), _mm256_set1_epi32(1));
  const __m256i means =
      _mm256_srli_epi32(_mm256_add_epi32(_mm256_add_epi32(sums, _mm256_set1_epi32(31)), is_odd), 6);
  storeBytes(_mm256_castsi256_si128(means), _mm256_extracti128_si256(means, 1),
             to.coarser_means + at);
  // Both are at most (64 * 255)^2, below 2^28.
  const __m256i variances =
      _mm256_sub_epi32(_mm256_slli_epi32(squares, 6), _mm256_mullo_epi32(sums, sums));
  storeBytes(coarserSpreadsOf(_mm256_castsi256_si128(variances)),
             coarserSpreadsOf(_mm256_extracti128_si256(variances, 1)), to.coarser_spreads + at);
}

// Eight blocks of 64 bytes that are all one value.
[[gnu::target("avx2")]] inline void finishCoarserOneValue(uint8_t value, int64_t at,
                                                          const TwoLevelsOfBytes& to) {
  store(_mm256_set1_epi32(64 * value), to.coarser_sums + at);
  store(_mm256_set1_epi32(64 * value * value), to.coarser_squares + at);
  std::memset(to.coarser_means + at, value, 8);
  std::memset(to.coarser_spreads + at, 0, 8);
}

[[gnu::target("avx2")]] int64_t makeTwoWide(const std::array<const uint8_t*, 16>& rows,
                                            int64_t blocks, const TwoLevelsOfBytes& to) {
  constexpr int64_t kBlocks = 8;
  constexpr size_t kFinerRows = 4;
  constexpr int64_t kAhead = 256;  // bytes
  const __m256i zero = _mm256_setzero_si256(), ones = _mm256_set1_epi16(1);
  int64_t x = 0;
  for (; x + kBlocks <= blocks; x += kBlocks) {
    __m256i sums = zero;
    Halves squares{zero, zero};
    // Processors follow fewer rows than sixteen on their own; half of the time went into waiting.
    for (const uint8_t* const row : rows) __builtin_prefetch(row + 4 * x + kAhead);
    const uint8_t value = rows[0][4 * x];
    bool is_one_value = true;
    for (size_t row = 0; row < kFinerRows; ++row) {
      const uint8_t* const* const from = rows.data() + 4 * row;
      const Bytes numbers{loaded(from[0] + 4 * x), loaded(from[1] + 4 * x), loaded(from[2] + 4 * x),
                          loaded(from[3] + 4 * x)};
      uint8_t* const means = to.means[row] + 2 * x;
      uint8_t* const spreads = to.spreads[row] + 2 * x;
      // Air is often one value throughout.
      if (areAll(value, numbers)) {
        finishOneValue(value, means, spreads);
        sums = _mm256_add_epi16(sums, _mm256_set1_epi16(static_cast<int16_t>(8 * value)));
        const __m256i square = _mm256_set1_epi32(8 * value * value);
        squares.low = _mm256_add_epi32(squares.low, square);
        squares.high = _mm256_add_epi32(squares.high, square);
        continue;
      }
      is_one_value = false;
      const BlockNumbers made = sumsOf(numbers);
      finish(made, means, spreads);
      sums = _mm256_add_epi16(sums, made.sums);
      squares.low = _mm256_add_epi32(squares.low, made.squares.low);
      squares.high = _mm256_add_epi32(squares.high, made.squares.high);
    }
    if (is_one_value)
      finishCoarserOneValue(value, x, to);
    else
      // Neighbouring pairs; both sums are in the order of the blocks.
      finishCoarser(_mm256_madd_epi16(sums, ones), _mm256_hadd_epi32(squares.low, squares.high), x,
                    to);
  }
  return x;
}

}  // namespace

int64_t makeByteBlocks(const std::array<const uint8_t*, 4>& rows, int64_t blocks,
                       const ByteBlocks& to) {
  return hasWideVectors() ? makeWide(rows, blocks, to) : 0;
}
int64_t makeTwoLevelsOfBytes(const std::array<const uint8_t*, 16>& rows, int64_t blocks,
                             const TwoLevelsOfBytes& to) {
  return hasWideVectors() ? makeTwoWide(rows, blocks, to) : 0;
}
#else
int64_t makeByteBlocks(const std::array<const uint8_t*, 4>& /*rows*/, int64_t /*blocks*/,
                       const ByteBlocks& /*to*/) {
  return 0;
}
int64_t makeTwoLevelsOfBytes(const std::array<const uint8_t*, 16>& /*rows*/, int64_t /*blocks*/,
                             const TwoLevelsOfBytes& /*to*/) {
  return 0;
}
#endif

}  // namespace sluice
