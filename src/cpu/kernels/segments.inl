// Pre-integration: the colours of all values between two, see IntegratedLook. Included once a
// target.

// A value's place among the entries.
HWY_INLINE V placeAmong(const KernelFrame& frame, V value) {
  // Bounded, so that single precision keeps the fraction of the place.
  const V most = all(kMostEntriesBeyond);
  return hn::Min(
      hn::Max(hn::MulAdd(value, all(frame.entry_scale), all(frame.entry_offset)), hn::Neg(most)),
      most);
}

// The sums below a place: those below the entry before it, and the part of their growth up to the
// next entry that lies below the place.
struct SumsAt {
  VI below[4];
  V part[4];
};
HWY_INLINE SumsAt sumsAt(const KernelFrame& frame, V place) {
  SumsAt sums;
  const V first = hn::Min(hn::Max(hn::Floor(place), hn::Zero(F())), all(frame.sums_last - 1));
  const V past = hn::Sub(place, first);
  const auto* base = reinterpret_cast<const std::byte*>(frame.sums);
  const VI offset = hn::ShiftLeft<4>(wholeOf(first));
  const Quad lower = quadAt(base, offset), upper = quadAt(base + 4 * sizeof(int32_t), offset);
  for (int c = 0; c < 4; ++c) {
    sums.below[c] = hn::BitCast(I(), lower.of[c]);
    // Whole numbers: the difference is exact even if it is small beside both sums.
    const V growth = hn::ConvertTo(F(), hn::Sub(hn::BitCast(I(), upper.of[c]), sums.below[c]));
    sums.part[c] = hn::Mul(past, growth);
  }
  return sums;
}

// A placeholder that is never read.
HWY_INLINE SumsAt noSums() {
  const V none = hn::Zero(F());
  const VI nothing = hn::Zero(I());
  return {{nothing, nothing, nothing, nothing}, {none, none, none, none}};
}

// Extinction times red, green, blue and 1.
struct Extinction {
  V of[4];
};

// The same of one value, see IntegratedLook::one_value.
HWY_INLINE Extinction oneValueAt(const KernelFrame& frame, V place) {
  const V zero = hn::Zero(F());
  place = hn::Min(hn::Max(place, zero), all(frame.sums_last));
  const V first = hn::Min(hn::Floor(place), all(frame.sums_last - 1));
  const V past = hn::Mul(hn::Sub(hn::Sub(place, first), all(frame.near_entry)),
                         all(1 / (1 - 2 * frame.near_entry)));
  const V part = hn::Min(hn::Max(past, zero), all(1.0F));
  const auto* base = reinterpret_cast<const std::byte*>(frame.sums_alone);
  const VI offset = hn::ShiftLeft<4>(wholeOf(first));
  const Quad lower = quadAt(base, offset), upper = quadAt(base + 4 * sizeof(int32_t), offset);
  Extinction result;
  for (int c = 0; c < 4; ++c) {
    const V before = hn::ConvertTo(F(), hn::BitCast(I(), lower.of[c]));
    const V after = hn::ConvertTo(F(), hn::BitCast(I(), upper.of[c]));
    result.of[c] = hn::MulAdd(part, after, hn::NegMulAdd(part, before, before));
  }
  return result;
}

// The places of a segment's ends, and the sums below the front one if they are known.
struct Segment {
  V front, back;
  SumsAt sums;
  bool has_sums = false;

  V middle() const { return hn::Mul(all(0.5F), hn::Add(front, back)); }
};

// The mean of the lanes that show. Leaves the sums of the segment behind, if it makes them.
HWY_INLINE Extinction meanOf(const KernelFrame& frame, M shows, Segment& segment) {
  const V way = hn::Sub(segment.back, segment.front);
  // One value, or values beyond one end of the table, which all look the same.
  const M even = hn::And(
      shows, hn::Or(hn::Lt(hn::Abs(way), all(frame.one_value)),
                    hn::Or(hn::Ge(hn::Min(segment.front, segment.back), all(frame.sums_last)),
                           hn::Le(hn::Max(segment.front, segment.back), hn::Zero(F())))));
  if (hn::AllFalse(F(), hn::AndNot(even, shows))) {
    segment.has_sums = false;
    // One value looks as the entries around it do, not as a mean over a range, see IntegratedLook.
    return oneValueAt(frame, segment.middle());
  }
  if (!segment.has_sums) segment.sums = sumsAt(frame, segment.front);
  const SumsAt front = std::exchange(segment.sums, sumsAt(frame, segment.back));
  segment.has_sums = true;
  const SumsAt& back = segment.sums;
  const V one = all(1.0F);
  const M is_way = hn::Gt(hn::Abs(way), hn::Zero(F()));
  // Lanes without a way are replaced below, but must not divide by 0.
  const V inverse = hn::Div(one, hn::IfThenElse(is_way, way, one));
  Extinction mean;
  for (int c = 0; c < 4; ++c) {
    const V sum = hn::Add(hn::ConvertTo(F(), hn::Sub(back.below[c], front.below[c])),
                          hn::Sub(back.part[c], front.part[c]));
    mean.of[c] = hn::Mul(sum, inverse);
  }
  if (!hn::AllFalse(F(), even)) {
    const Extinction alone = oneValueAt(frame, segment.middle());
    for (int c = 0; c < 4; ++c) mean.of[c] = hn::IfThenElse(even, alone.of[c], mean.of[c]);
  }
  return mean;
}

// The colour, not premultiplied, and the exponent of what passes: 2^-a of slice_length, or of a
// unit length with factors.
HWY_INLINE Color extinctionColor(const KernelFrame& frame, const Extinction& mean) {
  const V zero = hn::Zero(F()), one = all(1.0F);
  const V extinction = hn::Max(mean.of[3], zero);
  // An extinction of 0 has no colour, and must not divide by 0.
  const V to_color = hn::Div(one, hn::Max(extinction, all(1e-20F)));
  const auto color = [&](V channel) {
    return hn::Min(hn::Max(hn::Mul(channel, to_color), zero), one);
  };
  return {color(mean.of[0]), color(mean.of[1]), color(mean.of[2]),
          hn::Mul(extinction, all(frame.sums_unit))};
}
