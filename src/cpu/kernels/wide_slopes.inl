// Slopes by Sobel's operator at the eight texels around a place, interpolated: what it weights, and
// the slopes of texels that stand for many values each, see rough_light.h. Included once a target.

// One texel a lane, from an offset in bytes.
template <DeviceType kType>
HWY_INLINE V texelsFrom(const std::byte* base, VI offset) {
  using T = std::conditional_t<kType == DeviceType::kU8, uint8_t,
                               std::conditional_t<kType == DeviceType::kU16, uint16_t, float>>;
  alignas(64) int32_t offsets[kMostLanes];
  alignas(64) float values[kMostLanes];
  hn::Store(offset, I(), offsets);
  for (int lane = 0; lane < kLanes; ++lane) {
    T value;
    __builtin_memcpy(&value, base + offsets[lane], sizeof value);
    values[lane] = static_cast<float>(value);
  }
  return hn::Load(F(), values);
}

// Sobel's weights along an axis, interpolated between two texels: of the texel before a place, the
// two around it and the one behind it, for the slope along the axis and for a mean across it.
struct SobelWeights {
  V slope[4], mean[4];
};
HWY_INLINE SobelWeights sobelWeights(V part) {
  const V half = hn::Mul(all(0.5F), part), quarter = hn::Mul(all(0.25F), part);
  const V rest = hn::Sub(all(0.5F), half);
  return {{hn::Neg(rest), hn::Neg(half), rest, half},
          {hn::Sub(all(0.25F), quarter), hn::Sub(all(0.5F), quarter),
           hn::Add(all(0.25F), quarter), quarter}};
}

// The offsets of four texels along an axis, from the one before a cell on, cut by the chunk.
struct FourOffsets {
  VI of[4];
};
HWY_INLINE FourOffsets offsetsAround(const KernelBox& box, V cell, size_t axis) {
  FourOffsets offsets;
  const V lo = all(box.storage_lo[axis]), hi = all(box.storage_hi[axis]);
  for (int i = 0; i < 4; ++i) {
    const V texel = hn::Add(cell, all(static_cast<float>(i - 1)));
    offsets.of[i] = wholeOf(hn::Mul(hn::Min(hn::Max(texel, lo), hi), all(box.stride[axis])));
  }
  return offsets;
}

// Four texels of a row along x: their means and spreads.
struct SpreadRow {
  V mean[4], spread[4];
};
// Beyond it lie values that stand for infinities. Its square is a float.
constexpr float kFarShare = 1e15F;

// The first and the last of four texels along an axis, around a place between the second and the
// third: while the place moves from the middle to the farther one, they become their neighbours, so
// that the least and the greatest of the four do not jump from cell to cell.
struct FourAround {
  V first, second, third, last;
};
HWY_INLINE FourAround fourAround(const V (&four)[4], V part) {
  const V twice = hn::Add(part, part), one = all(1.0F), none = hn::Zero(F());
  const V after = hn::Max(none, hn::Sub(twice, one)), before = hn::Max(none, hn::Sub(one, twice));
  return {hn::MulAdd(after, hn::Sub(four[1], four[0]), four[0]), four[1], four[2],
          hn::MulAdd(before, hn::Sub(four[2], four[3]), four[3])};
}
HWY_INLINE V leastAround(const V (&four)[4], V part) {
  const FourAround around = fourAround(four, part);
  return hn::Min(hn::Min(around.first, around.second), hn::Min(around.third, around.last));
}
HWY_INLINE V greatestAround(const V (&four)[4], V part) {
  const FourAround around = fourAround(four, part);
  return hn::Max(hn::Max(around.first, around.second), hn::Max(around.third, around.last));
}

