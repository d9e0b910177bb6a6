#include "io/zarr/levels/byte_blocks.h"

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

[[gnu::target("avx2")]] inline bool areOneValue(const Bytes& rows) {
  const __m256i value = _mm256_broadcastb_epi8(_mm256_castsi256_si128(rows.a));
  const __m256i others = _mm256_or_si256(
      _mm256_or_si256(_mm256_xor_si256(rows.a, value), _mm256_xor_si256(rows.b, value)),
      _mm256_or_si256(_mm256_xor_si256(rows.c, value), _mm256_xor_si256(rows.d, value)));
  return _mm256_testz_si256(others, others) != 0;
}

// The 16 blocks from `at` on, all of one value.
[[gnu::target("avx2")]] inline void fill(uint8_t value, int64_t at, const ByteBlocks& to) {
  const __m256i sum = _mm256_set1_epi32(8 * value), square = _mm256_set1_epi32(8 * value * value);
  store({sum, sum}, to.sums + at);
  store({square, square}, to.squares + at);
  _mm_storeu_si128(reinterpret_cast<__m128i*>(to.means + at),
                   _mm_set1_epi8(static_cast<char>(value)));
  _mm_storeu_si128(reinterpret_cast<__m128i*>(to.spreads + at), _mm_setzero_si128());
}

[[gnu::target("avx2")]] int64_t makeWide(const std::array<const uint8_t*, 4>& rows, int64_t blocks,
                                         const ByteBlocks& to) {
  constexpr int64_t kBlocks = 16;
  const __m256i zero = _mm256_setzero_si256(), ones = _mm256_set1_epi8(1);
  int64_t x = 0;
  for (; x + kBlocks <= blocks; x += kBlocks) {
    const Bytes numbers{loaded(rows[0] + 2 * x), loaded(rows[1] + 2 * x), loaded(rows[2] + 2 * x),
                        loaded(rows[3] + 2 * x)};
    // Air is often one value throughout.
    if (areOneValue(numbers)) {
      fill(rows[0][2 * x], x, to);
      continue;
    }
    __m256i sums = zero;
    Halves squares{zero, zero};
    for (const __m256i bytes : {numbers.a, numbers.b, numbers.c, numbers.d}) {
      const Halves wide{_mm256_unpacklo_epi8(bytes, zero), _mm256_unpackhi_epi8(bytes, zero)};
      sums = _mm256_add_epi16(sums, _mm256_maddubs_epi16(bytes, ones));
      squares.low = _mm256_add_epi32(squares.low, _mm256_madd_epi16(wide.low, wide.low));
      squares.high = _mm256_add_epi32(squares.high, _mm256_madd_epi16(wide.high, wide.high));
    }
    const Halves wide_sums{_mm256_unpacklo_epi16(sums, zero), _mm256_unpackhi_epi16(sums, zero)};
    store(wide_sums, to.sums + x);
    store(squares, to.squares + x);
    // Half of the divisor less one, and one more if the mean is odd: ties go to the even mean.
    const __m256i is_odd = _mm256_and_si256(_mm256_srli_epi16(sums, 3), _mm256_set1_epi16(1));
    const __m256i means = _mm256_srli_epi16(
        _mm256_add_epi16(_mm256_add_epi16(sums, _mm256_set1_epi16(3)), is_odd), 3);
    store(means, to.means + x);
    const Halves variances{variancesOf(wide_sums.low, squares.low),
                           variancesOf(wide_sums.high, squares.high)};
    store(_mm256_packs_epi32(spreadsOf(variances.low), spreadsOf(variances.high)), to.spreads + x);
  }
  return x;
}

// The sums of pairs of neighbours in 16 numbers of each of four rows.
[[gnu::target("avx2")]] inline __m256i sumsOfPairs(const std::array<const int32_t*, 4>& rows,
                                                   int64_t at) {
  __m256i sums = _mm256_setzero_si256();
  for (const int32_t* const row : rows) {
    const auto* const from = reinterpret_cast<const __m256i*>(row + at);
    sums = _mm256_add_epi32(
        sums, _mm256_hadd_epi32(_mm256_loadu_si256(from), _mm256_loadu_si256(from + 1)));
  }
  return _mm256_permute4x64_epi64(sums, 0xd8);  // in the order of the blocks
}

[[gnu::target("avx2")]] inline void store(__m256i numbers, double* to) {
  _mm256_storeu_pd(to, _mm256_cvtepi32_pd(_mm256_castsi256_si128(numbers)));
  _mm256_storeu_pd(to + 4, _mm256_cvtepi32_pd(_mm256_extracti128_si256(numbers, 1)));
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

[[gnu::target("avx2")]] int64_t makeCoarserWide(const FinerByteBlocks& rows, int64_t blocks,
                                                const CoarserByteBlocks& to) {
  constexpr int64_t kBlocks = 8;
  int64_t x = 0;
  for (; x + kBlocks <= blocks; x += kBlocks) {
    const __m256i sums = sumsOfPairs(rows.sums, 2 * x);
    const __m256i squares = sumsOfPairs(rows.squares, 2 * x);
    store(sums, to.sums + x);
    store(squares, to.squares + x);
    const __m256i is_odd = _mm256_and_si256(_mm256_srli_epi32(sums, 6), _mm256_set1_epi32(1));
    const __m256i means = _mm256_srli_epi32(
        _mm256_add_epi32(_mm256_add_epi32(sums, _mm256_set1_epi32(31)), is_odd), 6);
    storeBytes(_mm256_castsi256_si128(means), _mm256_extracti128_si256(means, 1), to.means + x);
    // Both are at most (64 * 255)^2, below 2^28.
    const __m256i variances =
        _mm256_sub_epi32(_mm256_slli_epi32(squares, 6), _mm256_mullo_epi32(sums, sums));
    storeBytes(coarserSpreadsOf(_mm256_castsi256_si128(variances)),
               coarserSpreadsOf(_mm256_extracti128_si256(variances, 1)), to.spreads + x);
  }
  return x;
}

bool hasAvx2() {
  static const bool has = __builtin_cpu_supports("avx2") != 0;
  return has;
}

}  // namespace

int64_t makeByteBlocks(const std::array<const uint8_t*, 4>& rows, int64_t blocks,
                       const ByteBlocks& to) {
  return hasAvx2() ? makeWide(rows, blocks, to) : 0;
}
int64_t makeCoarserByteBlocks(const FinerByteBlocks& rows, int64_t blocks,
                              const CoarserByteBlocks& to) {
  return hasAvx2() ? makeCoarserWide(rows, blocks, to) : 0;
}
#else
int64_t makeByteBlocks(const std::array<const uint8_t*, 4>& /*rows*/, int64_t /*blocks*/,
                       const ByteBlocks& /*to*/) {
  return 0;
}
int64_t makeCoarserByteBlocks(const FinerByteBlocks& /*rows*/, int64_t /*blocks*/,
                              const CoarserByteBlocks& /*to*/) {
  return 0;
}
#endif

}  // namespace sluice
