#include "io/zarr/levels/short_blocks.h"

#include <type_traits>

#include "src/base/wide_vectors.h"

#if defined(__x86_64__)
#include <immintrin.h>
#endif

namespace sluice {

#if defined(__x86_64__)
namespace {

// Numbers of 64 bits of eight blocks: those of blocks 0, 2, 4 and 6, and those between them.
struct Wide {
  __m256i even, odd;
};

// Stores them in the order of the blocks.
[[gnu::target("avx2")]] inline void store(const Wide& numbers, uint64_t* to) {
  const __m256i low = _mm256_unpacklo_epi64(numbers.even, numbers.odd);
  const __m256i high = _mm256_unpackhi_epi64(numbers.even, numbers.odd);
  auto* const first = reinterpret_cast<__m256i*>(to);
  _mm256_storeu_si256(first, _mm256_permute2x128_si256(low, high, 0x20));
  _mm256_storeu_si256(first + 1, _mm256_permute2x128_si256(low, high, 0x31));
}

// The products of eight numbers with signs with a number each.
[[gnu::target("avx2")]] inline Wide productsOf(__m256i numbers, __m256i with) {
  return {_mm256_mul_epi32(numbers, with),
          _mm256_mul_epi32(_mm256_srli_epi64(numbers, 32), _mm256_srli_epi64(with, 32))};
}

// Twice the standard deviations of four blocks from variances that are 64 times as large, whole
// numbers below 2^52.
[[gnu::target("avx2")]] inline __m128i wideSpreadsOf(__m256i variances) {
  // The bits of 2^52 and a whole number below it are those of their sum.
  const __m256d unit = _mm256_set1_pd(0x1p52);
  const __m256d numbers = _mm256_sub_pd(
      _mm256_castsi256_pd(_mm256_or_si256(variances, _mm256_castpd_si256(unit))), unit);
  return _mm256_cvtpd_epi32(_mm256_mul_pd(_mm256_sqrt_pd(numbers), _mm256_set1_pd(0.25)));
}

// Numbers without a sign are taken less 2^15, so that products of numbers with signs serve both
// types: neither variances nor the rounding of means change.
template <class T>
[[gnu::target("avx2")]] int64_t makeWide(const std::array<const T*, 4>& rows, int64_t blocks,
                                         const ShortBlocks<T>& to) {
  constexpr int64_t kBlocks = 8;
  constexpr bool kIsShifted = std::is_unsigned_v<T>;
  constexpr int kShift = kIsShifted ? 1 << 15 : 0;
  const __m256i shift = _mm256_set1_epi16(static_cast<int16_t>(kIsShifted ? 0x8000 : 0));
  const __m256i zero = _mm256_setzero_si256(), ones = _mm256_set1_epi16(1);
  const __m256i lower_half = _mm256_set1_epi64x(0xffffffff);
  int64_t x = 0;
  for (; x + kBlocks <= blocks; x += kBlocks) {
    __m256i sums = zero;
    Wide squares{zero, zero};
    for (const T* const row : rows) {
      const __m256i numbers = _mm256_xor_si256(
          _mm256_loadu_si256(reinterpret_cast<const __m256i*>(row + 2 * x)), shift);
      sums = _mm256_add_epi32(sums, _mm256_madd_epi16(numbers, ones));
      // At most 2^31, which 32 bits hold without a sign.
      const __m256i pairs = _mm256_madd_epi16(numbers, numbers);
      squares.even = _mm256_add_epi64(squares.even, _mm256_and_si256(pairs, lower_half));
      squares.odd = _mm256_add_epi64(squares.odd, _mm256_srli_epi64(pairs, 32));
    }
    const Wide squared = productsOf(sums, sums);
    const __m128i even =
        wideSpreadsOf(_mm256_sub_epi64(_mm256_slli_epi64(squares.even, 3), squared.even));
    const __m128i odd =
        wideSpreadsOf(_mm256_sub_epi64(_mm256_slli_epi64(squares.odd, 3), squared.odd));
    _mm_storeu_si128(
        reinterpret_cast<__m128i*>(to.spreads + x),
        _mm_packus_epi32(_mm_unpacklo_epi32(even, odd), _mm_unpackhi_epi32(even, odd)));
    // Half of the divisor less one, and one more if the mean is odd: ties go to the even mean.
    const __m256i is_odd = _mm256_and_si256(_mm256_srli_epi32(sums, 3), _mm256_set1_epi32(1));
    const __m256i means = _mm256_srai_epi32(
        _mm256_add_epi32(_mm256_add_epi32(sums, _mm256_set1_epi32(3)), is_odd), 3);
    _mm_storeu_si128(reinterpret_cast<__m128i*>(to.means + x),
                     _mm_xor_si128(_mm_packs_epi32(_mm256_castsi256_si128(means),
                                                   _mm256_extracti128_si256(means, 1)),
                                   _mm256_castsi256_si128(shift)));
    _mm256_storeu_si256(reinterpret_cast<__m256i*>(to.sums + x),
                        _mm256_add_epi32(sums, _mm256_set1_epi32(8 * kShift)));
    if constexpr (kIsShifted) {
      // (v + s)^2 = v^2 + 2 s v + s^2
      const Wide mixed = productsOf(sums, _mm256_set1_epi32(2 * kShift));
      const __m256i last = _mm256_set1_epi64x(int64_t{8} * kShift * kShift);
      squares.even = _mm256_add_epi64(_mm256_add_epi64(squares.even, mixed.even), last);
      squares.odd = _mm256_add_epi64(_mm256_add_epi64(squares.odd, mixed.odd), last);
    }
    store(squares, to.squares + x);
  }
  return x;
}

}  // namespace

template <class T>
int64_t makeShortBlocks(const std::array<const T*, 4>& rows, int64_t blocks,
                        const ShortBlocks<T>& to) {
  return hasWideVectors() ? makeWide(rows, blocks, to) : 0;
}
#else
template <class T>
int64_t makeShortBlocks(const std::array<const T*, 4>& /*rows*/, int64_t /*blocks*/,
                        const ShortBlocks<T>& /*to*/) {
  return 0;
}
#endif

template int64_t makeShortBlocks(const std::array<const uint16_t*, 4>&, int64_t,
                                 const ShortBlocks<uint16_t>&);
template int64_t makeShortBlocks(const std::array<const int16_t*, 4>&, int64_t,
                                 const ShortBlocks<int16_t>&);

}  // namespace sluice
