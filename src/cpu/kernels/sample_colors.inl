// The colour of a sample or a segment of composite frames, with its light and factors, by the kind of
// work that it takes. Included once a target.

// The work that a sample's colour takes beyond the look-up.
enum class Shading {
  kTable,      // nothing: parallel views
  kLength,     // the opacity corrected for the ray: perspective views
  kGradients,  // light, or factors of the opacity; either view
  kSpread,     // chunks with spreads; with or without gradients, either view
  kShares,     // the same of labels: chunks with shares
  // Pre-integrated: a sample stands for the values between two places, see FrameSetup::integrates.
  kSegments,
  kSegmentGradients,
  kSurfaces,  // with surfaces, see FrameSetup::has_surfaces; with or without gradients, either view
  kSpreadSurfaces,  // the same of chunks with spreads
};
constexpr bool hasSpreads(Shading shading) {
  return shading == Shading::kSpread || shading == Shading::kSpreadSurfaces;
}
constexpr bool hasTwoNumbers(Shading shading) {
  return hasSpreads(shading) || shading == Shading::kShares;
}
constexpr bool hasSurfaces(Shading shading) {
  return shading == Shading::kSurfaces || shading == Shading::kSpreadSurfaces;
}
constexpr bool isIntegrated(Shading shading) {
  return shading == Shading::kSegments || shading == Shading::kSegmentGradients;
}

// Whether samples are read at places that are clamped to the box: a value that stands for NaN is so
// large that even a rounding error's share of it would show.
template <DeviceType kType, Shading kShading>
HWY_INLINE bool needsClamps(const KernelFrame& frame, const KernelBox& box) {
  return kType == DeviceType::kF32 || kShading == Shading::kGradients || hasTwoNumbers(kShading) ||
         hasSurfaces(kShading) || frame.labels || box.clamps;
}

// The value at a place, and the square of its spread, or a label and its share; one number twice if
// the chunk has one.
struct Numbers {
  V value, square;
};
template <DeviceType kType, Shading kShading>
HWY_INLINE Numbers numbersAt(const KernelFrame& frame, const KernelBox& box, const Place& place) {
  if constexpr (hasSpreads(kShading)) {
    const SpreadValue both = spreadAt<kType>(box, place, frame.spread_scale);
    return {both.mean, both.square};
  } else if constexpr (kShading == Shading::kShares) {
    const SharedLabel both = sharedLabelAt<kType>(frame, box, place);
    return {both.label, both.part};
  } else {
    const V value = frame.labels ? labelAt<kType>(box, place) : valueAt<kType>(box, place);
    return {value, value};
  }
}

template <DeviceType kType, Shading kShading>
HWY_INLINE V3 differencesOf(const KernelBox& box, const V3& at, const Place& place) {
  constexpr bool kSpread = hasTwoNumbers(kShading);
  return box.has_margin ? differencesAt<kType, kSpread>(box, place)
                        : differencesWithoutMargin<kType, kSpread>(box, at);
}

// A place whose differences are known, in boxes of one number a texel.
struct ReadPlace {
  V3 differences;
};
template <DeviceType kType, Shading kShading>
HWY_INLINE V3 differencesOf(const KernelBox&, const V3&, const ReadPlace& place) {
  return place.differences;
}

// The gradient of a sample. `square`: of the spread, as numbersAt() returns it.
template <DeviceType kType, Shading kShading, class At>
HWY_INLINE Gradient sampleGradient(const KernelFrame& frame, const KernelBox& box, const V3& at,
                                   const At& place, V square) {
  if constexpr (hasSpreads(kShading)) {
    const WideSlopes wide = wideSlopesAt<kType>(frame, box, at, place, square);
    const V unit = all(frame.spread_unit);
    Gradient gradient = gradientOf<true>(box, wide.slopes, hn::Mul(hn::Sqrt(wide.square), unit),
                                         hn::Mul(hn::Sqrt(wide.noise), unit));
    gradient.here = wide.here;
    gradient.seen = wide.seen;
    return gradient;
  }
  return gradientOf(box, differencesOf<kType, kShading>(box, at, place));
}

// The colour of a sample with its light. `gradient`: of the values, which the numbers of labels are
// not.
template <DeviceType kType, Shading kShading>
HWY_INLINE Color shadedSample(const KernelFrame& frame, const KernelBox& box, const V3& at,
                              const ReadPlace&, const Color& color, const Gradient& gradient) {
  return shaded(frame, box, at, color, gradient, frame.flat);
}
template <DeviceType kType, Shading kShading>
HWY_INLINE Color shadedSample(const KernelFrame& frame, const KernelBox& box, const V3& at,
                              const Place& place, const Color& color, const Gradient& gradient) {
  constexpr bool kRough = hasSpreads(kShading);
  if (!frame.labels) return shaded<kRough>(frame, box, at, color, gradient, frame.flat);
  const V3 slopes = labelSlopesAt<kType, kShading == Shading::kShares>(frame, box, at, place);
  return shaded(frame, box, at, color, gradientOf(box, slopes), frame.flat);
}