// The sums over the 64 texels around a place.
struct WideSums {
  V3 slopes;
  V mean, squares;          // the weighted mean of the values and of their squares
  V bottom, top;            // the least and the greatest mean
  V calm;                   // the least spread
  V least;                  // of the means, of floats
};
// `row_of(j, k)`: a SpreadRow of row j in plane k. In shares of the volume's values, from the first
// texel of the cell on: squares of values may overflow, and small differences would be lost.
template <DeviceType kType, class RowOf>
HWY_INLINE WideSums wideSums(const KernelFrame& frame, const Place& place, V first,
                             const RowOf& row_of) {
  const SobelWeights x = sobelWeights(place.fx), y = sobelWeights(place.fy),
                     z = sobelWeights(place.fz);
  const V none = hn::Zero(F()), unit = all(frame.spread_scale),
          half = all(0.5F * frame.spread_scale), origin = hn::Mul(first, unit);
  WideSums sums{{none, none, none}, none, none, none, none, none, first};
  V bottoms[4], tops[4], calms[4];  // of planes
  for (int k = 0; k < 4; ++k) {
    V lows[4], highs[4], stills[4];  // of rows
    for (int j = 0; j < 4; ++j) {
      const SpreadRow row = row_of(j, k);
      V slope = none, mean = none, squares = none, values[4], spreads[4];
      for (int i = 0; i < 4; ++i) {
        V value = hn::MulSub(row.mean[i], unit, origin);
        if constexpr (kType == DeviceType::kF32)
          value = hn::Min(hn::Max(value, all(-kFarShare)), all(kFarShare));
        V spread = row.spread[i];
        if constexpr (kType == DeviceType::kF32) {
          spread = hn::Max(spread, none);
          sums.least = hn::Min(sums.least, row.mean[i]);
        }
        const V deviation = hn::Mul(spread, half);
        values[i] = value;
        spreads[i] = spread;
        slope = hn::MulAdd(x.slope[i], value, slope);
        mean = hn::MulAdd(x.mean[i], value, mean);
        squares = hn::MulAdd(
            x.mean[i], hn::MulAdd(value, value, hn::Mul(deviation, deviation)), squares);
      }
      const V across = hn::Mul(y.mean[j], z.mean[k]);
      sums.slopes.x = hn::MulAdd(across, slope, sums.slopes.x);
      sums.slopes.y = hn::MulAdd(hn::Mul(y.slope[j], z.mean[k]), mean, sums.slopes.y);
      sums.slopes.z = hn::MulAdd(hn::Mul(y.mean[j], z.slope[k]), mean, sums.slopes.z);
      sums.mean = hn::MulAdd(across, mean, sums.mean);
      sums.squares = hn::MulAdd(across, squares, sums.squares);
      lows[j] = leastAround(values, place.fx);
      highs[j] = greatestAround(values, place.fx);
      stills[j] = leastAround(spreads, place.fx);
    }
    bottoms[k] = leastAround(lows, place.fy);
    tops[k] = greatestAround(highs, place.fy);
    calms[k] = leastAround(stills, place.fy);
  }
  sums.bottom = leastAround(bottoms, place.fz);
  sums.top = greatestAround(tops, place.fz);
  sums.calm = hn::Mul(leastAround(calms, place.fz), unit);
  return sums;
}

// Four rows of four texels, each `more` bytes from each offset on.
struct WideRows {
  SpreadRows lower, upper;  // the first two texels and the others
  HWY_INLINE SpreadRow row(int j) const {
    return {{lower.mean[j].first, lower.mean[j].second, upper.mean[j].first, upper.mean[j].second},
            {lower.spread[j].first, lower.spread[j].second, upper.spread[j].first,
             upper.spread[j].second}};
  }
};
template <DeviceType kType>
HWY_INLINE WideRows wideRowsAt(const KernelBox& box, VI offset, const int64_t (&more)[4]) {
  if constexpr (kType == DeviceType::kU8) {
    // The four texels of a row are eight bytes: one load in place of two.
    const std::byte* from[4] = {box.texels + more[0], box.texels + more[1], box.texels + more[2],
                                box.texels + more[3]};
    Wide wide[4];
    wideOfEach(from, offset, wide);
    WideRows rows;
    for (int j = 0; j < 4; ++j) {
      rows.lower.setPairs(j, wide[j].first);
      rows.upper.setPairs(j, wide[j].second);
    }
    return rows;
  } else {
    const auto two = static_cast<int64_t>(2 * box.stride[0]);
    return {spreadRowsAt<kType>(box, offset, more),
            spreadRowsAt<kType>(box, offset,
                                {more[0] + two, more[1] + two, more[2] + two, more[3] + two})};
  }
}
template <DeviceType kType>
HWY_INLINE WideSums wideSumsWithMargin(const KernelFrame& frame, const KernelBox& box,
                                       const Place& place) {
  const auto x = static_cast<int64_t>(box.stride[0]), y = static_cast<int64_t>(box.stride[1]),
             z = static_cast<int64_t>(box.stride[2]);
  const V first = texelsFrom<kType>(box.texels, place.offset);
  WideRows rows;
  return wideSums<kType>(frame, place, first, [&](int j, int k) {
    if (j == 0) {
      const int64_t plane = (k - 1) * z - x;
      rows = wideRowsAt<kType>(box, place.offset, {plane - y, plane, plane + y, plane + 2 * y});
    }
    return rows.row(j);
  });
}
// Beyond the chunk its outermost texels continue.
template <DeviceType kType>
HWY_NOINLINE WideSums wideSumsWithoutMargin(const KernelFrame& frame, const KernelBox& box, V3 at,
                                            Place place) {
  const FourOffsets x = offsetsAround(box, hn::Sub(at.x, place.fx), 0),
                    y = offsetsAround(box, hn::Sub(at.y, place.fy), 1),
                    z = offsetsAround(box, hn::Sub(at.z, place.fz), 2);
  const auto second = static_cast<int64_t>(box.stride[0]) / 2;
  const VI cell = hn::Add(x.of[1], hn::Add(y.of[1], z.of[1]));
  return wideSums<kType>(frame, place, texelsFrom<kType>(box.texels, cell), [&](int j, int k) {
    SpreadRow row;
    for (int i = 0; i < 4; ++i) {
      const VI offset = hn::Add(x.of[i], hn::Add(y.of[j], z.of[k]));
      row.mean[i] = texelsFrom<kType>(box.texels, offset);
      row.spread[i] = texelsFrom<kType>(box.texels + second, offset);
    }
    return row;
  });
}

