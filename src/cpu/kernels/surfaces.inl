// Surfaces where values pass a level, see FrameSetup::has_surfaces, and how a Passage meets them.
// Included once a target.

// The values at both ends of a slice's way.
struct Stretch {
  V front, back;
};

HWY_INLINE M meetsLevel(const Stretch& stretch, V level) {
  return hn::Xor(hn::Ge(stretch.front, level), hn::Ge(stretch.back, level));
}
HWY_INLINE M meetsAny(const KernelFrame& frame, const Stretch& stretch) {
  M meets = meetsLevel(stretch, all(frame.level[0]));
  for (int i = 1; i < frame.surfaces; ++i)
    meets = hn::Or(meets, meetsLevel(stretch, all(frame.level[static_cast<size_t>(i)])));
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

// A surface lies where the values pass its level; in chunks with spreads the means are the values.
// valueThere() is a call, since few samples meet a surface: loops over many stay small.
template <DeviceType kType, Shading kShading>
HWY_INLINE V surfaceValueAt(const KernelBox& box, const Place& place) {
  if constexpr (hasSpreads(kShading))
    return meanAt<kType>(box, place);
  else
    return valueAt<kType>(box, place);
}
template <DeviceType kType, Shading kShading>
HWY_NOINLINE V valueThere(const KernelBox& box, const Cells& stored, const V3& at) {
  return surfaceValueAt<kType, kShading>(box, placeAt(stored, clamped(stored, at)));
}

// The search for a level: parts of the way from slice to slice, 0 to 1, and the values there.
struct Search {
  V level, from, value_from, value_end;
  V up;  // of all bits if the values rise to the end
};
// The part of the way at which the values pass the level: halved six times, and once more where a
// straight line between the two last values passes it.
template <DeviceType kType, Shading kShading, class PlaceAlong>
HWY_NOINLINE V crossing(const KernelBox& box, const Cells& stored, const PlaceAlong& placeAlong,
                      const Search& search) {
  constexpr int kHalvings = 6;
  const M up = hn::MaskFromVec(search.up);
  V lo = search.from, hi = all(1.0F), value_lo = search.value_from, value_hi = search.value_end;
  for (int i = 0; i < kHalvings; ++i) {
    const V middle = hn::Mul(all(0.5F), hn::Add(lo, hi));
    const V value = valueThere<kType, kShading>(box, stored, placeAlong(middle));
    // Lanes whose values descend look for the level from above.
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

// The colour of a slice over a part of its way.
HWY_INLINE Color partOf(const Color& color, V part) {
  const V opacity = corrected(color.a, part);
  const V scale = hn::Div(opacity, hn::Max(color.a, all(1e-20F)));
  return {hn::Mul(color.r, scale), hn::Mul(color.g, scale), hn::Mul(color.b, scale), opacity};
}

// A surface's colour with the box's share of it, see LevelFade.
HWY_NOINLINE Color fadedIn(const KernelBox& box, const V3& at, const Color& color) {
  const V none = hn::Zero(F()), one = all(1.0F);
  V share = one;
  for (size_t i = 0; i < 2; ++i) {
    const Float3 &start = box.fade_start[i], &slope = box.fade_slope[i];
    const auto factor = [&](V texel, size_t a) {
      const V ramp = hn::MulAdd(texel, all(slope[a]), all(start[a]));
      return hn::Min(hn::Max(ramp, none), one);
    };
    share = hn::Mul(share, hn::Mul(factor(at.x, 0), hn::Mul(factor(at.y, 1), factor(at.z, 2))));
  }
  return partOf(color, share);
}

// The colour of a surface at a place, lit if the frame is.
template <DeviceType kType, Shading kShading>
HWY_NOINLINE Color surfaceColor(const KernelFrame& frame, const KernelBox& box, const Cells& stored,
                              const V3& at, const MetSurface& surface) {
  const Color color = box.fades ? fadedIn(box, at, surface.color) : surface.color;
  if (!frame.lit) return color;
  const V half = all(0.5F);
  V3 difference{hn::Zero(F()), hn::Zero(F()), hn::Zero(F())};
  for (int corner = 0; corner < 8; ++corner) {
    const bool x = (corner & 1) != 0, y = (corner & 2) != 0, z = (corner & 4) != 0;
    const V3 there{x ? hn::Add(at.x, half) : hn::Sub(at.x, half),
                   y ? hn::Add(at.y, half) : hn::Sub(at.y, half),
                   z ? hn::Add(at.z, half) : hn::Sub(at.z, half)};
    V value = valueThere<kType, kShading>(box, stored, there);
    // A corner that is no number tells nothing of the slope.
    if (kType == DeviceType::kF32)
      value = hn::IfThenElse(isNoNumber(value), surface.level, value);
    // Values next to the level, so that nothing is lost of small differences.
    value = hn::Mul(all(0.25F), hn::Sub(value, surface.level));
    difference.x = x ? hn::Add(difference.x, value) : hn::Sub(difference.x, value);
    difference.y = y ? hn::Add(difference.y, value) : hn::Sub(difference.y, value);
    difference.z = z ? hn::Add(difference.z, value) : hn::Sub(difference.z, value);
  }
  return shaded(frame, box, at, color, gradientOf(box, difference), 0);
}

struct SliceColor {
  Color color;
  M shows;
};

// A surface that rays meet in a slice.
struct Met {
  V part;  // of the slice's way up to there; beyond the end for rays that do not meet it
  V hit;   // of all bits for those that do
  Color color;
};
// Those of a slice: of the box, and of the boxes that join it.
struct AllMet {
  int count = 0;
  std::array<Met, kMostSurfaces * (1 + kMostJoined)> of;

  // Puts those that each ray meets first in front.
  HWY_NOINLINE void sort() {
    for (int i = 1; i < count; ++i)
      for (int j = i; j > 0; --j) {
        Met &a = of[static_cast<size_t>(j - 1)], &b = of[static_cast<size_t>(j)];
        const M turns = hn::Lt(b.part, a.part);
        if (hn::AllFalse(F(), turns)) break;
        const auto exchange = [turns](V& first, V& second) {
          const V before = first;
          first = hn::IfThenElse(turns, second, first);
          second = hn::IfThenElse(turns, before, second);
        };
        exchange(a.part, b.part);
        exchange(a.hit, b.hit);
        exchange(a.color.r, b.color.r);
        exchange(a.color.g, b.color.g);
        exchange(a.color.b, b.color.b);
        exchange(a.color.a, b.color.a);
      }
  }
};

// The way of a packet through a box that joins another one. Slices count as those of that one do.
struct JoinedWay {
  const KernelBox* box;
  V3 first, pace;
  V from, end;    // slices in the box
  float farther;  // from slices of the other box to those of this one
  // The value at the end of the last slice, if it is known.
  V front;
  bool has_front;
};

// The value half a slice before slice k of the box: neighbouring boxes find the same at the place
// that they share, see FrameSetup::has_surfaces.
template <DeviceType kType, Shading kShading>
HWY_INLINE V Passage<kType, kShading>::sharedEndAt(V k, const Cells& stored) const {
  const V turn = hn::Add(k, all(box.first_slice));
  const V grid = all(kPlaceGrid), cell = all(1.0F / kPlaceGrid);
  const auto localAt = [&](size_t axis, V origin, V step) {
    // Rounded to a grid that both boxes share, so that both find the same place, whatever their
    // corner.
    const V place = hn::Round(hn::Mul(roundedMulAdd(turn, step, origin), grid));
    return hn::Sub(hn::Mul(place, cell), all(box.corner[axis]));
  };
  const auto& [from, way] = places;
  const V3 voxels{localAt(0, from.x, way.x), localAt(1, from.y, way.y), localAt(2, from.z, way.z)};
  return surfaceValueAt<kType, kShading>(
      box, placeAt(stored, clamped(stored, texelsAt(box, voxels))));
}

// The rays of `within` that may meet a surface between these values.
template <DeviceType kType>
HWY_INLINE M meetingAmong(const KernelFrame& frame, M within, const Stretch& stretch) {
  M numbers = within;
  // A stretch with an end that is no number meets no surface.
  if constexpr (kType == DeviceType::kF32)
    numbers = hn::AndNot(isNoNumber(hn::Min(stretch.front, stretch.back)), within);
  return hn::And(numbers, meetsAny(frame, stretch));
}

// Slices [k, end), each with the surfaces on its way.
template <DeviceType kType, Shading kShading>
HWY_INLINE void Passage<kType, kShading>::goBySurfaces(V k, V end, bool leaps, Pixels& pixels,
                                                     JoinedWay* joined, int joined_count) {
  const BrickWay way = leaps ? brickWay(box, first, pace) : noBrickWay();
  const Cells stored = storedCells(box);
  const V one = all(1.0F);
  V front = k;
  bool has_front = false;
  AllMet met;
  for (;;) {
    bool leapt = false;
    const int turns = turnsFrom(k, end, way, leaps, leapt);
    if (turns == 0) break;
    if (!has_front || leapt) front = sharedEndAt(k, stored);
    has_front = true;
    for (int j = turns; j > 0; --j, k = hn::Add(k, one)) {
      const V back = sharedEndAt(hn::Add(k, one), stored);
      const Stretch stretch{front, back};
      front = back;
      const M within = taking(hn::Lt(k, end), pixels);
      const M meets = meetingAmong<kType>(frame, within, stretch);
      met.count = 0;
      for (int i = 0; i < joined_count; ++i) addJoined(joined[i], k, within, met);
      if (hn::AllFalse(F(), meets) && met.count == 0
              ? !blendWhole(k, end, within, pixels)
              : !blendParts(k, end, within, meets, stretch, stored, met, pixels))
        return;
    }
  }
}

// Adds the surfaces of a box that joins this one, as rays of `within` meet them in slice k.
template <DeviceType kType, Shading kShading>
HWY_NOINLINE void Passage<kType, kShading>::addJoined(JoinedWay& way, V k, M within,
                                                    AllMet& met) const {
  if (way.box->has_spread)
    addSurfacesOf<Shading::kSpreadSurfaces>(way, k, within, met);
  else
    addSurfacesOf<Shading::kSurfaces>(way, k, within, met);
}
template <DeviceType kType, Shading kShading>
template <Shading kJoined>
HWY_INLINE void Passage<kType, kShading>::addSurfacesOf(JoinedWay& way, V k, M within,
                                                      AllMet& met) const {
  const M in_box = hn::And(within, hn::And(hn::Ge(k, way.from), hn::Lt(k, way.end)));
  if (hn::AllFalse(F(), in_box)) {
    way.has_front = false;
    return;
  }
  const KernelFrame& at_seam = *frame.at_seam;
  const V none = hn::Zero(F());
  const Passage<kType, kJoined> passage{at_seam, *way.box, way.first, way.pace,     none,
                                        ray_length, cellsOf(*way.box), true, none, in_box,
                                        places};
  const Cells stored = storedCells(*way.box);
  const V slice = hn::Add(k, all(way.farther));
  const V front = way.has_front ? way.front : passage.sharedEndAt(slice, stored);
  way.front = passage.sharedEndAt(hn::Add(slice, all(1.0F)), stored);
  way.has_front = true;
  const Stretch stretch{front, way.front};
  const M meets = meetingAmong<kType>(at_seam, in_box, stretch);
  if (!hn::AllFalse(F(), meets)) passage.addMet(slice, meets, stretch, stored, met);
}

// Adds the surfaces that the rays of `meets` meet in slice k.
template <DeviceType kType, Shading kShading>
HWY_NOINLINE void Passage<kType, kShading>::addMet(V k, M meets, const Stretch& stretch,
                                                 const Cells& stored, AllMet& met) const {
  const V near_end = hn::Sub(k, all(0.5F));
  const M up = hn::Gt(stretch.back, stretch.front);
  const auto placeAlong = [&](V part) { return placeOf(hn::Add(near_end, part), stored); };
  V from = hn::Zero(F()), value = stretch.front;
  for (int n = 0; n < frame.surfaces; ++n) {
    const MetSurface surface = surfaceOf(frame, up, n);
    const M hit = hn::And(meets, meetsLevel(stretch, surface.level));
    if (hn::AllFalse(F(), hit)) continue;
    const V part =
        crossing<kType, kShading>(box, stored, placeAlong,
                        {surface.level, from, value, stretch.back, hn::VecFromMask(F(), up)});
    met.of[static_cast<size_t>(met.count++)] = {
        hn::IfThenElse(hit, part, all(2.0F)), hn::VecFromMask(F(), hit),
        surfaceColor<kType, kShading>(frame, box, stored, placeAlong(part), surface)};
    // The next surface is met behind this one.
    from = hn::IfThenElse(hit, part, from);
    value = hn::IfThenElse(hit, surface.level, value);
  }
}

// The colour of slice k without surfaces, and the rays of `within` on which it shows something.
template <DeviceType kType, Shading kShading>
HWY_NOINLINE SliceColor Passage<kType, kShading>::sliceAt(V k, V end, M within) const {
  const Sample sample = take(k, end);
  M shows = hn::And(within, hn::And(hn::Ge(sample.value, all(frame.least_visible)),
                                    hn::Le(sample.value, all(frame.most_visible))));
  // Spreads may show other values than their mean.
  if (hasSpreads(kShading) || frame.shades_every_sample) shows = within;
  if (kType == DeviceType::kF32) shows = hn::AndNot(isNoNumber(sample.value), shows);
  const V none = hn::Zero(F());
  if (hn::AllFalse(F(), shows)) return {{none, none, none, none}, shows};
  return {colorOf<kType, kShading>(frame, box, sample.at, sample.place, sample.value,
                                   sample.square, ray_length),
          shows};
}
template <DeviceType kType, Shading kShading>
HWY_INLINE bool Passage<kType, kShading>::blendWhole(V k, V end, M within, Pixels& pixels) {
  if (!frame.has_opacities) return true;
  const SliceColor slice = sliceAt(k, end, within);
  return hn::AllFalse(F(), slice.shows) || add(slice.color, slice.shows, k, pixels);
}
// Slice k in parts, with the surfaces that rays meet between them: those of the box, which the rays
// of `meets` meet, in addition to those of `met`.
template <DeviceType kType, Shading kShading>
HWY_NOINLINE bool Passage<kType, kShading>::blendParts(V k, V end, M within, M meets,
                                                     const Stretch& stretch, const Cells& stored,
                                                     AllMet& met, Pixels& pixels) {
  const V none = hn::Zero(F()), one = all(1.0F), near_end = hn::Sub(k, all(0.5F));
  const SliceColor slice = frame.has_opacities
                          ? sliceAt(k, end, within)
                          : SliceColor{{none, none, none, none}, hn::MaskFromVec(none)};
  const bool has_others = met.count > 0;
  addMet(k, meets, stretch, stored, met);
  if (has_others) met.sort();
  V from = none;
  bool goes = true;
  for (int i = 0; i < met.count; ++i) {
    const Met& surface = met.of[static_cast<size_t>(i)];
    const M hit = hn::MaskFromVec(surface.hit);
    if (!hn::AllFalse(F(), slice.shows))
      add(partOf(slice.color, hn::Sub(surface.part, from)), hn::And(slice.shows, hit), k, pixels);
    goes = add(surface.color, hit, hn::Add(near_end, surface.part), pixels);
    from = hn::IfThenElse(hit, surface.part, from);
  }
  if (!hn::AllFalse(F(), slice.shows))
    goes = add(partOf(slice.color, hn::Sub(one, from)), slice.shows, k, pixels);
  return goes;
}
