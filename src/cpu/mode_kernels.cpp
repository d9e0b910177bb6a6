// Modes other than composite, and counting: the extremes and sums over the samples of a packet's
// rays.
#include <algorithm>

// Highway requires this order.
// clang-format off
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "src/cpu/mode_kernels.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
#include <hwy/contrib/math/math-inl.h>
// clang-format on

#include "src/cpu/kernel_values.h"
#include "src/cpu/packed_entries.h"

HWY_BEFORE_NAMESPACE();
namespace sluice::HWY_NAMESPACE {
namespace {
namespace hn = hwy::HWY_NAMESPACE;

// Each needs those before it.
// clang-format off
#include "src/cpu/rays.inl"
#include "src/cpu/loads.inl"
#include "src/cpu/texels.inl"
#include "src/cpu/colors.inl"
// clang-format on

// The samples of a packet's rays in a box: `count` samples at first + clamp(j, from, to) * pace, in
// texels.
struct Line {
  V3 first, pace;
  V count, from, to;
};
HWY_INLINE Line lineOf(const KernelFrame& frame, const KernelBox& box, const Positions& positions,
                       const Packet& packet) {
  const V3 step = stepOf(frame, packet);
  if (frame.on_planes) {
    const Planes planes = planesIn(frame, box, positions, packet, step);
    const V3 start{hn::MulAdd(planes.from, planes.way.x, planes.start.x),
                   hn::MulAdd(planes.from, planes.way.y, planes.start.y),
                   hn::MulAdd(planes.from, planes.way.z, planes.start.z)};
    return {texelsAt(box, start), texelsAlong(box, planes.way), planes.count, planes.first,
            planes.last};
  }
  const Slices slices = slicesIn(frame, box, packet, step);
  const V3 start = texelsAt(box, voxelsOf(positions, packet));
  const V3 pace = texelsAlong(box, step);
  return {{hn::MulAdd(slices.from, pace.x, start.x), hn::MulAdd(slices.from, pace.y, start.y),
           hn::MulAdd(slices.from, pace.z, start.z)},
          pace,
          slices.count,
          hn::Zero(F()),
          slices.count};
}

// Snaps to a plane of voxels if only rounding keeps it away: next to a NaN voxel, the least part of
// it would make the sample NaN.
HWY_INLINE V settled(V at) {
  constexpr float kOnPlane = 1e-4F;
  const V plane = hn::Round(at);
  return hn::IfThenElse(hn::Lt(hn::Abs(hn::Sub(at, plane)), all(kOnPlane)), plane, at);
}

// kSpread: of a chunk with spreads, whose means alone count.
template <DeviceType kType, bool kSpread>
HWY_INLINE void drawPacket(const KernelFrame& frame, const KernelBox& box,
                           const Positions& positions, const Packet& packet, V& value_sum,
                           V& part_sum) {
  const Line line = lineOf(frame, box, positions, packet);
  const float most = hn::GetLane(hn::MaxOfLanes(F(), line.count));
  const Cells cells = cellsOf(box);
  for (int j = 0; j < static_cast<int>(most); ++j) {
    const V turn = all(static_cast<float>(j));
    const V place = hn::Min(hn::Max(turn, line.from), line.to);
    V3 at{hn::MulAdd(place, line.pace.x, line.first.x),
          hn::MulAdd(place, line.pace.y, line.first.y),
          hn::MulAdd(place, line.pace.z, line.first.z)};
    if (frame.on_planes) at = {settled(at.x), settled(at.y), settled(at.z)};
    const Place texels = placeAt(cells, clamped(cells, at));
    V value;
    if constexpr (kSpread)
      value = meanAt<kType>(box, texels);
    else
      value = valueAt<kType>(box, texels);
    M counts = hn::Lt(turn, line.count);
    if (kType == DeviceType::kF32) counts = hn::AndNot(isNoNumber(value), counts);
    const V part = hn::IfThenElseZero(counts, partAt(frame, entryOf(frame, value)));
    const M shows = hn::Gt(part, hn::Zero(F()));
    if (hn::AllFalse(F(), shows)) continue;
    // A sample's part moves its value toward the end that loses.
    const V rest = hn::Sub(all(1.0F), part);
    if (frame.combining == Combining::kGreatest) {
      const V moved = between(all(frame.least), value, part, rest);
      value_sum = hn::IfThenElse(shows, hn::Max(value_sum, moved), value_sum);
      part_sum = hn::IfThenElse(shows, hn::Max(part_sum, part), part_sum);
    } else if (frame.combining == Combining::kLeast) {
      const V moved = between(all(frame.greatest), value, part, rest);
      value_sum = hn::IfThenElse(shows, hn::Min(value_sum, moved), value_sum);
      part_sum = hn::IfThenElse(shows, hn::Min(part_sum, rest), part_sum);
    } else {
      value_sum = hn::IfThenElse(shows, hn::MulAdd(value, part, value_sum), value_sum);
      part_sum = hn::Add(part_sum, part);
    }
  }
}

template <DeviceType kType>
HWY_NOINLINE void drawBox(const KernelFrame& frame, const KernelBox& box, TilePixels& tile) {
  const auto [x_lo, y_lo, x_hi, y_hi] = packetsOf(box, tile);
  const Positions positions = positionsIn(box, tile);
  for (int y = y_lo; y < y_hi; y += kPacketHeight)
    for (int x = x_lo; x < x_hi; x += kPacketWidth) {
      const int at = (y / kPacketHeight * (kTileSide / kPacketWidth) + x / kPacketWidth) * kLanes;
      V value = hn::Load(F(), tile.color[0] + at), part = hn::Load(F(), tile.color[1] + at);
      const Packet packet = packetAt(frame, tile, x, y);
      if (box.has_spread)
        drawPacket<kType, true>(frame, box, positions, packet, value, part);
      else
        drawPacket<kType, false>(frame, box, positions, packet, value, part);
      hn::Store(value, F(), tile.color[0] + at);
      hn::Store(part, F(), tile.color[1] + at);
    }
}

}  // namespace

void drawOtherMode(const KernelFrame& frame, const KernelBox* boxes, const uint32_t* indices,
                   size_t count, TilePixels& tile) {
  for (size_t i = 0; i < count; ++i) {
    const KernelBox& box = boxes[indices[i]];
    switch (frame.type) {
      case DeviceType::kU8:
        drawBox<DeviceType::kU8>(frame, box, tile);
        break;
      case DeviceType::kU16:
        drawBox<DeviceType::kU16>(frame, box, tile);
        break;
      case DeviceType::kF32:
        drawBox<DeviceType::kF32>(frame, box, tile);
        break;
    }
  }
}

uint64_t countSamples(const KernelFrame& frame, const KernelBox* boxes, const uint32_t* indices,
                      size_t count, const TilePixels& tile) {
  uint64_t samples = 0;
  for (size_t i = 0; i < count; ++i) {
    const KernelBox& box = boxes[indices[i]];
    const auto [x_lo, y_lo, x_hi, y_hi] = packetsOf(box, tile);
    const Positions positions = positionsIn(box, tile);
    for (int y = y_lo; y < y_hi; y += kPacketHeight)
      for (int x = x_lo; x < x_hi; x += kPacketWidth) {
        const Packet packet = packetAt(frame, tile, x, y);
        const V3 step = stepOf(frame, packet);
        const V found = frame.on_planes ? planesIn(frame, box, positions, packet, step).count
                                        : slicesIn(frame, box, packet, step).count;
        samples +=
            static_cast<uint64_t>(hn::GetLane(hn::SumOfLanes(I(), hn::ConvertTo(I(), found))));
      }
  }
  return samples;
}

void packetShape(int& width, int& height) {
  width = kPacketWidth;
  height = kPacketHeight;
}

}  // namespace sluice::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
