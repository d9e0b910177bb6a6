// Texels of a chunk: eight around a place, and what lies between them. Included once a target.

// Whole texel coordinates below a place, and the way on to the next.
struct Place {
  VI offset;  // in bytes
  V fx, fy, fz;
};

// What reading in a box needs, made once a packet so that loops find it in registers: where samples
// may lie, [lo, hi], and the last cell of each axis.
struct Cells {
  V3 lo, hi, last, stride;
};
HWY_INLINE float lastCell(float lo, float hi) { return hi - 1 > lo ? hi - 1 : lo; }
HWY_INLINE Cells cellsOf(const KernelBox& box, const Float3& lo, const Float3& hi) {
  return {{all(lo[0]), all(lo[1]), all(lo[2])},
          {all(hi[0]), all(hi[1]), all(hi[2])},
          {all(lastCell(lo[0], hi[0])), all(lastCell(lo[1], hi[1])), all(lastCell(lo[2], hi[2]))},
          {all(box.stride[0]), all(box.stride[1]), all(box.stride[2])}};
}
// Of the box's samples.
HWY_INLINE Cells cellsOf(const KernelBox& box) { return cellsOf(box, {0, 0, 0}, box.texel_hi); }

HWY_INLINE V3 clamped(const Cells& cells, const V3& at) {
  return {hn::Min(hn::Max(at.x, cells.lo.x), cells.hi.x),
          hn::Min(hn::Max(at.y, cells.lo.y), cells.hi.y),
          hn::Min(hn::Max(at.z, cells.lo.z), cells.hi.z)};
}

HWY_INLINE V cellOf(V at, V lo, V last) { return hn::Min(hn::Max(hn::Floor(at), lo), last); }

// Requires: `at` is clamped but for rounding, which leads a little beyond the outer cells.
HWY_INLINE Place placeAt(const Cells& cells, const V3& at) {
  const V x = cellOf(at.x, cells.lo.x, cells.last.x), y = cellOf(at.y, cells.lo.y, cells.last.y),
          z = cellOf(at.z, cells.lo.z, cells.last.z);
  // Exact, see appendBox().
  const V offset = hn::MulAdd(z, cells.stride.z,
                              hn::MulAdd(y, cells.stride.y, hn::Mul(x, cells.stride.x)));
  return {wholeOf(offset), hn::Sub(at.x, x), hn::Sub(at.y, y), hn::Sub(at.z, z)};
}

// Four bytes from each offset on; what would lie beyond the chunk is 0.
// kNearEnd: looks whether it would.
template <bool kNearEnd>
HWY_INLINE VI fourBytes(const KernelBox& box, VI offset, int64_t more) {
  const auto* base = reinterpret_cast<const int32_t*>(box.texels + more);
  if (!kNearEnd || HWY_LIKELY(!box.near_end)) return hn::GatherOffset(I(), base, offset);
  const VI last = hn::Set(I(), static_cast<int32_t>(box.last_offset - more));
  const VI from = hn::Min(offset, last);
  const hn::RebindToUnsigned<I> unsigned_tag;
  const auto bits = hn::BitCast(unsigned_tag, hn::ShiftLeft<3>(hn::Sub(offset, from)));
  const auto read = hn::BitCast(unsigned_tag, hn::GatherOffset(I(), base, from));
  const auto shifted = hn::Shr(read, hn::Min(bits, hn::Set(unsigned_tag, 31)));
  return hn::BitCast(I(), hn::IfThenElseZero(hn::Lt(bits, hn::Set(unsigned_tag, 32)), shifted));
}

// Two texels, neighbours along x.
struct Pair {
  V first, second;
};
// kDown: bytes before the pair in what was read.
template <DeviceType kType, int kDown = 0>
HWY_INLINE Pair pairIn(VI bytes) {
  constexpr int kBits = kType == DeviceType::kU8 ? 8 : 16;
  const VI mask = hn::Set(I(), (1 << kBits) - 1);
  return {hn::ConvertTo(F(), hn::And(hn::ShiftRight<8 * kDown>(bytes), mask)),
          hn::ConvertTo(F(), hn::And(hn::ShiftRight<8 * kDown + kBits>(bytes), mask))};
}
template <DeviceType kType, bool kNearEnd>
HWY_INLINE Pair pairAt(const KernelBox& box, VI offset, int64_t more) {
  if constexpr (kType == DeviceType::kF32) {
    const auto* base = reinterpret_cast<const float*>(box.texels + more);
    const auto* next = reinterpret_cast<const float*>(box.texels + more +
                                                      static_cast<int64_t>(box.stride[0]));
    return {hn::GatherOffset(F(), base, offset), hn::GatherOffset(F(), next, offset)};
  } else {
    return pairIn<kType>(fourBytes<kNearEnd>(box, offset, more));
  }
}

// Exact at both ends.
HWY_INLINE V between(V first, V second, V part, V rest) {
  return hn::MulAdd(second, part, hn::Mul(first, rest));
}

