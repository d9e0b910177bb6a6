// The colour of a value: look-up, factors of gradients. Included once a target.

struct Color {
  V r, g, b, a;
};

// exp(x), and 2^x of it.
HWY_INLINE V powerOfTwo(V x) { return hn::Exp(F(), hn::Mul(x, all(0.693147180559945F))); }

HWY_INLINE Color entryAt(const float* entries, VI entry) {
  const Quad rgba = quadAt(reinterpret_cast<const std::byte*>(entries), hn::ShiftLeft<4>(entry));
  return {rgba.of[0], rgba.of[1], rgba.of[2], rgba.of[3]};
}

// See packed_entries.h.
HWY_INLINE Color packedEntryAt(const KernelFrame& frame, VI entry) {
  const auto [first, second] = wideAt(reinterpret_cast<const std::byte*>(frame.packed_entries),
                                      hn::ShiftLeft<3>(entry));
  const VI mask = hn::Set(I(), 0xFFFF << kPackedShift);
  constexpr int kDown = 16 - kPackedShift;
  const V unit = all(frame.color_unit);
  return {
      hn::Mul(unit, hn::BitCast(F(), hn::And(hn::ShiftLeft<kPackedShift>(first), mask))),
      hn::Mul(unit, hn::BitCast(F(), hn::And(hn::ShiftRight<kDown>(first), mask))),
      hn::Mul(unit, hn::BitCast(F(), hn::And(hn::ShiftLeft<kPackedShift>(second), mask))),
      hn::Mul(all(frame.opacity_unit),
              hn::BitCast(F(), hn::And(hn::ShiftRight<kDown>(second), mask)))};
}

// The entry of a value, from 0 to last_entry.
HWY_INLINE V entryOf(const KernelFrame& frame, V value) {
  const V at = hn::MulAdd(value, all(frame.entry_scale), all(frame.entry_offset));
  return hn::Min(hn::Max(at, hn::Zero(F())), all(frame.last_entry));
}

HWY_INLINE Color rampColor(const ColorRamp& ramp, V entry) {
  // The nearest entry, as of a table.
  const V from_first = hn::Sub(hn::Floor(hn::Add(entry, all(0.5F))), all(ramp.first));
  const V at = hn::MulAdd(from_first, all(ramp.scale), all(ramp.offset));
  const V t = hn::Min(hn::Max(at, hn::Zero(F())), all(1.0F));
  const auto& [first, second, third] = ramp.curve;
  const V a = hn::Mul(t, hn::MulAdd(t, hn::MulAdd(t, all(third), all(second)), all(first)));
  const V factor = ramp.is_premultiplied ? a : all(1.0F);
  return {hn::Mul(factor, all(ramp.rgb[0])), hn::Mul(factor, all(ramp.rgb[1])),
          hn::Mul(factor, all(ramp.rgb[2])), a};
}

HWY_INLINE Color colorAt(const KernelFrame& frame, V entry) {
  if (frame.ramp != nullptr) return rampColor(*frame.ramp, entry);
  if (!frame.interpolates) {
    const VI nearest = wholeOf(hn::Add(entry, all(0.5F)));
    return packedEntryAt(frame, nearest);
  }
  const VI first = hn::ConvertTo(I(), entry);
  const VI last = hn::Set(I(), static_cast<int32_t>(frame.last_entry));
  const Color a = entryAt(frame.entries, first);
  const Color b = entryAt(frame.entries, hn::Min(hn::Add(first, hn::Set(I(), 1)), last));
  const V part = hn::Sub(entry, hn::ConvertTo(F(), first)), rest = hn::Sub(all(1.0F), part);
  return {between(a.r, b.r, part, rest), between(a.g, b.g, part, rest),
          between(a.b, b.b, part, rest), between(a.a, b.a, part, rest)};
}

// The part, 0 to 1, that a sample takes in modes other than composite.
HWY_INLINE V partAt(const KernelFrame& frame, V entry) {
  const VI first = hn::ConvertTo(I(), entry);
  const VI last = hn::Set(I(), static_cast<int32_t>(frame.last_entry));
  const VI second = hn::Min(hn::Add(first, hn::Set(I(), 1)), last);
  const V part = hn::Sub(entry, hn::ConvertTo(F(), first));
  return between(floatsAt(frame.entries + 3, hn::ShiftLeft<2>(first)),
                 floatsAt(frame.entries + 3, hn::ShiftLeft<2>(second)), part,
                 hn::Sub(all(1.0F), part));
}

