// Texels of a chunk: eight around a place, and the value interpolated between them. Included once a
// target.

// The whole texel coordinates below a place, and the way on to the next.
struct Place {
  VI offset;  // in bytes
  V fx, fy, fz;
};

// The bounds for reading in a box, made once a packet so that loops find them in registers: samples
// lie in [lo, hi], and `last` is the last cell of each axis.
struct Cells {
  V3 lo, hi, last, stride;
};
HWY_INLINE Cells cellsOf(const KernelBox& box, const Float3& lo, const Float3& hi,
                         const Float3& last) {
  return {{all(lo[0]), all(lo[1]), all(lo[2])},
          {all(hi[0]), all(hi[1]), all(hi[2])},
          {all(last[0]), all(last[1]), all(last[2])},
          {all(box.stride[0]), all(box.stride[1]), all(box.stride[2])}};
}
// Bounds of the box's samples.
HWY_INLINE Cells cellsOf(const KernelBox& box) {
  return cellsOf(box, {0, 0, 0}, box.texel_hi, box.last_cell);
}
// Bounds of all texels of the chunk.
HWY_INLINE float lastCell(float lo, float hi) { return hi - 1 > lo ? hi - 1 : lo; }
HWY_INLINE Cells storedCells(const KernelBox& box) {
  const Float3 &lo = box.storage_lo, &hi = box.storage_hi;
  return cellsOf(box, lo, hi,
                 {lastCell(lo[0], hi[0]), lastCell(lo[1], hi[1]), lastCell(lo[2], hi[2])});
}

HWY_INLINE V3 clamped(const Cells& cells, const V3& at) {
  return {hn::Min(hn::Max(at.x, cells.lo.x), cells.hi.x),
          hn::Min(hn::Max(at.y, cells.lo.y), cells.hi.y),
          hn::Min(hn::Max(at.z, cells.lo.z), cells.hi.z)};
}

HWY_INLINE V cellOf(V at, V lo, V last) { return hn::Min(hn::Max(hn::Floor(at), lo), last); }

// Requires: `at` is clamped but for rounding, which leads a little beyond the outer cells. Lanes
// whose value is not used may be anywhere: the cell is clamped.
HWY_INLINE Place placeAt(const Cells& cells, const V3& at) {
  const V x = cellOf(at.x, cells.lo.x, cells.last.x), y = cellOf(at.y, cells.lo.y, cells.last.y),
          z = cellOf(at.z, cells.lo.z, cells.last.z);
  // Exact, see appendBox().
  const V offset = hn::MulAdd(z, cells.stride.z,
                              hn::MulAdd(y, cells.stride.y, hn::Mul(x, cells.stride.x)));
  return {wholeOf(offset), hn::Sub(at.x, x), hn::Sub(at.y, y), hn::Sub(at.z, z)};
}

// Two texels, neighbours along x.
struct Pair {
  V first, second;
};
// kDown: bytes before the pair in the bytes read.
template <DeviceType kType, int kDown = 0>
HWY_INLINE Pair pairIn(VI bytes) {
  constexpr int kBits = kType == DeviceType::kU8 ? 8 : 16;
  const VI mask = hn::Set(I(), (1 << kBits) - 1);
  return {hn::ConvertTo(F(), hn::And(hn::ShiftRight<8 * kDown>(bytes), mask)),
          hn::ConvertTo(F(), hn::And(hn::ShiftRight<8 * kDown + kBits>(bytes), mask))};
}

// Exact at both ends.
HWY_INLINE V between(V first, V second, V part, V rest) {
  return hn::MulAdd(second, part, hn::Mul(first, rest));
}