// See rough_light.h: the slopes from texel to texel along each axis, what counts of their square,
// and the share of that whose light is seen. `square`: what counts of the square of the spread, as
// spreadAt() returns it; `noise`: the same of the least spread.
struct WideSlopes {
  V3 slopes;
  V here, seen, square, noise;
};
template <DeviceType kType>
HWY_NOINLINE WideSlopes wideSlopesAt(const KernelFrame& frame, const KernelBox& box, V3 at,
                                     Place place, V square) {
  const WideSums sums = box.has_margin ? wideSumsWithMargin<kType>(frame, box, place)
                                       : wideSumsWithoutMargin<kType>(frame, box, at, place);
  const auto number = [](double n) { return all(static_cast<float>(n)); };
  const V one = all(1.0F), none = hn::Zero(F());
  const V variance = hn::Max(hn::NegMulAdd(sums.mean, sums.mean, sums.squares), none);
  const V even = squareOf(sums.slopes);

  const V height = hn::Max(hn::Sub(sums.top, sums.bottom), number(kLeastHeight));
  const V part = hn::Min(
      one, hn::Max(hn::Div(hn::Sub(sums.mean, sums.bottom), height), number(kLeastPart)));
  const V product = hn::Max(hn::Mul(part, hn::Sub(one, part)), number(kLeastProduct));
  const V of_edge = hn::Div(variance, hn::Mul(hn::Mul(height, height), product));
  const V sharp = hn::Min(one, hn::Max(none, hn::Mul(hn::Sub(of_edge, number(kSoftShare)),
                                                     number(1 / (kSharpShare - kSoftShare)))));
  const V layer = hn::Div(hn::Mul(hn::Sqrt(even), all(box.edge_texels)), height);
  const auto ifSharp = [&](V wanted, V otherwise) {
    return hn::MulAdd(sharp, hn::Sub(wanted, otherwise), otherwise);
  };
  const V narrow = hn::Max(ifSharp(hn::Min(one, layer), one), number(kLeastLayer));
  const V seen = ifSharp(hn::Min(one, hn::Div(layer, hn::Add(part, part))), one);

  const V own = hn::MulAdd(number(kEvenPart), even, hn::Mul(number(kOwnPart), square));
  const V share = hn::Min(one, hn::Div(own, hn::Max(variance, all(1e-12F))));
  const V here = ifSharp(one, hn::Mul(share, hn::Mul(share, share)));
  const V most = hn::NegMulAdd(number(kEdgePart), even, hn::Mul(all(4.0F), variance));
  const V counted = hn::Min(square, hn::Max(most, none));
  const V still = hn::Min(counted, hn::Mul(sums.calm, sums.calm));
  const V unit = all(frame.spread_unit);
  WideSlopes wide{{hn::Mul(unit, sums.slopes.x), hn::Mul(unit, sums.slopes.y),
                   hn::Mul(unit, sums.slopes.z)},
                  hn::Div(here, hn::Mul(narrow, narrow)),
                  seen,
                  counted,
                  hn::Max(none, hn::NegMulAdd(number(kSlopePart / kSpreadPart), even, still))};
  if constexpr (kType == DeviceType::kF32) {
    const M is_none = isNoNumber(sums.least);
    if (hn::AllFalse(F(), is_none)) return wide;
    const V3 near = differencesWithoutMargin<kType, true>(box, at);
    wide = {{hn::IfThenElse(is_none, near.x, wide.slopes.x),
             hn::IfThenElse(is_none, near.y, wide.slopes.y),
             hn::IfThenElse(is_none, near.z, wide.slopes.z)},
            hn::IfThenElse(is_none, one, wide.here),
            hn::IfThenElse(is_none, one, wide.seen),
            hn::IfThenElse(is_none, square, wide.square),
            hn::IfThenElse(is_none, none, wide.noise)};
  }
  return wide;
}