template <DeviceType kType, bool kNearEnd>
HWY_INLINE V alongX(const KernelBox& box, VI offset, int64_t more, V part, V rest) {
  const Pair pair = pairAt<kType, kNearEnd>(box, offset, more);
  return between(pair.first, pair.second, part, rest);
}

// The pairs of the four rows around a place: [0] and [1] one after the other along y, [2] and [3]
// the same a plane on.
struct Rows {
  Pair pair[4];
};
template <DeviceType kType>
HWY_INLINE Rows rowsNearEnd(const KernelBox& box, VI offset, int64_t y, int64_t z) {
  return {{pairAt<kType, true>(box, offset, 0), pairAt<kType, true>(box, offset, y),
           pairAt<kType, true>(box, offset, z), pairAt<kType, true>(box, offset, y + z)}};
}
HWY_INLINE Pair floatsAt(const KernelBox& box, VI offset, int64_t more) {
  const Wide both = wideAt(box.texels + more, offset);
  return {hn::BitCast(F(), both.first), hn::BitCast(F(), both.second)};
}
template <DeviceType kType>
HWY_INLINE Rows rowsAt(const KernelBox& box, VI offset) {
  const auto y = static_cast<int64_t>(box.stride[1]), z = static_cast<int64_t>(box.stride[2]);
  if constexpr (kType == DeviceType::kF32) {
    if (HWY_UNLIKELY(box.one_by_one)) return rowsNearEnd<kType>(box, offset, y, z);
    return {{floatsAt(box, offset, 0), floatsAt(box, offset, y), floatsAt(box, offset, z),
             floatsAt(box, offset, y + z)}};
  } else {
    if (HWY_UNLIKELY(box.one_by_one)) return rowsNearEnd<kType>(box, offset, y, z);
    // Of the last row the bytes before are read, not those behind, which may lie beyond the chunk.
    constexpr int kDown = kType == DeviceType::kU8 ? 2 : 0;
    const std::byte* from[4] = {box.texels, box.texels + y, box.texels + z,
                                box.texels + (y + z - kDown)};
    VI bytes[4];
    fourAtOnce(from, offset, bytes);
    return {{pairIn<kType>(bytes[0]), pairIn<kType>(bytes[1]), pairIn<kType>(bytes[2]),
             pairIn<kType, kDown>(bytes[3])}};
  }
}

template <DeviceType kType>
HWY_INLINE V valueAt(const KernelBox& box, const Place& place) {
  const Rows rows = rowsAt<kType>(box, place.offset);
  const V rx = hn::Sub(all(1.0F), place.fx), ry = hn::Sub(all(1.0F), place.fy);
  V row[4];
  for (int i = 0; i < 4; ++i)
    row[i] = between(rows.pair[i].first, rows.pair[i].second, place.fx, rx);
  const V lower = between(row[0], row[1], place.fy, ry);
  const V upper = between(row[2], row[3], place.fy, ry);
  return between(lower, upper, place.fz, hn::Sub(all(1.0F), place.fz));
}

// Below it lie the stand-in for NaN and whatever is interpolated with it.
HWY_INLINE M isNoNumber(V value) { return hn::Lt(value, all(-2e30F)); }

// The value that has the greatest weight among the eight texels around, see LookUp.
template <DeviceType kType>
HWY_INLINE V labelAt(const KernelBox& box, const Place& place) {
  const auto y = static_cast<int64_t>(box.stride[1]), z = static_cast<int64_t>(box.stride[2]);
  const V one = all(1.0F);
  alignas(64) float values[8][kMostLanes], weights[8][kMostLanes];
  for (int row = 0; row < 4; ++row) {
    const Pair pair = pairAt<kType, true>(box, place.offset,
                                    ((row & 1) != 0 ? y : 0) + ((row & 2) != 0 ? z : 0));
    const V weight = hn::Mul((row & 1) != 0 ? place.fy : hn::Sub(one, place.fy),
                             (row & 2) != 0 ? place.fz : hn::Sub(one, place.fz));
    hn::Store(pair.first, F(), values[2 * row]);
    hn::Store(pair.second, F(), values[2 * row + 1]);
    hn::Store(hn::Mul(weight, hn::Sub(one, place.fx)), F(), weights[2 * row]);
    hn::Store(hn::Mul(weight, place.fx), F(), weights[2 * row + 1]);
  }
  const V tie = all(static_cast<float>(kLabelTie));
  V best = hn::Load(F(), values[0]), most = all(-1.0F);
  for (int i = 0; i < 8; ++i) {
    const V value = hn::Load(F(), values[i]);
    V weight = hn::Zero(F());
    for (int k = 0; k < 8; ++k)
      weight = hn::Add(weight, hn::IfThenElseZero(hn::Eq(hn::Load(F(), values[k]), value),
                                                  hn::Load(F(), weights[k])));
    const M wins = hn::Or(hn::Gt(weight, hn::Add(most, tie)),
                          hn::And(hn::Gt(weight, hn::Sub(most, tie)), hn::Gt(value, best)));
    best = hn::IfThenElse(wins, value, best);
    most = hn::IfThenElse(wins, weight, most);
  }
  return best;
}