// Linear between rows and entries, constant beyond.
HWY_INLINE V factorAt(const KernelFrame& frame, V magnitude, V entry) {
  V row = hn::Zero(F());
  for (int i = 0; i + 1 < frame.rows; ++i) {
    const V passed = hn::Mul(hn::Sub(magnitude, all(frame.row_starts[i])),
                             all(frame.row_growths[i]));
    row = hn::Add(row, hn::Min(hn::Max(passed, hn::Zero(F())), all(1.0F)));
  }
  const int entries = frame.factor_entries;
  const VI row_lo = hn::ConvertTo(I(), row);
  const VI row_hi = hn::Min(hn::Add(row_lo, hn::Set(I(), 1)), hn::Set(I(), frame.rows - 1));
  const V row_part = hn::Sub(row, hn::ConvertTo(F(), row_lo));
  const V row_rest = hn::Sub(all(1.0F), row_part);
  const VI width = hn::Set(I(), entries);
  if (entries == 1)
    return between(floatsAt(frame.factors, row_lo),
                   floatsAt(frame.factors, row_hi), row_part, row_rest);
  const VI lo = hn::ConvertTo(I(), entry);
  const VI hi = hn::Min(hn::Add(lo, hn::Set(I(), 1)), hn::Set(I(), entries - 1));
  const V part = hn::Sub(entry, hn::ConvertTo(F(), lo)), rest = hn::Sub(all(1.0F), part);
  const VI from = hn::Mul(row_lo, width), next = hn::Mul(row_hi, width);
  const V first = between(floatsAt(frame.factors, hn::Add(from, lo)),
                          floatsAt(frame.factors, hn::Add(from, hi)), part, rest);
  const V second = between(floatsAt(frame.factors, hn::Add(next, lo)),
                           floatsAt(frame.factors, hn::Add(next, hi)), part, rest);
  return between(first, second, row_part, row_rest);
}

// The opacity of `lengths` unit lengths from the opacity of one.
HWY_INLINE V corrected(V opacity, V lengths) {
  // The logarithm of 0 is not asked for: opaque lanes are replaced below.
  const V clear = hn::Max(hn::Sub(all(1.0F), opacity), all(1e-37F));
  const V left = hn::Exp(F(), hn::Mul(lengths, hn::Log(F(), clear)));
  return hn::IfThenElse(hn::Lt(opacity, all(1.0F)), hn::Sub(all(1.0F), left), all(1.0F));
}

// The row of the square of a spread: the rows that spreads have are from 1 on, and below it their
// colours mix with the colour of a texel without spread.
HWY_INLINE V expectedRow(const KernelFrame& frame, V square) {
  return hn::Mul(hn::Sqrt(hn::Sqrt(square)), all(static_cast<float>(frame.expected_rows)));
}
// The colour of a mean and the square of its spread (SpreadValue), premultiplied, for a way of `lengths` unit lengths whose
// opacity is multiplied by `factor` first: see ExpectedLook. `exact` is the colour without spread.
HWY_INLINE Color expectedColor(const KernelFrame& frame, V value, V square, V factor, V lengths,
                               const Color& exact) {
  const V zero = hn::Zero(F()), one = all(1.0F);
  const V row = expectedRow(frame, square);
  const V last_row = all(static_cast<float>(frame.expected_rows - 1));
  const V last_entry = all(static_cast<float>(frame.expected_entries - 1));
  const V at_row = hn::Min(hn::Max(hn::Sub(row, one), zero), last_row);
  const V at_entry = hn::Min(
      hn::Max(hn::MulAdd(value, all(frame.mean_scale), all(frame.mean_offset)), zero), last_entry);
  const V first_row = hn::Floor(at_row), first_entry = hn::Floor(at_entry);
  const V row_part = hn::Sub(at_row, first_row), row_rest = hn::Sub(one, row_part);
  const V part = hn::Sub(at_entry, first_entry), rest = hn::Sub(one, part);
  const V width = all(static_cast<float>(frame.expected_entries));
  const V next_row = hn::Min(hn::Add(first_row, one), last_row);
  const V next_entry = hn::Min(hn::Add(first_entry, one), last_entry);
  const auto* base = reinterpret_cast<const std::byte*>(frame.expected);
  const auto rowColor = [&](V in_row) {
    const Quad a = quadAt(base, hn::ShiftLeft<4>(wholeOf(hn::MulAdd(in_row, width, first_entry))));
    const Quad b = quadAt(base, hn::ShiftLeft<4>(wholeOf(hn::MulAdd(in_row, width, next_entry))));
    return Color{between(a.of[0], b.of[0], part, rest), between(a.of[1], b.of[1], part, rest),
                 between(a.of[2], b.of[2], part, rest), between(a.of[3], b.of[3], part, rest)};
  };
  const Color lower = rowColor(first_row), upper = rowColor(next_row);
  const V opacity = between(lower.a, upper.a, row_part, row_rest);
  const V a = corrected(hn::Mul(opacity, factor), lengths);
  const V scale = hn::Div(a, hn::Max(opacity, all(1e-20F)));
  const V weight = hn::Min(row, one), left = hn::Sub(one, weight);
  return {between(exact.r, hn::Mul(scale, between(lower.r, upper.r, row_part, row_rest)), weight,
                  left),
          between(exact.g, hn::Mul(scale, between(lower.g, upper.g, row_part, row_rest)), weight,
                  left),
          between(exact.b, hn::Mul(scale, between(lower.b, upper.b, row_part, row_rest)), weight,
                  left),
          between(exact.a, a, weight, left)};
}