// The pairs of four rows, each `more` bytes from each offset on. kDown: bytes before the pair that
// are read of the last row, if the bytes behind may lie beyond the chunk.
struct Rows {
  Pair pair[4];
};
template <DeviceType kType, int kDown = 0>
HWY_INLINE Rows rowsAt(const KernelBox& box, VI offset, const int64_t (&more)[4]) {
  if constexpr (kType == DeviceType::kF32) {
    Rows rows;
    for (int i = 0; i < 4; ++i) {
      const Wide both = wideAt(box.texels + more[i], offset);
      rows.pair[i] = {hn::BitCast(F(), both.first), hn::BitCast(F(), both.second)};
    }
    return rows;
  } else {
    const std::byte* from[4] = {box.texels + more[0], box.texels + more[1], box.texels + more[2],
                                box.texels + more[3] - kDown};
    VI bytes[4];
    fourAtOnce(from, offset, bytes);
    return {{pairIn<kType>(bytes[0]), pairIn<kType>(bytes[1]), pairIn<kType>(bytes[2]),
             pairIn<kType, kDown>(bytes[3])}};
  }
}

// The rows around a place: [0] and [1] one after the other along y, [2] and [3] the same a plane on.
template <DeviceType kType>
HWY_INLINE Rows rowsAround(const KernelBox& box, VI offset) {
  const auto y = static_cast<int64_t>(box.stride[1]), z = static_cast<int64_t>(box.stride[2]);
  return rowsAt<kType, kType == DeviceType::kU8 ? 2 : 0>(box, offset, {0, y, z, y + z});
}

template <DeviceType kType>
HWY_INLINE V valueAt(const KernelBox& box, const Place& place) {
  const Rows rows = rowsAround<kType>(box, place.offset);
  const V rx = hn::Sub(all(1.0F), place.fx), ry = hn::Sub(all(1.0F), place.fy);
  V row[4];
  for (int i = 0; i < 4; ++i)
    row[i] = between(rows.pair[i].first, rows.pair[i].second, place.fx, rx);
  const V lower = between(row[0], row[1], place.fy, ry);
  const V upper = between(row[2], row[3], place.fy, ry);
  return between(lower, upper, place.fz, hn::Sub(all(1.0F), place.fz));
}

// Pairs of four rows of a chunk with spreads, each `more` bytes from each offset on.
struct SpreadRows {
  Pair mean[4], spread[4];
  // The four bytes are a mean, its spread, and the next texel's.
  HWY_INLINE void setPairs(int row, VI bytes) {
    const VI mask = hn::Set(I(), 0x00FF00FF);
    mean[row] = pairIn<DeviceType::kU16>(hn::And(bytes, mask));
    spread[row] = pairIn<DeviceType::kU16>(hn::And(hn::ShiftRight<8>(bytes), mask));
  }
};
template <DeviceType kType>
HWY_INLINE SpreadRows spreadRowsAt(const KernelBox& box, VI offset, const int64_t (&more)[4]) {
  const std::byte* from[4] = {box.texels + more[0], box.texels + more[1], box.texels + more[2],
                              box.texels + more[3]};
  SpreadRows rows;
  if constexpr (kType == DeviceType::kU8) {
    VI bytes[4];
    fourAtOnce(from, offset, bytes);
    for (int i = 0; i < 4; ++i) rows.setPairs(i, bytes[i]);
  } else if constexpr (kType == DeviceType::kU16) {
    for (int i = 0; i < 4; ++i) {
      const auto [first, second] = wideAt(from[i], offset);
      const Pair one = pairIn<kType>(first), next = pairIn<kType>(second);
      rows.mean[i] = {one.first, next.first};
      rows.spread[i] = {one.second, next.second};
    }
  } else {
    for (int i = 0; i < 4; ++i) {
      const Quad quad = quadAt(from[i], offset);
      rows.mean[i] = {quad.of[0], quad.of[2]};
      rows.spread[i] = {quad.of[1], quad.of[3]};
    }
  }
  return rows;
}
// Those around a place.
template <DeviceType kType>
HWY_INLINE SpreadRows spreadRowsAround(const KernelBox& box, VI offset) {
  const auto y = static_cast<int64_t>(box.stride[1]), z = static_cast<int64_t>(box.stride[2]);
  return spreadRowsAt<kType>(box, offset, {0, y, z, y + z});
}
HWY_INLINE V withinRows(const Pair (&rows)[4], const Place& place) {
  const V one = all(1.0F), rx = hn::Sub(one, place.fx), ry = hn::Sub(one, place.fy),
          rz = hn::Sub(one, place.fz);
  V row[4];
  for (int i = 0; i < 4; ++i) row[i] = between(rows[i].first, rows[i].second, place.fx, rx);
  return between(between(row[0], row[1], place.fy, ry), between(row[2], row[3], place.fy, ry),
                 place.fz, rz);
}

