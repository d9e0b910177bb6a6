// Reading for each lane from an address of its own. Included once a target.
//
// A gather is one instruction and many micro-operations: loads of single lanes and inserts take 0.6
// to 0.8 of its time on processors whose gathers are slow, and four rows share their offsets.

// 64 bits for each lane: the lower and the upper half.
struct Wide {
  VI first, second;
};
// Four floats for each lane: the first of each, the second, and so on.
struct Quad {
  V of[4];
};

#if HWY_TARGET == HWY_AVX3 || HWY_TARGET == HWY_AVX2
struct LaneOffsets {
  alignas(64) int32_t of[kLanes];
};
HWY_INLINE LaneOffsets laneOffsets(VI offset) {
  LaneOffsets offsets;
  hn::Store(offset, I(), offsets.of);
  return offsets;
}
HWY_INLINE int fourBytesAt(const std::byte* at) {
  int bytes;
  __builtin_memcpy(&bytes, at, sizeof bytes);
  return bytes;
}
HWY_INLINE __m128i fourLanes(const std::byte* base, const int32_t* offset) {
  __m128i lanes = _mm_cvtsi32_si128(fourBytesAt(base + offset[0]));
  lanes = _mm_insert_epi32(lanes, fourBytesAt(base + offset[1]), 1);
  lanes = _mm_insert_epi32(lanes, fourBytesAt(base + offset[2]), 2);
  return _mm_insert_epi32(lanes, fourBytesAt(base + offset[3]), 3);
}
HWY_INLINE __m128i twoLanes(const std::byte* base, const int32_t* offset) {
  const __m128i lower = _mm_loadl_epi64(reinterpret_cast<const __m128i*>(base + offset[0]));
  return _mm_castps_si128(_mm_loadh_pi(_mm_castsi128_ps(lower),
                                       reinterpret_cast<const __m64*>(base + offset[1])));
}
HWY_INLINE __m256i joined(__m128i lower, __m128i upper) {
  return _mm256_inserti128_si256(_mm256_castsi128_si256(lower), upper, 1);
}
#if HWY_TARGET == HWY_AVX3
HWY_INLINE VI joinedLanes(const __m128i* parts) {
  return VI{_mm512_inserti64x4(_mm512_castsi256_si512(joined(parts[0], parts[1])),
                               joined(parts[2], parts[3]), 1)};
}
#else
HWY_INLINE VI joinedLanes(const __m128i* parts) { return VI{joined(parts[0], parts[1])}; }
#endif
constexpr int kParts = kLanes / 4;  // parts of 128 bits

