// Leaping over bricks of a chunk that show nothing, see leap_grid.h. Included once a target.

// The way of a packet's rays through the chunk's bricks: at slice k they are at start + k * rate,
// in bricks; `inverse` is slices a brick.
struct BrickWay {
  V3 start, rate, inverse;
  M up_x, up_y, up_z;  // towards greater coordinates
};
HWY_INLINE BrickWay brickWay(const KernelBox& box, const V3& first, const V3& pace) {
  const V brick = all(1.0F / kBrickSide), one = all(1.0F), zero = hn::Zero(F());
  const V3 rate{safe(hn::Mul(pace.x, brick)), safe(hn::Mul(pace.y, brick)),
                safe(hn::Mul(pace.z, brick))};
  return {{hn::MulAdd(first.x, brick, all(box.brick_at[0])),
           hn::MulAdd(first.y, brick, all(box.brick_at[1])),
           hn::MulAdd(first.z, brick, all(box.brick_at[2]))},
          rate,
          {hn::Div(one, rate.x), hn::Div(one, rate.y), hn::Div(one, rate.z)},
          hn::Gt(rate.x, zero),
          hn::Gt(rate.y, zero),
          hn::Gt(rate.z, zero)};
}
// A placeholder for boxes without leaps; it is never read.
HWY_INLINE BrickWay noBrickWay() {
  const V none = hn::Zero(F());
  const M never = hn::MaskFromVec(none);
  return {{none, none, none}, {none, none, none}, {none, none, none}, never, never, never};
}

// Slices from `at` to the end of the bricks up to `distance` - 1 from `brick`, along one axis.
HWY_INLINE V slicesLeft(V at, V brick, V distance, V inverse, M up) {
  const V end = hn::IfThenElse(up, hn::Add(brick, distance),
                               hn::Sub(hn::Add(brick, all(1.0F)), distance));
  return hn::Mul(hn::Sub(end, at), inverse);
}

// Each ray's next slice, from k on, that lies in a brick that may show something, or about: all
// that are left out show nothing. `end` or more: there is none. Returns as soon as one ray has
// arrived; the others' may then be before it. `leapt`: whether any was left out.
HWY_INLINE V nextShown(const KernelBox& box, const BrickWay& way, V k, V end, bool& leapt) {
  // A fraction of a slice: so close to a brick's end, rounding may put the sample into the next
  // brick.
  const V near = all(1e-3F), zero = hn::Zero(F()), one = all(1.0F);
  leapt = false;
  for (;;) {
    const V3 at{hn::MulAdd(k, way.rate.x, way.start.x), hn::MulAdd(k, way.rate.y, way.start.y),
                hn::MulAdd(k, way.rate.z, way.start.z)};
    const V3 brick{hn::Min(hn::Max(hn::Floor(at.x), zero), all(box.brick_last[0])),
                   hn::Min(hn::Max(hn::Floor(at.y), zero), all(box.brick_last[1])),
                   hn::Min(hn::Max(hn::Floor(at.z), zero), all(box.brick_last[2]))};
    const V place = hn::MulAdd(brick.z, all(box.brick_stride[2]),
                               hn::MulAdd(brick.y, all(box.brick_stride[1]), brick.x));
    const VI bytes = bytesAt(reinterpret_cast<const std::byte*>(box.distances), wholeOf(place));
    const V distance = hn::ConvertTo(F(), hn::And(bytes, hn::Set(I(), 255)));
    const M active = hn::Lt(k, end);
    const M empty = hn::And(active, hn::Gt(distance, zero));
    if (hn::AllFalse(F(), empty)) return k;
    leapt = true;
    const V x = slicesLeft(at.x, brick.x, distance, way.inverse.x, way.up_x);
    const V y = slicesLeft(at.y, brick.y, distance, way.inverse.y, way.up_y);
    const V z = slicesLeft(at.z, brick.z, distance, way.inverse.z, way.up_z);
    const V left = hn::Sub(hn::Min(hn::Min(x, y), z), near);
    k = hn::IfThenElse(empty, hn::Add(k, hn::Max(hn::Add(hn::Floor(left), one), one)), k);
    if (!hn::AllFalse(F(), hn::AndNot(empty, active))) return k;
  }
}
