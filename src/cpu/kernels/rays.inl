// Rays of a packet of pixels and the positions of their samples in a box. Included once a target.

using F = hn::CappedTag<float, kMostLanes>;
using I = hn::RebindToSigned<F>;
using V = hn::Vec<F>;
using VI = hn::Vec<I>;
using M = hn::Mask<F>;

constexpr int kLanes = static_cast<int>(hn::MaxLanes(F()));
constexpr int kPacketWidth = kLanes >= 8 ? 4 : kLanes >= 4 ? 2 : 1;
constexpr int kPacketHeight = kLanes / kPacketWidth;
static_assert(kTileSide % kPacketWidth == 0 && kTileSide % kPacketHeight == 0);

HWY_INLINE V all(float value) { return hn::Set(F(), value); }

// Rounds toward 0, for numbers in the range of the result; any other input, or NaN, gives an
// arbitrary result. ConvertTo() takes five instructions for one to promise more.
HWY_INLINE VI wholeOf(V v) {
#if HWY_TARGET == HWY_AVX3
  return VI{_mm512_cvttps_epi32(v.raw)};
#elif HWY_TARGET == HWY_AVX2
  return VI{_mm256_cvttps_epi32(v.raw)};
#elif HWY_TARGET == HWY_SSE4
  return VI{_mm_cvttps_epi32(v.raw)};
#else
  return hn::ConvertTo(I(), v);
#endif
}

// A vector along three axes.
struct V3 {
  V x, y, z;
};
HWY_INLINE V dot3(const Float3& a, const V3& b) {
  return hn::MulAdd(all(a[2]), b.z, hn::MulAdd(all(a[1]), b.y, hn::Mul(all(a[0]), b.x)));
}
// base + px * dx + py * dy.
HWY_INLINE V planeAt(float base, float dx, float dy, V px, V py) {
  return hn::MulAdd(py, all(dy), hn::MulAdd(px, all(dx), all(base)));
}
HWY_INLINE V3 planesAt(const Float3& base, const Float3& dx, const Float3& dy, V px, V py) {
  return {planeAt(base[0], dx[0], dy[0], px, py), planeAt(base[1], dx[1], dy[1], px, py),
          planeAt(base[2], dx[2], dy[2], px, py)};
}
HWY_INLINE V along(const V3& v, int axis) { return axis == 0 ? v.x : axis == 1 ? v.y : v.z; }
HWY_INLINE V3 ordered(const V3& v, const std::array<int, 3>& axes) {
  return {along(v, axes[0]), along(v, axes[1]), along(v, axes[2])};
}

// Pixels of a packet: their centres, in the picture and from its tile's corner, and which of them
// are in the picture.
struct Packet {
  V px, py, tile_px, tile_py;
  V jitter;  // slices lie farther by it
  M inside;
};
// The packets of the tile that may see the box: the corners of the first and beyond the last, in
// pixels of the tile.
struct PacketRange {
  int x_lo, y_lo, x_hi, y_hi;
};
HWY_INLINE PacketRange packetsOf(const KernelBox& box, const TilePixels& tile) {
  return {std::max(0, box.x_lo - tile.x) / kPacketWidth * kPacketWidth,
          std::max(0, box.y_lo - tile.y) / kPacketHeight * kPacketHeight,
          std::min(kTileSide, box.x_hi - tile.x), std::min(kTileSide, box.y_hi - tile.y)};
}
struct LanePlaces {
  alignas(64) float column[kMostLanes], row[kMostLanes];
  constexpr LanePlaces() : column(), row() {
    for (int lane = 0; lane < kLanes; ++lane) {
      const int x = lane % kPacketWidth, y = lane / kPacketWidth;
      column[lane] = static_cast<float>(x);
      row[lane] = static_cast<float>(y);
    }
  }
};
constexpr LanePlaces kLanePlaces;
HWY_INLINE V jitterAt(const KernelFrame& frame, int x, int y) {
  if (frame.noise == nullptr) return hn::Zero(F());
  alignas(64) float noise[kMostLanes];
  for (int lane = 0; lane < kLanes; ++lane) {
    const int column = (x + lane % kPacketWidth) % kBlueNoiseSide;
    const int row = (y + lane / kPacketWidth) % kBlueNoiseSide;
    noise[lane] = frame.noise[row * kBlueNoiseSide + column];
  }
  return hn::Mul(hn::Load(F(), noise), all(frame.jitter));
}
HWY_INLINE Packet packetAt(const KernelFrame& frame, const TilePixels& tile, int x, int y) {
  const V tile_px = hn::Add(hn::Load(F(), kLanePlaces.column), all(static_cast<float>(x) + 0.5F));
  const V tile_py = hn::Add(hn::Load(F(), kLanePlaces.row), all(static_cast<float>(y) + 0.5F));
  const V px = hn::Add(tile_px, all(static_cast<float>(tile.x)));
  const V py = hn::Add(tile_py, all(static_cast<float>(tile.y)));
  return {px, py, tile_px, tile_py, jitterAt(frame, tile.x + x, tile.y + y),
          hn::And(hn::Lt(px, all(static_cast<float>(frame.width))),
                  hn::Lt(py, all(static_cast<float>(frame.height))))};
}

