// Surfaces where values pass a level, see FrameSetup::has_surfaces. Included once a target.

// The values at both ends of a slice's way, and whether the slice is the first or last of the box.
struct Stretch {
  V front, back;
  M is_first, is_last;
};

// Whether the values pass the level, or come so close to it that this box has to say so.
HWY_INLINE M meetsLevel(const KernelFrame& frame, const Stretch& stretch, V level) {
  const V tie = all(frame.surface_tie);
  const M passes = hn::Xor(hn::Ge(stretch.front, level), hn::Ge(stretch.back, level));
  const V front_off = hn::Abs(hn::Sub(stretch.front, level));
  const M of_last_box =
      hn::And(stretch.is_first, hn::Lt(front_off, hn::Mul(tie, all(0.5F))));
  const M at_end = hn::And(
      stretch.is_last, hn::And(hn::Lt(hn::Abs(hn::Sub(stretch.back, level)), tie),
                               hn::Ge(front_off, tie)));
  return hn::Or(hn::AndNot(of_last_box, passes), at_end);
}
HWY_INLINE M meetsAny(const KernelFrame& frame, const Stretch& stretch) {
  M meets = meetsLevel(frame, stretch, all(frame.level[0]));
  for (int i = 1; i < frame.surfaces; ++i)
    meets = hn::Or(meets, meetsLevel(frame, stretch, all(frame.level[static_cast<size_t>(i)])));
  return meets;
}

// The surface that each ray meets as the nth: the levels ascend along some rays and descend along
// others.
struct MetSurface {
  V level;
  Color color;  // premultiplied
};
HWY_INLINE MetSurface surfaceOf(const KernelFrame& frame, M up, int n) {
  const auto lower = static_cast<size_t>(n), upper = static_cast<size_t>(frame.surfaces - 1 - n);
  const auto either = [&](const std::array<float, kMostSurfaces>& of) {
    return hn::IfThenElse(up, all(of[lower]), all(of[upper]));
  };
  const V opacity = either(frame.surface_opacity);
  const auto& [red, green, blue] = frame.surface_rgb;
  return {either(frame.level),
          {hn::Mul(either(red), opacity), hn::Mul(either(green), opacity),
           hn::Mul(either(blue), opacity), opacity}};
}

// Apart, since few samples meet a surface: loops over many stay small.
template <DeviceType kType>
HWY_NOINLINE V valueThere(const KernelBox& box, const Cells& stored, const V3& at) {
  return valueAt<kType>(box, placeAt(stored, clamped(stored, at)));
}

// The search for a level: parts of the way from slice to slice, 0 to 1, and the values there.
struct Search {
  V level, from, value_from, value_end;
  V up;  // of all bits if the values rise to the end
};
// The part of the way at which the values pass the level: halved six times, and once more where a
// straight line between the two last values passes it.
template <DeviceType kType, class PlaceAlong>
HWY_NOINLINE V crossing(const KernelBox& box, const Cells& stored, const PlaceAlong& placeAlong,
                      const Search& search) {
  constexpr int kHalvings = 6;
  const M up = hn::MaskFromVec(search.up);
  V lo = search.from, hi = all(1.0F), value_lo = search.value_from, value_hi = search.value_end;
  for (int i = 0; i < kHalvings; ++i) {
    const V middle = hn::Mul(all(0.5F), hn::Add(lo, hi));
    const V value = valueThere<kType>(box, stored, placeAlong(middle));
    const M is_before = hn::Not(hn::Xor(hn::Lt(value, search.level), up));
    lo = hn::IfThenElse(is_before, middle, lo);
    value_lo = hn::IfThenElse(is_before, value, value_lo);
    hi = hn::IfThenElse(is_before, hi, middle);
    value_hi = hn::IfThenElse(is_before, value_hi, value);
  }
  const V way = hn::Sub(value_hi, value_lo);
  const M is_flat = hn::Lt(hn::Abs(way), all(1e-30F));
  const V part = hn::Div(hn::Sub(search.level, value_lo), hn::IfThenElse(is_flat, all(1.0F), way));
  const V clamped_part = hn::Min(hn::Max(part, hn::Zero(F())), all(1.0F));
  return hn::MulAdd(clamped_part, hn::Sub(hi, lo), lo);
}

// The colour of a surface at a place, lit if the frame is.
template <DeviceType kType>
HWY_NOINLINE Color surfaceColor(const KernelFrame& frame, const KernelBox& box, const Cells& stored,
                              const V3& at, const MetSurface& surface) {
  if (!frame.lit) return surface.color;
  const V half = all(0.5F);
  V3 difference{hn::Zero(F()), hn::Zero(F()), hn::Zero(F())};
  for (int corner = 0; corner < 8; ++corner) {
    const bool x = (corner & 1) != 0, y = (corner & 2) != 0, z = (corner & 4) != 0;
    const V3 there{x ? hn::Add(at.x, half) : hn::Sub(at.x, half),
                   y ? hn::Add(at.y, half) : hn::Sub(at.y, half),
                   z ? hn::Add(at.z, half) : hn::Sub(at.z, half)};
    V value = valueThere<kType>(box, stored, there);
    // A corner that is no number tells nothing of the slope.
    if (kType == DeviceType::kF32)
      value = hn::IfThenElse(isNoNumber(value), surface.level, value);
    // Values next to the level, so that nothing is lost of small differences.
    value = hn::Mul(all(0.25F), hn::Sub(value, surface.level));
    difference.x = x ? hn::Add(difference.x, value) : hn::Sub(difference.x, value);
    difference.y = y ? hn::Add(difference.y, value) : hn::Sub(difference.y, value);
    difference.z = z ? hn::Add(difference.z, value) : hn::Sub(difference.z, value);
  }
  return shaded(frame, surface.color, gradientOf(box, difference), 0);
}

// The colour of a slice over a part of its way.
HWY_INLINE Color partOf(const Color& color, V part) {
  const V opacity = corrected(color.a, part);
  const V scale = hn::Div(opacity, hn::Max(color.a, all(1e-20F)));
  return {hn::Mul(color.r, scale), hn::Mul(color.g, scale), hn::Mul(color.b, scale), opacity};
}
