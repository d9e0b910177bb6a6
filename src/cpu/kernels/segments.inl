// Pre-integration: the colours of all values between two, see IntegratedLook. Included once a
// target.

// A value's place among the entries, and the sums below it: those below the entry before it, their
// growth up to the next entry, and the part of it up to the place.
struct SumsAt {
  V place;
  VI below[4];
  V growth[4], part[4];
};
HWY_INLINE SumsAt sumsAt(const KernelFrame& frame, V value) {
  const V most = all(kMostEntriesBeyond);
  SumsAt sums;
  sums.place = hn::Min(
      hn::Max(hn::MulAdd(value, all(frame.entry_scale), all(frame.entry_offset)), hn::Neg(most)),
      most);
  const V first =
      hn::Min(hn::Max(hn::Floor(sums.place), hn::Zero(F())), all(frame.sums_last - 1));
  const V past = hn::Sub(sums.place, first);
  const auto* base = reinterpret_cast<const std::byte*>(frame.sums);
  const VI offset = hn::ShiftLeft<4>(wholeOf(first));
  const Quad lower = quadAt(base, offset), upper = quadAt(base + 4 * sizeof(int32_t), offset);
  for (int c = 0; c < 4; ++c) {
    sums.below[c] = hn::BitCast(I(), lower.of[c]);
    sums.growth[c] = hn::ConvertTo(F(), hn::Sub(hn::BitCast(I(), upper.of[c]), sums.below[c]));
    sums.part[c] = hn::Mul(past, sums.growth[c]);
  }
  return sums;
}

// A placeholder that is never read.
HWY_INLINE SumsAt noSums() {
  const V none = hn::Zero(F());
  const VI nothing = hn::Zero(I());
  return {none,
          {nothing, nothing, nothing, nothing},
          {none, none, none, none},
          {none, none, none, none}};
}

// The mean of the values from one place to another: colour, not premultiplied, and the exponent of
// what passes: 2^-a of slice_length, or of a unit length with factors.
HWY_INLINE Color segmentColor(const KernelFrame& frame, const SumsAt& front, const SumsAt& back) {
  const V way = hn::Sub(back.place, front.place), zero = hn::Zero(F()), one = all(1.0F);
  // One value, or values beyond one end of the table, which all look the same.
  const M even =
      hn::Or(hn::Lt(hn::Abs(way), all(kOneEntry)),
             hn::Or(hn::Ge(hn::Min(front.place, back.place), all(frame.sums_last)),
                    hn::Le(hn::Max(front.place, back.place), zero)));
  const V inverse = hn::Div(one, hn::IfThenElse(even, one, way));
  V mean[4];
  for (int c = 0; c < 4; ++c) {
    const V sum = hn::Add(hn::ConvertTo(F(), hn::Sub(back.below[c], front.below[c])),
                          hn::Sub(back.part[c], front.part[c]));
    mean[c] = hn::IfThenElse(even, hn::Mul(all(0.5F), hn::Add(front.growth[c], back.growth[c])),
                             hn::Mul(sum, inverse));
  }
  const V extinction = hn::Max(mean[3], zero);
  const V to_color = hn::Div(one, hn::Max(extinction, all(1e-20F)));
  const auto color = [&](V channel) {
    return hn::Min(hn::Max(hn::Mul(channel, to_color), zero), one);
  };
  return {color(mean[0]), color(mean[1]), color(mean[2]),
          hn::Mul(extinction, all(frame.sums_unit))};
}
