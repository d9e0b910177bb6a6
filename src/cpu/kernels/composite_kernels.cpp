// Composite: a packet of pixels goes through one box after another, front to back.
#include <algorithm>
#include <utility>

// Highway requires this order.
// clang-format off
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "src/cpu/kernels/composite_kernels.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
#include <hwy/contrib/math/math-inl.h>
// clang-format on

#include "src/cpu/kernels/kernel_set.h"
#include "src/cpu/kernels/kernel_values.h"
#include "src/cpu/kernels/packed_entries.h"
#include "src/cpu/leap_grid.h"
#include "src/device/pictures/blue_noise.h"
#include "src/device/shading/rough_light.h"

#if SLUICE_HAS_KERNELS
HWY_BEFORE_NAMESPACE();
namespace sluice::HWY_NAMESPACE {
namespace {
namespace hn = hwy::HWY_NAMESPACE;

// Each needs those before it.
// clang-format off
#include "src/cpu/kernels/rays.inl"
#include "src/cpu/kernels/loads.inl"
#include "src/cpu/kernels/texels.inl"
#include "src/cpu/kernels/colors.inl"
#include "src/cpu/kernels/lighting.inl"
#include "src/cpu/kernels/wide_slopes.inl"
#include "src/cpu/kernels/label_slopes.inl"
#include "src/cpu/kernels/leaps.inl"
#include "src/cpu/kernels/segments.inl"
#include "src/cpu/kernels/sample_colors.inl"
#include "src/cpu/kernels/pixels.inl"
#include "src/cpu/kernels/slice_places.inl"
// clang-format on

// Turns between two looks for bricks to leap over: few, if the last look found some.
constexpr float kTurnsAfterLeap = 4, kTurnsBetweenLooks = 8;

// A sample a lane, at slice k of the box.
struct Sample {
  V k, value;
  V square;  // of the spread; of labels the share
  M active;
  // Gradients need these.
  V3 at;
  Place place;
};

// See surfaces.inl.
struct Stretch;
struct SliceColor;
struct AllMet;
struct JoinedWay;

// The way of a packet through a box.
template <DeviceType kType, Shading kShading>
struct Passage {
  const KernelFrame& frame;
  const KernelBox& box;
  V3 first, pace;
  V first_slice;  // the place of the box's first slice, in slices
  V ray_length;
  Cells cells;
  bool clamps;
  V in_box;            // opacity
  M going;             // lanes that take samples still
  SlicePlaces places;  // with surfaces

  HWY_INLINE Sample take(V k, V end) const {
    V3 at{hn::MulAdd(k, pace.x, first.x), hn::MulAdd(k, pace.y, first.y),
          hn::MulAdd(k, pace.z, first.z)};
    if (clamps) at = clamped(cells, at);
    const Place place = placeAt(cells, at);
    const auto [value, square] = numbersAt<kType, kShading>(frame, box, place);
    return {k, value, square, hn::Lt(k, end), at, place};
  }

  // The lanes of `within` that take a sample.
  HWY_INLINE M taking(M within, Pixels& pixels) const {
    const M active = hn::And(within, going);
    if (frame.counts_taken)
      pixels.taken = hn::Sub(pixels.taken, hn::VecFromMask(I(), hn::RebindMask(I(), active)));
    return active;
  }

  // Whether some lane goes on.
  HWY_INLINE bool blend(const Sample& sample, Pixels& pixels) {
    M shows = taking(sample.active, pixels);
    // The stand-in for NaN shows nothing.
    if (kType == DeviceType::kF32) shows = hn::AndNot(isNoNumber(sample.value), shows);
    if (kShading != Shading::kSpread && !frame.shades_every_sample) {
      shows = hn::And(shows, hn::And(hn::Ge(sample.value, all(frame.least_visible)),
                                     hn::Le(sample.value, all(frame.most_visible))));
      if (hn::AllFalse(F(), shows)) return true;
    }
    const Color color = colorOf<kType, kShading>(frame, box, sample.at, sample.place, sample.value,
                                                 sample.square, ray_length);
    return add(color, shows, sample.k, pixels);
  }