// Four bytes from each offset on, of four bases.
HWY_INLINE void fourAtOnce(const std::byte* const (&base)[4], VI offset, VI (&bytes)[4]) {
  const LaneOffsets offsets = laneOffsets(offset);
  __m128i parts[4][kParts];
  for (int part = 0; part < kParts; ++part)
    for (int row = 0; row < 4; ++row)
      parts[row][part] = fourLanes(base[row], offsets.of + 4 * part);
  for (int row = 0; row < 4; ++row) bytes[row] = joinedLanes(parts[row]);
}
// Four bytes from each offset on.
HWY_INLINE VI bytesAt(const std::byte* base, VI offset) {
  const LaneOffsets offsets = laneOffsets(offset);
  __m128i parts[kParts];
  for (int part = 0; part < kParts; ++part) parts[part] = fourLanes(base, offsets.of + 4 * part);
  return joinedLanes(parts);
}
// Eight.
HWY_INLINE Wide wideFrom(const __m128i* parts) {
  const VI lower = joinedLanes(parts), upper = joinedLanes(parts + kParts);
  return {hn::ConcatEven(I(), upper, lower), hn::ConcatOdd(I(), upper, lower)};
}
HWY_INLINE Wide wideAt(const std::byte* base, VI offset) {
  const LaneOffsets offsets = laneOffsets(offset);
  __m128i parts[2 * kParts];
  for (int part = 0; part < 2 * kParts; ++part)
    parts[part] = twoLanes(base, offsets.of + 2 * part);
  return wideFrom(parts);
}
// Eight of each base.
template <int kBases>
HWY_INLINE void wideOfEach(const std::byte* const (&base)[kBases], VI offset,
                           Wide (&wide)[kBases]) {
  const LaneOffsets offsets = laneOffsets(offset);
  __m128i parts[kBases][2 * kParts];
  for (int part = 0; part < 2 * kParts; ++part)
    for (int row = 0; row < kBases; ++row)
      parts[row][part] = twoLanes(base[row], offsets.of + 2 * part);
  for (int row = 0; row < kBases; ++row) wide[row] = wideFrom(parts[row]);
}
// Four floats.
HWY_INLINE Quad quadAt(const std::byte* base, VI offset) {
  const LaneOffsets offsets = laneOffsets(offset);
  V lanes[4];  // [i]: lane i of each four
  for (int i = 0; i < 4; ++i) {
    __m128i parts[kParts];
    for (int part = 0; part < kParts; ++part)
      parts[part] = _mm_loadu_si128(
          reinterpret_cast<const __m128i*>(base + offsets.of[4 * part + i]));
    lanes[i] = hn::BitCast(F(), joinedLanes(parts));
  }
  // Transposed, each 4 x 4.
  const hn::Repartition<double, F> pairs;
  const auto lower = hn::BitCast(pairs, hn::InterleaveLower(F(), lanes[0], lanes[1]));
  const auto lower_on = hn::BitCast(pairs, hn::InterleaveLower(F(), lanes[2], lanes[3]));
  const auto upper = hn::BitCast(pairs, hn::InterleaveUpper(F(), lanes[0], lanes[1]));
  const auto upper_on = hn::BitCast(pairs, hn::InterleaveUpper(F(), lanes[2], lanes[3]));
  return {{hn::BitCast(F(), hn::InterleaveLower(pairs, lower, lower_on)),
           hn::BitCast(F(), hn::InterleaveUpper(pairs, lower, lower_on)),
           hn::BitCast(F(), hn::InterleaveLower(pairs, upper, upper_on)),
           hn::BitCast(F(), hn::InterleaveUpper(pairs, upper, upper_on))}};
}
#else
// Gathers are loads of single lanes there.
HWY_INLINE void fourAtOnce(const std::byte* const (&base)[4], VI offset, VI (&bytes)[4]) {
  for (int row = 0; row < 4; ++row)
    bytes[row] = hn::GatherOffset(I(), reinterpret_cast<const int32_t*>(base[row]), offset);
}
HWY_INLINE VI bytesAt(const std::byte* base, VI offset) {
  return hn::GatherOffset(I(), reinterpret_cast<const int32_t*>(base), offset);
}
HWY_INLINE Wide wideAt(const std::byte* base, VI offset) {
  return {hn::GatherOffset(I(), reinterpret_cast<const int32_t*>(base), offset),
          hn::GatherOffset(I(), reinterpret_cast<const int32_t*>(base) + 1, offset)};
}
template <int kBases>
HWY_INLINE void wideOfEach(const std::byte* const (&base)[kBases], VI offset,
                           Wide (&wide)[kBases]) {
  for (int row = 0; row < kBases; ++row) wide[row] = wideAt(base[row], offset);
}
HWY_INLINE Quad quadAt(const std::byte* base, VI offset) {
  const auto* floats = reinterpret_cast<const float*>(base);
  return {{hn::GatherOffset(F(), floats, offset), hn::GatherOffset(F(), floats + 1, offset),
           hn::GatherOffset(F(), floats + 2, offset), hn::GatherOffset(F(), floats + 3, offset)}};
}
#endif

HWY_INLINE V floatsAt(const float* base, VI index) {
  return hn::BitCast(
      F(), bytesAt(reinterpret_cast<const std::byte*>(base), hn::ShiftLeft<2>(index)));
}