// The mean at a place in a chunk with spreads.
template <DeviceType kType>
HWY_INLINE V meanAt(const KernelBox& box, const Place& place) {
  return withinRows(spreadRowsAround<kType>(box, place.offset).mean, place);
}

// The mean, and the square of the spread in units of 1 / spread_scale (see ExpectedLook). NaN
// texels have no spread.
struct SpreadValue {
  V mean, square;
};
template <DeviceType kType>
HWY_INLINE SpreadValue spreadAt(const KernelBox& box, const Place& place, float spread_scale) {
  SpreadRows rows = spreadRowsAround<kType>(box, place.offset);
  const auto square = [&](V spread) {
    // Squares of values themselves may overflow.
    const V share = hn::Mul(hn::Max(spread, hn::Zero(F())), all(spread_scale));
    return hn::Mul(share, share);
  };
  for (Pair& pair : rows.spread) pair = {square(pair.first), square(pair.second)};
  return {withinRows(rows.mean, place), withinRows(rows.spread, place)};
}

// Below it lie the stand-in for NaN and whatever is interpolated with it.
HWY_INLINE M isNoNumber(V value) { return hn::Lt(value, all(-2e30F)); }

// Eight numbers of each lane, those of the texels around a place.
struct EightNumbers {
  alignas(64) float of[8][kMostLanes];
  HWY_INLINE V at(int i) const { return hn::Load(F(), of[i]); }
};
HWY_INLINE EightNumbers eightOf(const Pair (&rows)[4]) {
  EightNumbers numbers;
  for (int row = 0; row < 4; ++row) {
    hn::Store(rows[row].first, F(), numbers.of[2 * row]);
    hn::Store(rows[row].second, F(), numbers.of[2 * row + 1]);
  }
  return numbers;
}
HWY_INLINE EightNumbers weightsAt(const Place& place) {
  const V one = all(1.0F);
  EightNumbers weights;
  for (int row = 0; row < 4; ++row) {
    const V weight = hn::Mul((row & 1) != 0 ? place.fy : hn::Sub(one, place.fy),
                             (row & 2) != 0 ? place.fz : hn::Sub(one, place.fz));
    hn::Store(hn::Mul(weight, hn::Sub(one, place.fx)), F(), weights.of[2 * row]);
    hn::Store(hn::Mul(weight, place.fx), F(), weights.of[2 * row + 1]);
  }
  return weights;
}
HWY_INLINE V heaviestOf(const EightNumbers& values, const EightNumbers& weights) {
  const V tie = all(static_cast<float>(kLabelTie));
  V best = values.at(0), most = all(-1.0F);
  for (int i = 0; i < 8; ++i) {
    const V value = values.at(i);
    V weight = hn::Zero(F());
    for (int k = 0; k < 8; ++k)
      weight =
          hn::Add(weight, hn::IfThenElseZero(hn::Eq(values.at(k), value), weights.at(k)));
    const M wins = hn::Or(hn::Gt(weight, hn::Add(most, tie)),
                          hn::And(hn::Gt(weight, hn::Sub(most, tie)), hn::Gt(value, best)));
    best = hn::IfThenElse(wins, value, best);
    most = hn::IfThenElse(wins, weight, most);
  }
  return best;
}