// The way from slice to slice along the packet's rays, in units of slice_length.
HWY_INLINE V rayLengthOf(const KernelFrame& frame, const Packet& packet) {
  if (!frame.perspective) return all(1.0F);
  const V u = hn::MulAdd(packet.px, all(frame.pixel_ray[0]), all(frame.pixel_ray[1]));
  const V v = hn::MulAdd(packet.py, all(frame.pixel_ray[2]), all(frame.pixel_ray[3]));
  return hn::Sqrt(hn::MulAdd(v, v, hn::MulAdd(u, u, all(1.0F))));
}

// Voxel coordinates of a tile's pixels in a box, at the box's first slice: base + x * dx + y * dy.
struct Positions {
  Float3 base, dx, dy;
};
HWY_INLINE Positions positionsIn(const KernelBox& box, const TilePixels& tile) {
  Positions result;
  for (size_t a = 0; a < 3; ++a) {
    const int i = static_cast<int>(a);
    result.base[a] = static_cast<float>(box.voxel0[i] + tile.x * box.voxel_dx[i] +
                                        tile.y * box.voxel_dy[i]);
    result.dx[a] = static_cast<float>(box.voxel_dx[i]);
    result.dy[a] = static_cast<float>(box.voxel_dy[i]);
  }
  return result;
}
HWY_INLINE V3 voxelsOf(const Positions& positions, const Packet& packet) {
  return planesAt(positions.base, positions.dx, positions.dy, packet.tile_px, packet.tile_py);
}

// Texel coordinates of a place in the box, and of a way.
HWY_INLINE V3 texelsAt(const KernelBox& box, const V3& voxels) {
  return ordered({hn::MulAdd(voxels.x, all(box.texel_scale[0]), all(box.texel_start[0])),
                  hn::MulAdd(voxels.y, all(box.texel_scale[1]), all(box.texel_start[1])),
                  hn::MulAdd(voxels.z, all(box.texel_scale[2]), all(box.texel_start[2]))},
                 box.axes);
}
HWY_INLINE V3 texelsAlong(const KernelBox& box, const V3& voxels) {
  return ordered({hn::Mul(voxels.x, all(box.texel_scale[0])),
                  hn::Mul(voxels.y, all(box.texel_scale[1])),
                  hn::Mul(voxels.z, all(box.texel_scale[2]))},
                 box.axes);
}

HWY_INLINE V3 stepOf(const KernelFrame& frame, const Packet& packet) {
  return planesAt(frame.step0, frame.step_dx, frame.step_dy, packet.px, packet.py);
}

// A place, farther along a way.
HWY_INLINE V3 fartherBy(V part, const V3& way, const V3& place) {
  return {hn::MulAdd(part, way.x, place.x), hn::MulAdd(part, way.y, place.y),
          hn::MulAdd(part, way.z, place.z)};
}

// The step kept away from 0, so that one may divide by it.
HWY_INLINE V safe(V step) {
  return hn::IfThenElse(hn::Lt(hn::Abs(step), all(1e-12F)), all(1e-12F), step);
}

// The first slice past a face, `way` from the ray's start along the axis: both boxes at the face
// compute the same number.
HWY_INLINE V sliceAt(V way, V step) {
  const V t = hn::Sub(hn::Div(way, step), all(0.5F));
  return hn::IfThenElse(hn::Gt(step, hn::Zero(F())), hn::Ceil(t),
                        hn::Add(hn::Floor(t), all(1.0F)));
}

