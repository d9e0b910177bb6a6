// The light of a sample, see lighting.h and LightVolume. Included once a target.

HWY_INLINE V shine(const KernelFrame& frame, V x) {
  if (frame.whole_shininess > 0) {
    V result = all(1.0F);
    for (int n = frame.whole_shininess; n > 0; n /= 2) {
      if ((n & 1) != 0) result = hn::Mul(result, x);
      x = hn::Mul(x, x);
    }
    return result;
  }
  const V power = hn::Exp(
      F(), hn::Mul(all(frame.shininess), hn::Log(F(), hn::Max(x, all(1e-37F)))));
  return frame.shininess > 0 ? hn::IfThenElseZero(hn::Gt(x, hn::Zero(F())), power) : all(1.0F);
}

// Device values a world unit, camera space, divided by `unit`; its length squared.
struct Gradient {
  V3 g;
  V unit, squared;
  // See rough_light.h: the square of the slopes in all directions, 0 without spreads; what counts
  // of `squared`, and the share of that whose light is seen.
  V rough, here, seen;
};
HWY_INLINE V squareOf(const V3& v) {
  return hn::MulAdd(v.z, v.z, hn::MulAdd(v.y, v.y, hn::Mul(v.x, v.x)));
}
// kRough: of a texel with this spread and this noise.
template <bool kRough = false>
HWY_INLINE Gradient gradientOf(const KernelBox& box, V3 difference, V spread = hn::Zero(F()),
                               V noise = hn::Zero(F())) {
  // Computed in units of the steepest axis, since squares of the values themselves may overflow.
  V unit = hn::Max(
      hn::Max(hn::Abs(difference.x), hn::Max(hn::Abs(difference.y), hn::Abs(difference.z))),
      all(1e-30F));
  if constexpr (kRough) unit = hn::Max(unit, hn::Max(spread, noise));
  const V scale = hn::Div(all(1.0F), unit);
  difference = {hn::Mul(difference.x, scale), hn::Mul(difference.y, scale),
                hn::Mul(difference.z, scale)};
  const auto& [a, b, c] = box.gradient;
  const V3 g{dot3({a[0], b[0], c[0]}, difference), dot3({a[1], b[1], c[1]}, difference),
             dot3({a[2], b[2], c[2]}, difference)};
  V rough = hn::Zero(F());
  if constexpr (kRough) {
    const V share = hn::Mul(spread, scale);
    const V square = hn::Mul(all(static_cast<float>(kSpreadPart)), hn::Mul(share, share));
    const V left = hn::NegMulAdd(all(static_cast<float>(kSlopePart)), squareOf(difference), square);
    const V still = hn::Mul(noise, scale);
    const V steep = hn::Mul(all(box.noise_part), hn::Mul(still, still));
    rough = hn::Mul(all(box.gradient_squares), hn::Add(hn::Max(left, rough), steep));
  }
  return {g, unit, squareOf(g), rough, all(1.0F), all(1.0F)};
}

// The shares of light that arrive at a sample, see LightVolume.
struct Arriving {
  V key, open;
};
// `kKey`, `kOther`: whether this number of the texels varies.
template <bool kKey, bool kOther>
HWY_INLINE Arriving arrivingIn(const KernelFrame& frame, const Place& cell) {
  const auto row = static_cast<int64_t>(frame.light_stride[1]);
  const auto plane = static_cast<int64_t>(frame.light_stride[2]);
  const int64_t more[4] = {0, row, plane, row + plane};
  Pair key[4], open[4];
  for (int i = 0; i < 4; ++i) {
    const auto [first, second] = wideAt(frame.light + more[i], cell.offset);
    const Pair one = pairIn<DeviceType::kU16>(first), next = pairIn<DeviceType::kU16>(second);
    key[i] = {one.first, next.first};
    open[i] = {one.second, next.second};
  }
  const V unit = all(static_cast<float>(1 / kAllLight)), whole = all(1.0F);
  return {kKey ? hn::Mul(unit, withinRows(key, cell)) : whole,
          kOther ? hn::Mul(unit, withinRows(open, cell)) : whole};
}
// The same of light_squares.h.
HWY_INLINE Arriving arrivingInSquares(const KernelFrame& frame, const Place& cell) {
  const auto plane = static_cast<int64_t>(frame.light_stride[2]);
  Wide square[2];  // one plane after the other
  wideOfEach({frame.light, frame.light + plane}, cell.offset, square);
  const Pair open[4] = {
      pairIn<DeviceType::kU16>(square[0].first), pairIn<DeviceType::kU16>(square[0].second),
      pairIn<DeviceType::kU16>(square[1].first), pairIn<DeviceType::kU16>(square[1].second)};
  return {all(1.0F), hn::Mul(all(static_cast<float>(1 / kAllLight)), withinRows(open, cell))};
}
// The texels of the frame's light around a place in a box's texels.
HWY_INLINE Place lightPlaceAt(const KernelFrame& frame, const KernelBox& box, const V3& at) {
  const auto& [x, y, z] = box.light_axes;
  const Float3 &scale = box.light_scale, &start = box.light_start;
  const V3 place{hn::MulAdd(along(at, x), all(scale[0]), all(start[0])),
                 hn::MulAdd(along(at, y), all(scale[1]), all(start[1])),
                 hn::MulAdd(along(at, z), all(scale[2]), all(start[2]))};
  const Float3 &hi = frame.light_hi, &last = frame.light_last, &stride = frame.light_stride;
  const V none = hn::Zero(F());
  const Cells texels{{none, none, none},
                     {all(hi[0]), all(hi[1]), all(hi[2])},
                     {all(last[0]), all(last[1]), all(last[2])},
                     {all(stride[0]), all(stride[1]), all(stride[2])}};
  return placeAt(texels, clamped(texels, place));
}
// A call of its own: shadows cost more than a call, and inside each kernel it took a fifth of the
// compiler's time.
HWY_NOINLINE Arriving arrivingWithKey(const KernelFrame& frame, const KernelBox& box, V3 at) {
  const Place cell = lightPlaceAt(frame, box, at);
  if (!frame.key_light_varies) return arrivingIn<false, true>(frame, cell);
  if (!frame.other_light_varies) return arrivingIn<true, false>(frame, cell);
  return arrivingIn<true, true>(frame, cell);
}
// The light that looks around is no call: storing and loading all vector registers took half of its
// time.
HWY_INLINE Arriving arrivingAt(const KernelFrame& frame, const KernelBox& box, const V3& at) {
  return frame.light_in_squares ? arrivingInSquares(frame, lightPlaceAt(frame, box, at))
                                : arrivingWithKey(frame, box, at);
}