// The value that has the greatest weight among the eight texels around, see LookUp. A call of its own: its
// 64 comparisons inside each kernel took a large share of the compiler's time.
template <DeviceType kType>
HWY_NOINLINE V labelAt(const KernelBox& box, Place place) {
  const Rows rows = rowsAround<kType>(box, place.offset);
  const V first = rows.pair[0].first;
  M differ = hn::Ne(rows.pair[0].second, first);
  for (int i = 1; i < 4; ++i)
    differ = hn::Or(differ, hn::Or(hn::Ne(rows.pair[i].first, first),
                                   hn::Ne(rows.pair[i].second, first)));
  // Most places lie within one label.
  if (hn::AllFalse(F(), differ)) return first;
  return heaviestOf(eightOf(rows.pair), weightsAt(place));
}
// Half of the difference; a NaN neighbour tells nothing of the slope along its axis.
template <DeviceType kType>
HWY_INLINE V halfDifference(V next, V last) {
  const V difference = hn::Mul(all(0.5F), hn::Sub(next, last));
  if constexpr (kType == DeviceType::kF32)
    return hn::IfThenZeroElse(isNoNumber(hn::Min(next, last)), difference);
  else
    return difference;
}

// Half of the difference between the values a texel on and a texel back along one texel axis.
template <DeviceType kType, bool kSpread>
HWY_INLINE V differenceAlong(const KernelBox& box, V3 at, int axis) {
  V3 after = at, before = at;
  V& on = axis == 0 ? after.x : axis == 1 ? after.y : after.z;
  V& back = axis == 0 ? before.x : axis == 1 ? before.y : before.z;
  on = hn::Add(on, all(1.0F));
  back = hn::Sub(back, all(1.0F));
  const Cells cells = storedCells(box);
  const Place place_after = placeAt(cells, clamped(cells, after));
  const Place place_before = placeAt(cells, clamped(cells, before));
  V next, last;
  if constexpr (kSpread) {
    next = meanAt<kType>(box, place_after);
    last = meanAt<kType>(box, place_before);
  } else {
    next = valueAt<kType>(box, place_after);
    last = valueAt<kType>(box, place_before);
  }
  return halfDifference<kType>(next, last);
}

// The differences along each axis. If chunks have a margin, differencesAt() does it with fewer
// reads; the rest is rare and so long that it is a call of its own.
template <DeviceType kType, bool kSpread>
HWY_NOINLINE V3 differencesWithoutMargin(const KernelBox& box, V3 at) {
  return {differenceAlong<kType, kSpread>(box, at, 0), differenceAlong<kType, kSpread>(box, at, 1),
          differenceAlong<kType, kSpread>(box, at, 2)};
}

// The pairs of four rows: of values, or of means.
template <DeviceType kType, bool kSpread>
HWY_INLINE Rows pairsAt(const KernelBox& box, VI offset, const int64_t (&more)[4]) {
  if constexpr (kSpread) {
    const SpreadRows rows = spreadRowsAt<kType>(box, offset, more);
    return {{rows.mean[0], rows.mean[1], rows.mean[2], rows.mean[3]}};
  } else {
    return rowsAt<kType>(box, offset, more);
  }
}

// Texels of four rows along x, from one before a place on.
struct LongRows {
  V before[4], first[4], second[4], after[4];
};
template <DeviceType kType, bool kSpread>
HWY_INLINE LongRows longRowsAt(const KernelBox& box, VI offset, const int64_t (&more)[4]) {
  LongRows rows;
  if constexpr (kType == DeviceType::kU8 && !kSpread) {
    const VI mask = hn::Set(I(), 255);
    const std::byte* from[4] = {box.texels + more[0] - 1, box.texels + more[1] - 1,
                                box.texels + more[2] - 1, box.texels + more[3] - 1};
    VI bytes[4];
    fourAtOnce(from, offset, bytes);
    for (int i = 0; i < 4; ++i) {
      rows.before[i] = hn::ConvertTo(F(), hn::And(bytes[i], mask));
      rows.first[i] = hn::ConvertTo(F(), hn::And(hn::ShiftRight<8>(bytes[i]), mask));
      rows.second[i] = hn::ConvertTo(F(), hn::And(hn::ShiftRight<16>(bytes[i]), mask));
      rows.after[i] = hn::ConvertTo(F(), hn::And(hn::ShiftRight<24>(bytes[i]), mask));
    }
  } else {
    const auto texel = static_cast<int64_t>(box.stride[0]);
    const Rows lower = pairsAt<kType, kSpread>(
        box, offset, {more[0] - texel, more[1] - texel, more[2] - texel, more[3] - texel});
    const Rows upper = pairsAt<kType, kSpread>(
        box, offset, {more[0] + texel, more[1] + texel, more[2] + texel, more[3] + texel});
    for (int i = 0; i < 4; ++i) {
      rows.before[i] = lower.pair[i].first;
      rows.first[i] = lower.pair[i].second;
      rows.second[i] = upper.pair[i].first;
      rows.after[i] = upper.pair[i].second;
    }
  }
  return rows;
}