HWY_INLINE void clipAxis(float lo, float hi, V origin, V step, V& from, V& to) {
  step = safe(step);
  const V at_lo = sliceAt(hn::Sub(all(lo), origin), step);
  const V at_hi = sliceAt(hn::Sub(all(hi), origin), step);
  from = hn::Max(from, hn::Min(at_lo, at_hi));
  to = hn::Min(to, hn::Max(at_lo, at_hi));
}

// Slices [from, from + count) of each pixel's ray lie inside the box and the clip planes; `from`
// counts from the box's first slice.
struct Slices {
  V from, count;
};
HWY_INLINE Slices slicesIn(const KernelFrame& frame, const KernelBox& box, const Packet& packet,
                           const V3& step) {
  const Float3 start{0, 0, 0};
  // Rays count from origin0, so that their corner is 0.
  V3 origin = planesAt(start, frame.origin_dx, frame.origin_dy, packet.px, packet.py);
  if (frame.noise != nullptr) origin = fartherBy(packet.jitter, step, origin);
  V from = all(frame.first_slice), to = all(1e15F);
  clipAxis(box.lo[0], box.hi[0], origin.x, step.x, from, to);
  clipAxis(box.lo[1], box.hi[1], origin.y, step.y, from, to);
  clipAxis(box.lo[2], box.hi[2], origin.z, step.z, from, to);
  for (int i = 0; i < frame.clip_planes; ++i) {
    const auto& plane = frame.clip_plane[static_cast<size_t>(i)];
    const Float3 normal{plane[0], plane[1], plane[2]};
    const V pace = dot3(normal, step);
    const V t = hn::Sub(hn::Div(hn::Sub(all(plane[3]), dot3(normal, origin)), safe(pace)),
                        all(0.5F));
    const M against = hn::Lt(pace, hn::Zero(F()));
    from = hn::IfThenElse(against, hn::Max(from, hn::Ceil(t)), from);
    to = hn::IfThenElse(against, to, hn::Min(to, hn::Add(hn::Floor(t), all(1.0F))));
  }
  const V count = hn::IfThenElseZero(packet.inside, hn::Max(hn::Sub(to, from), hn::Zero(F())));
  return {hn::Sub(from, all(box.first_slice)), count};
}