// The colour of a label of which a part shows, see label_shares.h.
template <DeviceType kType>
HWY_INLINE Color sharedColorOf(const KernelFrame& frame, const KernelBox& box, const V3& at,
                               const Place& place, V label, V part, V ray_length) {
  const V entry = entryOf(frame, label);
  Gradient gradient{};
  if (frame.rows > 0)
    gradient = gradientOf(box, differencesOf<kType, Shading::kShares>(box, at, place));
  const Color one = entryAt(frame.label_entries, wholeOf(hn::Add(entry, all(0.5F))));
  V a = one.a;
  if (frame.rows > 0)
    a = hn::Mul(a, factorAt(frame, hn::Mul(gradient.unit, hn::Sqrt(gradient.squared)), entry));
  // Shares of labels multiply the opacity of a whole texel, not that of a unit length.
  const V whole = corrected(a, all(box.texel_length));
  a = corrected(hn::Mul(whole, part),
                hn::Mul(ray_length, all(frame.slice_length / box.texel_length)));
  const Color color{hn::Mul(one.r, a), hn::Mul(one.g, a), hn::Mul(one.b, a), a};
  return frame.lit ? shadedSample<kType, Shading::kShares>(frame, box, at, place, color, gradient)
                   : color;
}

template <DeviceType kType, Shading kShading, class At>
HWY_INLINE Color colorOf(const KernelFrame& frame, const KernelBox& box, const V3& at,
                         const At& place, V value, V square, V ray_length) {
  if constexpr (kShading == Shading::kShares)
    return sharedColorOf<kType>(frame, box, at, place, value, square, ray_length);
  const V entry = entryOf(frame, value), none = hn::Zero(F());
  Color color{none, none, none, none};
  // Most packets in chunks with spreads need no colour of a texel without one.
  if (!hasSpreads(kShading) ||
      !hn::AllTrue(F(), hn::Ge(expectedRow(frame, square), all(1.0F))))
    color = colorAt(frame, entry);
  if constexpr (kShading == Shading::kLength) {
    // Perspective rays are longer away from the middle: the table holds the exponent of a unit.
    color.a = hn::Sub(all(1.0F), powerOfTwo(hn::Mul(color.a, ray_length)));
    color = {hn::Mul(color.r, color.a), hn::Mul(color.g, color.a), hn::Mul(color.b, color.a),
             color.a};
  }
  if constexpr (kShading == Shading::kGradients || hasSpreads(kShading) || hasSurfaces(kShading)) {
    Gradient gradient{};
    // The opacity of spreads may not need it: then only samples that show something do.
    const bool comes_later = hasSpreads(kShading) && frame.rows == 0;
    if (!comes_later && (frame.rows > 0 || (frame.lit && !frame.labels)))
      gradient = sampleGradient<kType, kShading>(frame, box, at, place, square);
    V factor = all(1.0F);
    if (frame.rows > 0) {
      const V magnitude = hn::Mul(gradient.unit, hn::Sqrt(gradient.squared));
      factor = factorAt(frame, magnitude, entry);
      color.a = hn::Mul(color.a, factor);
      if (frame.corrects)
        color.a = corrected(color.a, hn::Mul(ray_length, all(frame.slice_length)));
    } else if (frame.perspective) {
      color.a = hn::Sub(all(1.0F), powerOfTwo(hn::Mul(color.a, ray_length)));
    }
    if (frame.rows > 0 || frame.perspective)
      color = {hn::Mul(color.r, color.a), hn::Mul(color.g, color.a), hn::Mul(color.b, color.a),
               color.a};
    if constexpr (hasSpreads(kShading))
      color = expectedColor(frame, value, square, factor,
                            hn::Mul(ray_length, all(frame.slice_length)), color);
    if (comes_later) {
      if (!frame.lit || hn::AllFalse(F(), hn::Gt(color.a, hn::Zero(F())))) return color;
      gradient = sampleGradient<kType, kShading>(frame, box, at, place, square);
    }
    if (frame.lit) color = shadedSample<kType, kShading>(frame, box, at, place, color, gradient);
  }
  return color;
}

// The same of a segment. `at`: its middle; `middle`: the place of its value among the entries.
template <DeviceType kType, Shading kShading>
HWY_INLINE Color segmentColorOf(const KernelFrame& frame, const KernelBox& box, const V3& at,
                                V middle, const Extinction& mean, V ray_length) {
  Color color = extinctionColor(frame, mean);
  Gradient gradient{};
  if constexpr (kShading == Shading::kSegmentGradients)
    gradient = gradientOf(box, differencesOf<kType, kShading>(box, at, placeAt(cellsOf(box), at)));
  if (kShading == Shading::kSegmentGradients && frame.rows > 0) {
    const V magnitude = hn::Mul(gradient.unit, hn::Sqrt(gradient.squared));
    const V entry = hn::Min(hn::Max(middle, hn::Zero(F())), all(frame.last_entry));
    color.a = hn::Mul(hn::Sub(all(1.0F), powerOfTwo(hn::Neg(color.a))),
                      factorAt(frame, magnitude, entry));
    if (frame.corrects) color.a = corrected(color.a, hn::Mul(ray_length, all(frame.slice_length)));
  } else {
    color.a = hn::Sub(all(1.0F), powerOfTwo(hn::Neg(hn::Mul(color.a, ray_length))));
  }
  color = {hn::Mul(color.r, color.a), hn::Mul(color.g, color.a), hn::Mul(color.b, color.a),
           color.a};
  if (kShading == Shading::kSegmentGradients && frame.lit)
    color = shaded(frame, box, at, color, gradient, frame.flat);
  return color;
}