// Half of the difference; a neighbour that is no number says nothing of the slope along its axis.
template <DeviceType kType>
HWY_INLINE V halfDifference(V next, V last) {
  const V difference = hn::Mul(all(0.5F), hn::Sub(next, last));
  if constexpr (kType == DeviceType::kF32)
    return hn::IfThenZeroElse(isNoNumber(hn::Min(next, last)), difference);
  else
    return difference;
}

// Half of the difference between the values a voxel on and a voxel back along one texel axis.
template <DeviceType kType>
HWY_INLINE V differenceAlong(const KernelBox& box, V3 at, int axis) {
  V3 after = at, before = at;
  V& on = axis == 0 ? after.x : axis == 1 ? after.y : after.z;
  V& back = axis == 0 ? before.x : axis == 1 ? before.y : before.z;
  on = hn::Add(on, all(1.0F));
  back = hn::Sub(back, all(1.0F));
  const Cells cells = cellsOf(box, box.storage_lo, box.storage_hi);
  const V next = valueAt<kType>(box, placeAt(cells, clamped(cells, after)));
  const V last = valueAt<kType>(box, placeAt(cells, clamped(cells, before)));
  return halfDifference<kType>(next, last);
}

// Four texels along x, from one before a place on.
struct Four {
  V before, first, second, after;
};
template <DeviceType kType>
HWY_INLINE Four fourAt(const KernelBox& box, VI offset, int64_t more) {
  if constexpr (kType == DeviceType::kU8) {
    const VI mask = hn::Set(I(), 255);
    const VI bytes = fourBytes<true>(box, offset, more - 1);
    return {hn::ConvertTo(F(), hn::And(bytes, mask)),
            hn::ConvertTo(F(), hn::And(hn::ShiftRight<8>(bytes), mask)),
            hn::ConvertTo(F(), hn::And(hn::ShiftRight<16>(bytes), mask)),
            hn::ConvertTo(F(), hn::And(hn::ShiftRight<24>(bytes), mask))};
  } else {
    const auto texel = static_cast<int64_t>(kType == DeviceType::kU16 ? 2 : 4);
    const Pair lower = pairAt<kType, true>(box, offset, more - texel);
    const Pair upper = pairAt<kType, true>(box, offset, more + texel);
    return {lower.first, lower.second, upper.first, upper.second};
  }
}

// differenceAlong() each axis at once, of a box with a margin: neighbours share most of the texels.
template <DeviceType kType>
HWY_INLINE V3 differencesAt(const KernelBox& box, const Place& place) {
  const auto y = static_cast<int64_t>(box.stride[1]), z = static_cast<int64_t>(box.stride[2]);
  const V one = all(1.0F), fx = place.fx, fy = place.fy, fz = place.fz;
  const V rx = hn::Sub(one, fx), ry = hn::Sub(one, fy), rz = hn::Sub(one, fz);
  const VI at = place.offset;
  V inner[2][2], last_x[2][2], next_x[2][2];  // [z][y]
  for (int k = 0; k < 2; ++k)
    for (int j = 0; j < 2; ++j) {
      const Four four = fourAt<kType>(box, at, j * y + k * z);
      inner[k][j] = between(four.first, four.second, fx, rx);
      last_x[k][j] = between(four.before, four.first, fx, rx);
      next_x[k][j] = between(four.second, four.after, fx, rx);
    }
  const V last_of_x = between(between(last_x[0][0], last_x[0][1], fy, ry),
                              between(last_x[1][0], last_x[1][1], fy, ry), fz, rz);
  const V next_of_x = between(between(next_x[0][0], next_x[0][1], fy, ry),
                              between(next_x[1][0], next_x[1][1], fy, ry), fz, rz);
  V last_y[2], next_y[2];
  for (int k = 0; k < 2; ++k) {
    last_y[k] = between(alongX<kType, true>(box, at, k * z - y, fx, rx), inner[k][0], fy, ry);
    next_y[k] = between(inner[k][1], alongX<kType, true>(box, at, k * z + 2 * y, fx, rx), fy, ry);
  }
  V last_z[2], next_z[2];
  for (int j = 0; j < 2; ++j) {
    last_z[j] = between(alongX<kType, true>(box, at, j * y - z, fx, rx), inner[0][j], fz, rz);
    next_z[j] = between(inner[1][j], alongX<kType, true>(box, at, j * y + 2 * z, fx, rx), fz, rz);
  }
  return {halfDifference<kType>(next_of_x, last_of_x),
          halfDifference<kType>(between(next_y[0], next_y[1], fz, rz),
                                between(last_y[0], last_y[1], fz, rz)),
          halfDifference<kType>(between(next_z[0], next_z[1], fy, ry),
                                between(last_z[0], last_z[1], fy, ry))};
}