  // Blends the colour at slice k of the box. Whether some lane goes on.
  HWY_INLINE bool add(Color color, M shows, V k, Pixels& pixels) {
    layBehind(frame, color, shows, hn::Add(k, first_slice), pixels);
    // A ray ends inside a box by the opacity of this box alone, see KernelFrame::box_opacity.
    if (frame.box_opacity <= 1) {
      in_box = hn::MulAdd(hn::Sub(all(1.0F), in_box), hn::IfThenElseZero(shows, color.a), in_box);
      going = hn::And(going, hn::Lt(in_box, all(frame.box_opacity)));
    }
    // A saturated lane may keep sampling until its packet ends; it contributes nothing.
    return !hn::AllFalse(F(), hn::And(going, hn::Lt(pixels.sum.a, all(frame.ray_opacity))));
  }

  // Moves k over what does not show. Returns how many slices to take before the next look; 0: none
  // is left.
  HWY_INLINE int turnsFrom(V& k, V end, const BrickWay& way, bool leaps, bool& leapt) const {
    if (leaps) k = nextShown(box, way, k, hn::IfThenElse(going, end, k), leapt);
    float turns = hn::GetLane(hn::MaxOfLanes(F(), hn::IfThenElseZero(going, hn::Sub(end, k))));
    if (!(turns > 0)) return 0;
    if (leaps) turns = std::min(turns, leapt ? kTurnsAfterLeap : kTurnsBetweenLooks);
    return static_cast<int>(turns);
  }

  // Slices [k, end). A sample is looked up and blended while the next one is read.
  HWY_INLINE void go(V k, V end, bool leaps, Pixels& pixels) {
    const BrickWay way = leaps ? brickWay(box, first, pace) : noBrickWay();
    Sample last{k, k, k, hn::MaskFromVec(hn::Zero(F())), first, {wholeOf(k), k, k, k}};
    bool has_last = false;
    const V one = all(1.0F);
    for (;;) {
      bool leapt = false;
      const int turns = turnsFrom(k, end, way, leaps, leapt);
      if (turns == 0) break;
      for (int j = turns; j > 0; --j) {
        const Sample next = take(k, end);
        k = hn::Add(k, one);
        if constexpr (kShading == Shading::kGradients || hasTwoNumbers(kShading)) {
          if (!blend(next, pixels)) return;
        } else {
          if (has_last && !blend(last, pixels)) return;
          last = next;
          has_last = true;
        }
      }
    }
    if (has_last) blend(last, pixels);
  }

  HWY_INLINE V3 placeOf(V k, const Cells& within) const {
    return clamped(within, {hn::MulAdd(k, pace.x, first.x), hn::MulAdd(k, pace.y, first.y),
                            hn::MulAdd(k, pace.z, first.z)});
  }
  // The value at an end of a segment, which may lie in the ghost layer.
  HWY_INLINE V endAt(V k, const Cells& stored) const {
    return valueAt<kType>(box, placeAt(stored, placeOf(k, stored)));
  }

  // Slices [k, end), each with the values from half a slice before it to half a slice behind it.
  HWY_INLINE void goBySegments(V k, V end, bool leaps, Pixels& pixels) {
    const BrickWay way = leaps ? brickWay(box, first, pace) : noBrickWay();
    const Cells stored = storedCells(box);
    const V half = all(0.5F), one = all(1.0F);
    V front = k;
    Segment segment{k, k, noSums()};
    bool has_front = false;
    for (;;) {
      bool leapt = false;
      const int turns = turnsFrom(k, end, way, leaps, leapt);
      if (turns == 0) break;
      // After a leap the last end is not this one's front.
      if (!has_front || leapt) {
        front = endAt(hn::Sub(k, half), stored);
        has_front = true;
        segment.has_sums = false;
      }
      for (int j = turns; j > 0; --j, k = hn::Add(k, one)) {
        const V back = endAt(hn::Add(k, half), stored);
        M shows = taking(hn::Lt(k, end), pixels);
        V from = front, to = back;
        if constexpr (kType == DeviceType::kF32) {
          // Next to a voxel that is no number the other end stands for all.
          from = hn::IfThenElse(isNoNumber(front), back, front);
          to = hn::IfThenElse(isNoNumber(back), front, back);
          shows = hn::AndNot(isNoNumber(from), shows);
        }
        if (!frame.shades_every_sample) {
          shows = hn::And(shows, hn::And(hn::Ge(hn::Max(from, to), all(frame.least_visible)),
                                         hn::Le(hn::Min(from, to), all(frame.most_visible))));
          if (hn::AllFalse(F(), shows)) {
            // The sums belong to the value that was left behind.
            front = back;
            segment.has_sums = false;
            continue;
          }
        }
        segment.front = placeAmong(frame, from);
        segment.back = placeAmong(frame, to);
        const Extinction mean = meanOf(frame, shows, segment);
        const Color color = segmentColorOf<kType, kShading>(frame, box, placeOf(k, cells),
                                                            segment.middle(), mean, ray_length);
        if (!add(color, shows, k, pixels)) return;
        front = back;
        if (kType == DeviceType::kF32) segment.has_sums = false;
      }
    }
  }