// Applies lighting.h with this `flat` at a place in texels; `color` is premultiplied. kRough: the
// gradient's `rough` may be above 0.
template <bool kRough = false>
HWY_INLINE Color shaded(const KernelFrame& frame, const KernelBox& box, const V3& at,
                        const Color& color, const Gradient& gradient, float flatness) {
  const bool all_arrives = frame.light == nullptr;
  const V one = all(1.0F);
  const Arriving light = all_arrives ? Arriving{one, one} : arrivingAt(frame, box, at);
  const V to_unit = hn::Div(all(1.0F), hn::Sqrt(hn::Max(gradient.squared, all(1e-37F))));
  V diffuse = hn::Zero(F()), specular = hn::Zero(F());
  V even_diffuse = hn::Zero(F()), even_specular = hn::Zero(F());
  for (size_t i = 0; i < frame.toward.size(); ++i) {
    const V facing = hn::Abs(dot3(frame.toward[i], gradient.g));
    const V mirrored = hn::Mul(to_unit, hn::Abs(dot3(frame.halfway[i], gradient.g)));
    const V share = i == 0 ? light.key : light.open;
    diffuse = all_arrives ? hn::Add(diffuse, facing) : hn::MulAdd(share, facing, diffuse);
    const V strength = all(frame.specular[i]);
    specular = hn::MulAdd(all_arrives ? strength : hn::Mul(share, strength),
                          shine(frame, mirrored), specular);
    if constexpr (kRough) {
      even_diffuse = hn::MulAdd(share, all(frame.even_diffuse[i]), even_diffuse);
      even_specular = hn::MulAdd(share, all(frame.even_specular[i]), even_specular);
    }
  }
  V ambient = all(frame.ambient), squared = gradient.squared, seen = squared;
  if (!all_arrives) ambient = hn::Mul(light.open, ambient);
  if constexpr (kRough) {
    const V counted = hn::Mul(squared, gradient.here);
    squared = hn::Add(counted, gradient.rough);
    seen = hn::MulAdd(counted, gradient.seen, gradient.rough);
    const V even = hn::Div(gradient.rough, hn::Max(squared, all(1e-37F)));
    const V directed = hn::Sub(one, even);
    ambient = hn::MulAdd(even, even_diffuse, ambient);
    diffuse = hn::Mul(directed, diffuse);
    specular = between(specular, even_specular, even, directed);
  }
  const V bright = hn::MulAdd(to_unit, diffuse, ambient);
  const V gleam = hn::Mul(color.a, specular);
  const V flat = hn::Div(all(flatness), gradient.unit);
  const V part = hn::Div(seen, hn::Max(hn::MulAdd(flat, flat, squared), all(1e-37F)));
  V rest = hn::Sub(one, part);
  if (!all_arrives)
    rest = hn::Mul(rest, between(light.open, light.key, all(frame.key_share),
                                 all(1 - frame.key_share)));
  return {between(color.r, hn::MulAdd(color.r, bright, gleam), part, rest),
          between(color.g, hn::MulAdd(color.g, bright, gleam), part, rest),
          between(color.b, hn::MulAdd(color.b, bright, gleam), part, rest), color.a};
}
