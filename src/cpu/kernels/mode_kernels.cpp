// Modes other than composite, and counting: the numbers of Combining over the samples of a packet's
// rays.
#include <algorithm>

// Highway requires this order.
// clang-format off
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "src/cpu/kernels/mode_kernels.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
#include <hwy/contrib/math/math-inl.h>
// clang-format on

#include "src/cpu/kernels/kernel_set.h"
#include "src/cpu/kernels/kernel_values.h"
#include "src/cpu/kernels/packed_entries.h"
#include "src/device/pictures/blue_noise.h"
#include "src/device/pictures/depth_code.h"

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

// The numbers of a packet's pixels, see Combining.
struct Numbers {
  V of[3];
};

// The places of values in FrameSetup::window.
HWY_INLINE V placeIn(const KernelFrame& frame, V value) {
  const V place = hn::Mul(hn::Sub(value, all(frame.window_lo)), all(frame.window_scale));
  return hn::Min(hn::Max(place, hn::Zero(F())), all(1.0F));
}

// Takes samples whose colour is made by depth, see depth_code.h.
HWY_INLINE void takeDepth(const KernelFrame& frame, const KernelBox& box, const V3& at, V value,
                          V part, M shows, Numbers& numbers) {
  constexpr auto kNearest = static_cast<float>(kDepthSteps - 1);
  const V depth = hn::Add(dot3(box.depth_along, at), all(box.depth_start));
  const V within = hn::Min(hn::Max(depth, hn::Zero(F())), all(1.0F));
  const V nearness = hn::Floor(hn::NegMulAdd(within, all(kNearest), all(kNearest + 0.5F)));
  const V step = hn::Floor(hn::MulAdd(hn::Mul(placeIn(frame, value), part), all(kPlaceSteps),
                                      all(static_cast<float>(kPlaceShift))));
  const V code = hn::MulAdd(step, all(kDepthSteps), nearness);
  auto& [first, second, third] = numbers.of;
  first = hn::IfThenElse(shows, hn::Max(first, code), first);
  second = hn::IfThenElse(shows, hn::Max(second, part), second);
}

// Takes samples of these values and parts, those that show something. `attenuation`: of the way
// from sample to sample.
HWY_INLINE void takeSample(const KernelFrame& frame, V value, V part, V attenuation, M shows,
                           Numbers& numbers) {
  const V one = all(1.0F), rest = hn::Sub(one, part);
  auto& [first, second, third] = numbers.of;
  // A sample's part moves its value toward the end that loses, so that a hidden sample changes
  // nothing.
  switch (frame.combining) {
    case Combining::kGreatest: {
      const V moved = between(all(frame.least), value, part, rest);
      first = hn::IfThenElse(shows, hn::Max(first, moved), first);
      second = hn::IfThenElse(shows, hn::Max(second, part), second);
      return;
    }
    case Combining::kLeast: {
      const V moved = between(all(frame.greatest), value, part, rest);
      first = hn::IfThenElse(shows, hn::Min(first, moved), first);
      second = hn::IfThenElse(shows, hn::Min(second, rest), second);
      return;
    }
    case Combining::kAttenuated: {
      const V level = hn::IfThenElseZero(shows, hn::Mul(placeIn(frame, value), part));
      const V clear = hn::Sub(one, second);
      // The attenuated maximum: a sample counts by what passes of it to the eye.
      first = hn::Max(first, hn::Mul(clear, level));
      const V dimmed = hn::Sub(one, hn::Exp(F(), hn::Neg(hn::Mul(attenuation, level))));
      second = hn::MulAdd(clear, dimmed, second);
      third = hn::Max(third, part);
      return;
    }
    case Combining::kSum:
    case Combining::kBlend:
      break;
  }
  first = hn::IfThenElse(shows, hn::MulAdd(value, part, first), first);
  second = hn::Add(second, part);
}

// kSpread: of a chunk with spreads, whose means alone count.
template <DeviceType kType, bool kSpread>
HWY_INLINE void drawPacket(const KernelFrame& frame, const KernelBox& box,
                           const Positions& positions, const Packet& packet, Numbers& numbers) {
  const Line line = lineOf(frame, box, positions, packet);
  const float most = hn::GetLane(hn::MaxOfLanes(F(), line.count));
  const Cells cells = cellsOf(box);
  const V attenuation = hn::Mul(all(frame.attenuation), rayLengthOf(frame, packet));
  for (int j = 0; j < static_cast<int>(most); ++j) {
    const V turn = all(static_cast<float>(j));
    // The ends of a ray's way are no planes, and are taken as its first and last sample.
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
    if (frame.codes_depth)
      takeDepth(frame, box, at, value, part, shows, numbers);
    else
      takeSample(frame, value, part, attenuation, shows, numbers);
  }
}

template <DeviceType kType>
HWY_NOINLINE void drawBox(const KernelFrame& frame, const KernelBox& box, TilePixels& tile) {
  const auto [x_lo, y_lo, x_hi, y_hi] = packetsOf(box, tile);
  const Positions positions = positionsIn(box, tile);
  for (int y = y_lo; y < y_hi; y += kPacketHeight)
    for (int x = x_lo; x < x_hi; x += kPacketWidth) {
      const int at = (y / kPacketHeight * (kTileSide / kPacketWidth) + x / kPacketWidth) * kLanes;
      Numbers numbers;
      for (size_t i = 0; i < 3; ++i) numbers.of[i] = hn::Load(F(), tile.color[i] + at);
      const Packet packet = packetAt(frame, tile, x, y);
      if (box.has_spread)
        drawPacket<kType, true>(frame, box, positions, packet, numbers);
      else
        drawPacket<kType, false>(frame, box, positions, packet, numbers);
      for (size_t i = 0; i < 3; ++i) hn::Store(numbers.of[i], F(), tile.color[i] + at);
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
#endif
