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

[[gnu::target("avx2")]] int64_t makeWide(const std::array<const uint8_t*, 4>& rows, int64_t blocks,
                                         const ByteBlocks& to) {
  constexpr int64_t kBlocks = 16;
  const __m256i zero = _mm256_setzero_si256(), ones = _mm256_set1_epi8(1);
  int64_t x = 0;
  for (; x + kBlocks <= blocks; x += kBlocks) {
    __m256i sums = zero;
    Halves squares{zero, zero};
    for (const uint8_t* const row : rows) {
      const __m256i bytes = loaded(row + 2 * x);
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
    const __m256i any = _mm256_or_si256(variances.low, variances.high);
    // Air is often one value throughout, and roots take as long as all the rest.
    const bool is_constant = _mm256_testz_si256(any, any) != 0;
    store(is_constant ? zero
                      : _mm256_packs_epi32(spreadsOf(variances.low), spreadsOf(variances.high)),
          to.spreads + x);
  }
  return x;
}

}  // namespace

int64_t makeByteBlocks(const std::array<const uint8_t*, 4>& rows, int64_t blocks,
                       const ByteBlocks& to) {
  static const bool has_avx2 = __builtin_cpu_supports("avx2") != 0;
  return has_avx2 ? makeWide(rows, blocks, to) : 0;
}
#else
int64_t makeByteBlocks(const std::array<const uint8_t*, 4>& /*rows*/, int64_t /*blocks*/,
                       const ByteBlocks& /*to*/) {
  return 0;
}
#endif

}  // namespace sluice
