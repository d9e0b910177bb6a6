// The pixels of a packet in composite frames, and colours laid behind what they have. Included once
// a target.

// A packet's pixels while they are drawn.
struct Pixels {
  Color sum;
  V depth_sum;
  VI taken;
};

HWY_INLINE Pixels loadPixels(const KernelFrame& frame, const TilePixels& tile, int at) {
  return {{hn::Load(F(), tile.color[0] + at), hn::Load(F(), tile.color[1] + at),
           hn::Load(F(), tile.color[2] + at), hn::Load(F(), tile.color[3] + at)},
          frame.with_depth ? hn::Load(F(), tile.depth_sum + at) : hn::Zero(F()),
          hn::Zero(I())};
}
HWY_INLINE void storePixels(const KernelFrame& frame, const Pixels& pixels, TilePixels& tile,
                            int at) {
  hn::Store(pixels.sum.r, F(), tile.color[0] + at);
  hn::Store(pixels.sum.g, F(), tile.color[1] + at);
  hn::Store(pixels.sum.b, F(), tile.color[2] + at);
  hn::Store(pixels.sum.a, F(), tile.color[3] + at);
  if (frame.with_depth) hn::Store(pixels.depth_sum, F(), tile.depth_sum + at);
  if (frame.counts_taken)
    tile.taken += static_cast<uint64_t>(hn::GetLane(hn::SumOfLanes(I(), pixels.taken)));
}

// Lays a colour, premultiplied, behind the pixels that it shows in. `slice`: the place of its
// sample, in slices.
HWY_INLINE void layBehind(const KernelFrame& frame, Color color, M shows, V slice, Pixels& pixels) {
  const V left = hn::IfThenElseZero(shows, hn::Sub(all(1.0F), pixels.sum.a));
  if (frame.cue_most > 0) {
    const V dark = hn::MulAdd(slice, all(frame.cue_step), all(frame.cue_start));
    const V within = hn::Min(hn::Max(dark, hn::Zero(F())), all(frame.cue_most));
    const V bright = hn::Sub(all(1.0F), within);
    color = {hn::Mul(color.r, bright), hn::Mul(color.g, bright), hn::Mul(color.b, bright), color.a};
  }
  if (frame.with_depth) {
    const V depth = hn::MulAdd(slice, all(frame.depth_step), all(frame.first_depth));
    pixels.depth_sum = hn::MulAdd(hn::Mul(left, color.a), depth, pixels.depth_sum);
  }
  pixels.sum = {hn::MulAdd(left, color.r, pixels.sum.r), hn::MulAdd(left, color.g, pixels.sum.g),
                hn::MulAdd(left, color.b, pixels.sum.b), hn::MulAdd(left, color.a, pixels.sum.a)};
}

// The packet's pixels that still take samples.
HWY_INLINE M goingOf(const KernelFrame& frame, const TilePixels& tile, int at, V opacity) {
  const V stopped = hn::Load(F(), tile.stopped + at);
  return hn::And(hn::Eq(stopped, hn::Zero(F())), hn::Lt(opacity, all(frame.ray_opacity)));
}

// Whether no pixel of the tile takes more samples.
HWY_INLINE bool isThrough(const KernelFrame& frame, const TilePixels& tile) {
  for (int at = 0; at < kTilePixels; at += kLanes)
    if (!hn::AllFalse(F(), goingOf(frame, tile, at, hn::Load(F(), tile.color[3] + at))))
      return false;
  return true;
}