// Voxel planes, see FrameSetup: sample j of [0, count) lies at
// clamp(start + (from + clamp(j, first, last)) * way, 0, size) voxels from the box's lower corner.
struct Planes {
  V3 start, way;
  V from, count;
  V first, last;  // the ends of the ray's way through what is shown, if they lie in the box
};
// A ray's way through a box, in slices from the box's first one on, whole or not.
struct Reach {
  V from, to;
  // The same for only those faces at which the ray enters and leaves what is shown. If they equal
  // `from` and `to`, those are ends of the ray's way.
  V enters, leaves;
};
HWY_INLINE void reachAxis(const KernelBox& box, size_t axis, V at, V step, Reach& reach) {
  step = safe(step);
  const V edge = all(static_cast<float>(kPlaneEdge));
  const V at_lo = hn::Div(hn::Sub(hn::Neg(edge), at), step);
  const V at_hi = hn::Div(hn::Sub(hn::Add(all(box.size[axis]), edge), at), step);
  const V enter = hn::Min(at_lo, at_hi), leave = hn::Max(at_lo, at_hi);
  const M up = hn::Gt(step, hn::Zero(F()));
  const V lo = all(box.inside_lo[axis]), hi = all(box.inside_hi[axis]);
  reach.from = hn::Max(reach.from, enter);
  reach.to = hn::Min(reach.to, leave);
  reach.enters = hn::Max(reach.enters, hn::Sub(enter, hn::IfThenElse(up, lo, hi)));
  reach.leaves = hn::Min(reach.leaves, hn::Add(leave, hn::IfThenElse(up, hi, lo)));
}
// A cut by a clip plane or the eye ends the way, wherever it is.
HWY_INLINE void cutBefore(V at, Reach& reach) {
  reach.from = hn::Max(reach.from, at);
  reach.enters = hn::Max(reach.enters, at);
}
HWY_INLINE void cutBehind(V at, Reach& reach) {
  reach.to = hn::Min(reach.to, at);
  reach.leaves = hn::Min(reach.leaves, at);
}
// Whole numbers from a bounded interval of the main axis.
HWY_INLINE Planes planesIn(const KernelFrame& frame, const KernelBox& box,
                           const Positions& positions, const Packet& packet, const V3& step) {
  const V tie = all(1 + static_cast<float>(kAxisTie));
  const V3 pace{hn::Abs(step.x), hn::Abs(step.y), hn::Abs(step.z)};
  const M second = hn::Gt(pace.y, hn::Mul(tie, pace.x));
  const M third = hn::Gt(pace.z, hn::Mul(tie, hn::IfThenElse(second, pace.y, pace.x)));
  const V3 at = voxelsOf(positions, packet);
  const V far = all(1e15F), beyond = all(kInside), none = all(2 * kInside);
  Reach reach{hn::Neg(far), far, hn::Neg(none), none};
  reachAxis(box, 0, at.x, step.x, reach);
  reachAxis(box, 1, at.y, step.y, reach);
  reachAxis(box, 2, at.z, step.z, reach);
  if (frame.first_slice > 0) cutBefore(all(frame.first_slice - box.first_slice), reach);
  if (frame.clip_planes > 0) {
    const Float3 start{0, 0, 0};
    const V3 origin =
        planesAt(start, frame.origin_dx, frame.origin_dy, packet.px, packet.py);
    for (int i = 0; i < frame.clip_planes; ++i) {
      const auto& plane = frame.clip_plane[static_cast<size_t>(i)];
      const Float3 normal{plane[0], plane[1], plane[2]};
      const V toward = dot3(normal, step);
      const V t = hn::Sub(hn::Div(hn::Sub(all(plane[3]), dot3(normal, origin)), safe(toward)),
                          all(0.5F + box.first_slice));
      const M against = hn::Lt(toward, hn::Zero(F()));
      cutBefore(hn::IfThenElse(against, t, hn::Neg(none)), reach);
      cutBehind(hn::IfThenElse(against, none, t), reach);
    }
  }
  // Coordinates along the main axis, in texels.
  const Float3 &scales = box.texel_scale, &starts = box.texel_start;
  const V scale_there =
      hn::IfThenElse(third, all(scales[2]), hn::IfThenElse(second, all(scales[1]), all(scales[0])));
  const V start_there =
      hn::IfThenElse(third, all(starts[2]), hn::IfThenElse(second, all(starts[1]), all(starts[0])));
  const V speed = hn::Mul(
      scale_there, hn::IfThenElse(third, step.z, hn::IfThenElse(second, step.y, step.x)));
  const V place = hn::MulAdd(
      hn::IfThenElse(third, at.z, hn::IfThenElse(second, at.y, at.x)), scale_there, start_there);
  const V planes = all(frame.planes_a_voxel);
  const V way = hn::IfThenElse(hn::Lt(speed, hn::Zero(F())), hn::Neg(planes), planes);
  const V slices = hn::Div(place, speed), scale = hn::Div(all(1.0F), hn::Mul(way, speed));
  Planes result{{hn::NegMulAdd(slices, step.x, at.x), hn::NegMulAdd(slices, step.y, at.y),
                 hn::NegMulAdd(slices, step.z, at.z)},
                {hn::Mul(step.x, scale), hn::Mul(step.y, scale), hn::Mul(step.z, scale)},
                hn::Zero(F()),
                hn::Zero(F()),
                hn::Zero(F()),
                hn::Zero(F())};
  const M meets = hn::And(packet.inside, hn::Le(reach.from, reach.to));
  const M enters = hn::Ge(reach.enters, reach.from), leaves = hn::Le(reach.leaves, reach.to);
  const V margin = all(frame.end_margin);
  const V from = hn::Mul(way, hn::MulAdd(reach.from, speed, place));
  const V to = hn::Mul(way, hn::MulAdd(reach.to, speed, place));
  result.from = hn::IfThenElse(enters, hn::Floor(hn::Add(from, margin)), hn::Ceil(from));
  const V last = hn::IfThenElse(leaves, hn::Ceil(hn::Sub(to, margin)), hn::Floor(to));
  result.first = hn::IfThenElse(enters, hn::Sub(from, result.from), hn::Neg(beyond));
  result.last = hn::IfThenElse(leaves, hn::Sub(to, result.from), beyond);
  result.count = hn::IfThenElseZero(
      meets, hn::Max(hn::Add(hn::Sub(last, result.from), all(1.0F)), hn::Zero(F())));
  return result;
}
