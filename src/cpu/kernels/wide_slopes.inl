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

// The same of texels that may be read with the bytes behind them.
template <DeviceType kType>
HWY_INLINE V firstTexels(const std::byte* base, VI offset) {
  const VI bytes = bytesAt(base, offset);
  if constexpr (kType == DeviceType::kF32)
    return hn::BitCast(F(), bytes);
  else
    return hn::ConvertTo(F(), hn::And(bytes, hn::Set(I(), kType == DeviceType::kU8 ? 255 : 65535)));
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

// How far the first and the last of four texels along an axis have become their neighbours: they do
// while the place moves from the middle between the second and the third to the farther one, so that
// the least and the greatest of the four do not jump from cell to cell.
struct AroundParts {
  V first, last;
};
HWY_INLINE AroundParts aroundParts(V part) {
  const V twice = hn::Add(part, part), one = all(1.0F), none = hn::Zero(F());
  return {hn::Max(none, hn::Sub(twice, one)), hn::Max(none, hn::Sub(one, twice))};
}
HWY_INLINE V outer(V end, V neighbour, V part) {
  return hn::MulAdd(part, hn::Sub(neighbour, end), end);
}

// The least and the greatest mean of some texels, and the least spread.
struct Extremes {
  V least, greatest, calm;
};
// Those of a row or a plane at an end of four, with its neighbour.
HWY_INLINE Extremes extremesOf(const Extremes& end, const Extremes& neighbour, V part) {
  return {hn::Min(outer(end.least, neighbour.least, part), neighbour.least),
          hn::Max(outer(end.greatest, neighbour.greatest, part), neighbour.greatest),
          hn::Min(outer(end.calm, neighbour.calm, part), neighbour.calm)};
}
HWY_INLINE Extremes extremesOf(const Extremes& lower, const Extremes& upper) {
  return {hn::Min(lower.least, upper.least), hn::Max(lower.greatest, upper.greatest),
          hn::Min(lower.calm, upper.calm)};
}
// Those of four along an axis; `at(i)` is called once each, in order.
template <class At>
HWY_INLINE Extremes extremesAlong(const AroundParts& parts, const At& at) {
  const Extremes first = at(0), second = at(1);
  const Extremes lower = extremesOf(first, second, parts.first);
  const Extremes third = at(2), last = at(3);
  return extremesOf(lower, extremesOf(last, third, parts.last));
}

// The sums over the 64 texels around a place.
struct WideSums {
  V3 slopes;
  V mean, squares;          // the weighted mean of the values and of their squares
  Extremes extremes;
  V least;                  // of the means, of floats
};
// `plane_of(k)` gives a function of j that returns row j of plane k. Values are shares of the volume's
// values, from the first texel of the cell on: squares of values may overflow, and small differences
// would be lost.
template <DeviceType kType, class PlaneOf>
HWY_INLINE WideSums wideSums(const KernelFrame& frame, const Place& place, V first,
                             const PlaneOf& plane_of) {
  const SobelWeights x = sobelWeights(place.fx), y = sobelWeights(place.fy),
                     z = sobelWeights(place.fz);
  const AroundParts x_parts = aroundParts(place.fx), y_parts = aroundParts(place.fy);
  const V none = hn::Zero(F()), unit = all(frame.spread_scale),
          half = all(0.5F * frame.spread_scale), origin = hn::Mul(first, unit);
  WideSums sums{{none, none, none}, none, none, {none, none, none}, first};
  Extremes planes[4];
  for (int k = 0; k < 4; ++k) {
    const auto row_of = plane_of(k);
    planes[k] = extremesAlong(y_parts, [&](int j) {
      const SpreadRow row = row_of(j);
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
      return extremesAlong(x_parts, [&](int i) {
        return Extremes{values[i], values[i], spreads[i]};
      });
    });
  }
  sums.extremes = extremesAlong(aroundParts(place.fz), [&](int k) { return planes[k]; });
  return sums;
}

// A row of four texels from `more` bytes from each offset on.
template <DeviceType kType>
HWY_INLINE SpreadRow wideRowAt(const KernelBox& box, VI offset, int64_t more) {
  const std::byte* from = box.texels + more;
  if constexpr (kType == DeviceType::kU16) {
    const Wide lower = wideAt(from, offset), upper = wideAt(from + 8, offset);
    const Pair texels[4] = {pairIn<kType>(lower.first), pairIn<kType>(lower.second),
                            pairIn<kType>(upper.first), pairIn<kType>(upper.second)};
    return {{texels[0].first, texels[1].first, texels[2].first, texels[3].first},
            {texels[0].second, texels[1].second, texels[2].second, texels[3].second}};
  } else {
    const Quad lower = quadAt(from, offset), upper = quadAt(from + 16, offset);
    return {{lower.of[0], lower.of[2], upper.of[0], upper.of[2]},
            {lower.of[1], lower.of[3], upper.of[1], upper.of[3]}};
  }
}
// Four rows of four texels, each `more` bytes from each offset on.
template <DeviceType kType>
struct WideRows {
  const KernelBox& box;
  VI offset;
  int64_t more[4];
  HWY_INLINE SpreadRow row(int j) const { return wideRowAt<kType>(box, offset, more[j]); }
};
// The four texels of a row are eight bytes: a mean, its spread, the next texel's, and so on. They stay
// bytes until they are used, since as numbers four rows are more than there are registers.
template <>
struct WideRows<DeviceType::kU8> {
  Wide rows[4];
  HWY_INLINE SpreadRow row(int j) const {
    const VI mask = hn::Set(I(), 255);
    const auto number = [&](VI bytes) { return hn::ConvertTo(F(), hn::And(bytes, mask)); };
    const auto [lower, upper] = rows[j];
    return {{number(lower), number(hn::ShiftRight<16>(lower)), number(upper),
             number(hn::ShiftRight<16>(upper))},
            {number(hn::ShiftRight<8>(lower)), number(hn::ShiftRight<24>(lower)),
             number(hn::ShiftRight<8>(upper)), number(hn::ShiftRight<24>(upper))}};
  }
};
template <DeviceType kType>
HWY_INLINE WideRows<kType> wideRowsAt(const KernelBox& box, VI offset, const int64_t (&more)[4]) {
  if constexpr (kType == DeviceType::kU8) {
    const std::byte* from[4] = {box.texels + more[0], box.texels + more[1], box.texels + more[2],
                                box.texels + more[3]};
    WideRows<kType> rows;
    wideOfEach(from, offset, rows.rows);
    return rows;
  } else {
    return {box, offset, {more[0], more[1], more[2], more[3]}};
  }
}
template <DeviceType kType>
HWY_INLINE WideSums wideSumsWithMargin(const KernelFrame& frame, const KernelBox& box,
                                       const Place& place) {
  const auto x = static_cast<int64_t>(box.stride[0]), y = static_cast<int64_t>(box.stride[1]),
             z = static_cast<int64_t>(box.stride[2]);
  const V first = firstTexels<kType>(box.texels, place.offset);
  return wideSums<kType>(frame, place, first, [&](int k) {
    const int64_t plane = (k - 1) * z - x;
    const int64_t more[4] = {plane - y, plane, plane + y, plane + 2 * y};
    return [rows = wideRowsAt<kType>(box, place.offset, more)](int j) { return rows.row(j); };
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
  return wideSums<kType>(frame, place, texelsFrom<kType>(box.texels, cell), [&](int k) {
    return [&, k](int j) {
      SpreadRow row;
      for (int i = 0; i < 4; ++i) {
        const VI offset = hn::Add(x.of[i], hn::Add(y.of[j], z.of[k]));
        row.mean[i] = texelsFrom<kType>(box.texels, offset);
        row.spread[i] = texelsFrom<kType>(box.texels + second, offset);
      }
      return row;
    };
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

  const auto& [bottom, top, calm] = sums.extremes;
  const V height = hn::Max(hn::Sub(top, bottom), number(kLeastHeight));
  const V part = hn::Min(
      one, hn::Max(hn::Div(hn::Sub(sums.mean, bottom), height), number(kLeastPart)));
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
  const V least_spread = hn::Mul(calm, all(frame.spread_scale));
  const V still = hn::Min(counted, hn::Mul(least_spread, least_spread));
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