// differenceAlong() each axis at once. [j + 2 * k] of `near`: j rows and k planes on. `alongY()`
// returns rows a row back, of both planes, and a row beyond; `alongZ()` those a plane back, of both
// rows, and a plane beyond. They are called in between, when registers are free.
template <DeviceType kType, class AlongY, class AlongZ>
HWY_INLINE V3 differencesIn(const LongRows& near, const Place& place, const AlongY& alongY,
                            const AlongZ& alongZ) {
  const V one = all(1.0F), fx = place.fx, fy = place.fy, fz = place.fz;
  const V rx = hn::Sub(one, fx), ry = hn::Sub(one, fy), rz = hn::Sub(one, fz);
  V inner[4], last_x[4], next_x[4];
  for (int i = 0; i < 4; ++i) {
    inner[i] = between(near.first[i], near.second[i], fx, rx);
    last_x[i] = between(near.before[i], near.first[i], fx, rx);
    next_x[i] = between(near.second[i], near.after[i], fx, rx);
  }
  const V last_of_x = between(between(last_x[0], last_x[1], fy, ry),
                              between(last_x[2], last_x[3], fy, ry), fz, rz);
  const V next_of_x = between(between(next_x[0], next_x[1], fy, ry),
                              between(next_x[2], next_x[3], fy, ry), fz, rz);
  const Rows along_y = alongY(), along_z = alongZ();
  V last_y[2], next_y[2], last_z[2], next_z[2];
  for (int i = 0; i < 2; ++i) {
    const Pair &row_back = along_y.pair[i], &row_on = along_y.pair[i + 2];
    last_y[i] = between(between(row_back.first, row_back.second, fx, rx), inner[2 * i], fy, ry);
    next_y[i] = between(inner[2 * i + 1], between(row_on.first, row_on.second, fx, rx), fy, ry);
    const Pair &plane_back = along_z.pair[i], &plane_on = along_z.pair[i + 2];
    last_z[i] = between(between(plane_back.first, plane_back.second, fx, rx), inner[i], fz, rz);
    next_z[i] = between(inner[i + 2], between(plane_on.first, plane_on.second, fx, rx), fz, rz);
  }
  return {halfDifference<kType>(next_of_x, last_of_x),
          halfDifference<kType>(between(next_y[0], next_y[1], fz, rz),
                                between(last_y[0], last_y[1], fz, rz)),
          halfDifference<kType>(between(next_z[0], next_z[1], fy, ry),
                                between(last_z[0], last_z[1], fy, ry))};
}

// The same in a box with a margin: neighbours share most of the texels.
template <DeviceType kType, bool kSpread>
HWY_INLINE V3 differencesAt(const KernelBox& box, const Place& place) {
  const auto y = static_cast<int64_t>(box.stride[1]), z = static_cast<int64_t>(box.stride[2]);
  return differencesIn<kType>(
      longRowsAt<kType, kSpread>(box, place.offset, {0, y, z, y + z}), place,
      [&] { return pairsAt<kType, kSpread>(box, place.offset, {-y, z - y, 2 * y, z + 2 * y}); },
      [&] { return pairsAt<kType, kSpread>(box, place.offset, {-z, y - z, 2 * z, y + 2 * z}); });
}