  // The same with surfaces; surfaces.inl has these.
  void goBySurfaces(V k, V end, bool leaps, Pixels& pixels, JoinedWay* joined, int joined_count);
  V sharedEndAt(V k, const Cells& stored) const;
  void addJoined(JoinedWay& way, V k, M within, AllMet& met) const;
  template <Shading kJoined>
  void addSurfacesOf(JoinedWay& way, V k, M within, AllMet& met) const;
  void addMet(V k, M meets, const Stretch& stretch, const Cells& stored, AllMet& met) const;
  SliceColor sliceAt(V k, V end, M within) const;
  bool blendWhole(V k, V end, M within, Pixels& pixels);
  bool blendParts(V k, V end, M within, M meets, const Stretch& stretch, const Cells& stored,
                  AllMet& met, Pixels& pixels);
};

#include "src/cpu/kernels/surfaces.inl"

// The positions of the boxes that join a box, in a tile.
using JoinedPositions = std::array<Positions, kMostJoined>;

// Sets the packet's ways through the boxes that join `box`, which they follow in the list. Returns
// how many it meets.
HWY_INLINE int joinedWays(const KernelFrame& frame, const KernelBox& box,
                          const JoinedPositions& positions, const Packet& packet, const V3& step,
                          M going, JoinedWay* ways) {
  int count = 0;
  for (uint32_t i = 0; i < box.joined; ++i) {
    const KernelBox& other = (&box)[1 + i];
    const Slices slices = slicesIn(frame, other, packet, step);
    if (hn::AllFalse(F(), hn::And(going, hn::Gt(slices.count, hn::Zero(F()))))) continue;
    const V3 pace = texelsAlong(other, step);
    const float farther = box.first_slice - other.first_slice;
    const V from = hn::Sub(slices.from, all(farther));
    ways[count++] = {
        &other,
        fartherBy(packet.jitter, pace, texelsAt(other, voxelsOf(positions[i], packet))),
        pace,
        from,
        hn::Add(from, slices.count),
        farther,
        hn::Zero(F()),
        false};
  }
  return count;
}

// The box for one packet. `going`: pixels that take samples. `joined`: positions of the boxes that
// join it.
template <DeviceType kType, Shading kShading>
HWY_INLINE void drawPacket(const KernelFrame& frame, const KernelBox& box,
                           const Positions& positions, const JoinedPositions& joined,
                           const Packet& packet, M going, Pixels& pixels) {
  const V3 step = stepOf(frame, packet);
  const Slices slices = slicesIn(frame, box, packet, step);
  const M meets = hn::And(going, hn::Gt(slices.count, hn::Zero(F())));
  if (hn::AllFalse(F(), meets)) return;
  const V ray_length = kShading == Shading::kTable ? all(1.0F) : rayLengthOf(frame, packet);
  const bool clamps = needsClamps<kType, kShading>(frame, box);
  const V3 first = texelsAt(box, voxelsOf(positions, packet)), pace = texelsAlong(box, step);
  Passage<kType, kShading> passage{frame,
                                   box,
                                   fartherBy(packet.jitter, pace, first),
                                   pace,
                                   hn::Add(packet.jitter, all(box.first_slice + 0.5F)),
                                   ray_length,
                                   cellsOf(box),
                                   clamps,
                                   hn::Zero(F()),
                                   meets,
                                   slicePlacesOf(frame, packet)};
  const V end = hn::Add(slices.from, slices.count);
  if constexpr (hasSurfaces(kShading)) {
    std::array<JoinedWay, kMostJoined> ways;
    const int count = joinedWays(frame, box, joined, packet, step, meets, ways.data());
    // Bricks of this box that show nothing may hold surfaces of the others.
    passage.goBySurfaces(slices.from, end, box.distances != nullptr && count == 0, pixels,
                         ways.data(), count);
  } else if constexpr (isIntegrated(kShading))
    passage.goBySegments(slices.from, end, box.distances != nullptr, pixels);
  else
    passage.go(slices.from, end, box.distances != nullptr, pixels);
}

template <DeviceType kType, Shading kShading>
HWY_NOINLINE void drawBox(const KernelFrame& frame, const KernelBox& box, TilePixels& tile) {
  const auto [x_lo, y_lo, x_hi, y_hi] = packetsOf(box, tile);
  const Positions positions = positionsIn(box, tile);
  JoinedPositions joined;
  if constexpr (hasSurfaces(kShading))
    for (uint32_t i = 0; i < box.joined; ++i) joined[i] = positionsIn((&box)[1 + i], tile);
  for (int y = y_lo; y < y_hi; y += kPacketHeight)
    for (int x = x_lo; x < x_hi; x += kPacketWidth) {
      const int at = (y / kPacketHeight * (kTileSide / kPacketWidth) + x / kPacketWidth) * kLanes;
      const V opacity = hn::Load(F(), tile.color[3] + at);
      // Packets of stopped pixels cost one look.
      const M going = goingOf(frame, tile, at, opacity);
      if (hn::AllFalse(F(), going)) continue;
      Pixels pixels = loadPixels(frame, tile, at);
      drawPacket<kType, kShading>(frame, box, positions, joined, packetAt(frame, tile, x, y), going,
                                  pixels);
      storePixels(frame, pixels, tile, at);
    }
}

template <DeviceType kType>
HWY_INLINE void drawOne(const KernelFrame& frame, const KernelBox& box, TilePixels& tile) {
  if (box.has_spread && frame.labels)
    drawBox<kType, Shading::kShares>(frame, box, tile);
  else if (box.has_spread && frame.surfaces > 0)
    drawBox<kType, Shading::kSpreadSurfaces>(frame, box, tile);
  else if (box.has_spread)
    drawBox<kType, Shading::kSpread>(frame, box, tile);
  else if (frame.surfaces > 0)
    drawBox<kType, Shading::kSurfaces>(frame, box, tile);
  else if (frame.sums != nullptr && (frame.lit || frame.rows > 0))
    drawBox<kType, Shading::kSegmentGradients>(frame, box, tile);
  else if (frame.sums != nullptr)
    drawBox<kType, Shading::kSegments>(frame, box, tile);
  else if (frame.lit || frame.rows > 0)
    drawBox<kType, Shading::kGradients>(frame, box, tile);
  else if (frame.perspective)
    drawBox<kType, Shading::kLength>(frame, box, tile);
  else
    drawBox<kType, Shading::kTable>(frame, box, tile);
}

template <DeviceType kType>
void drawTyped(const KernelFrame& frame, const KernelBox* boxes, const uint32_t* indices,
               size_t count, TilePixels& tile) {
  constexpr size_t kBoxesBetweenLooks = 8;
  for (size_t i = 0; i < count; ++i) {
    if (i % kBoxesBetweenLooks == 0 && isThrough(frame, tile)) return;
    const KernelBox& box = boxes[indices[i]];
    const KernelFrame& of_box = !box.is_beside ? frame : box.fades ? *frame.at_seam : *frame.beside;
    if (!box.is_beside || of_box.surfaces > 0) drawOne<kType>(of_box, box, tile);
  }
}

}  // namespace

void drawComposite(const KernelFrame& frame, const KernelBox* boxes, const uint32_t* indices,
                   size_t count, TilePixels& tile) {
  switch (frame.type) {
    case DeviceType::kU8:
      return drawTyped<DeviceType::kU8>(frame, boxes, indices, count, tile);
    case DeviceType::kU16:
      return drawTyped<DeviceType::kU16>(frame, boxes, indices, count, tile);
    case DeviceType::kF32:
      return drawTyped<DeviceType::kF32>(frame, boxes, indices, count, tile);
  }
}

}  // namespace sluice::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
