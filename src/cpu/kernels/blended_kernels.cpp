// Composite of several channels as one medium, see FrameSetup::others: a packet of pixels goes
// through the boxes of a block together, each with the texels and the look of its channel.
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

// Highway requires this order.
// clang-format off
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "src/cpu/kernels/blended_kernels.cpp"
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
#include "src/cpu/kernels/label_slopes.inl"
#include "src/cpu/kernels/leaps.inl"
#include "src/cpu/kernels/segments.inl"
#include "src/cpu/kernels/sample_colors.inl"
#include "src/cpu/kernels/pixels.inl"
#include "src/cpu/kernels/mixtures.inl"
// clang-format on

// The places of a packet's samples in the slices between two looks. Bit j of `known` is set if the
// place of slice j is.
struct Places {
  std::array<Place, kSlicesAtOnce> of;
  uint32_t known = 0;
};

// The places of a packet's samples in a box.
struct Line {
  V3 first, pace;  // texel coordinates at slice `start`, and from slice to slice
  V start;
  Cells cells;
};
HWY_INLINE V3 placeOn(const Line& line, const V& slice, bool clamps) {
  const V3 at = fartherBy(hn::Sub(slice, line.start), line.pace, line.first);
  return clamps ? clamped(line.cells, at) : at;
}

// The way of a packet through a channel's box. Slices count as FrameSetup has them.
struct ChannelWay {
  const KernelFrame* frame;
  const KernelBox* box;
  Line line;
  V from, end;
  V ray_length;
  BrickWay bricks;
  // No slice before it shows anything, as far as is known; the block's end for lanes that are
  // through the box.
  V shown;
  uint32_t places;    // whose Places these samples have, see placesOf()
  float window_rows;  // about how many a window has, see side_by_side.inl
  // Slices k + first, ..., k + last - 1 are sampled next, see drawBlock().
  int first, last;
};

using SliceValues = std::array<V, kSlicesAtOnce>;

// Adds the channel's samples to the mixtures of slices from k on. `places` are shared by the
// channels whose samples have the same ones.
using AddSamples = void (*)(const ChannelWay& way, const V& k, const M& going, Places& places,
                            Mixtures& mixtures, VI& taken);
// The same of samples that are read already.
using AddValues = void (*)(const ChannelWay& way, const V& k, const M& going,
                           const SliceValues& values, Mixtures& mixtures, VI& taken);

// A channel adds its samples by these: in boxes of one number a texel, and of two.
struct Adding {
  AddSamples one = nullptr, two = nullptr;
  AddValues values = nullptr;  // in boxes of one number; null if samples are read one by one

  AddSamples of(const KernelBox& box) const { return box.has_spread ? two : one; }
  AddValues valuesOf(const KernelBox& box) const { return box.has_spread ? nullptr : values; }
};

// The ways of a packet through a block's boxes.
struct BlockWay {
  std::array<ChannelWay, kMostBlended> ways;
  std::array<AddSamples, kMostBlended> adds;
  std::array<AddValues, kMostBlended> adds_values;
  int count = 0;
  V from, end;  // of all
  V middle;     // of a slice, in slices
};

#include "src/cpu/kernels/side_by_side.inl"

template <DeviceType kType, Shading kShading>
HWY_NOINLINE void addSamples(const ChannelWay& way, const V& k, const M& going, Places& places,
                             Mixtures& mixtures, VI& taken) {
  const KernelFrame& frame = *way.frame;
  const KernelBox& box = *way.box;
  const V one = all(1.0F);
  const bool selects = kShading != Shading::kSpread && !frame.shades_every_sample;
  const V least = all(frame.least_visible), most = all(frame.most_visible);
  const Line line = way.line;
  const V from = way.from, end = way.end;
  const int first = way.first, last = way.last;
  // All samples are read before the first gets its colour. Whether a sample shows is a branch that
  // the processor often guesses wrong, and it would throw away what it had read ahead.
  struct Sample {
    M shows;
    V value, square;
  };
  std::array<Sample, kSlicesAtOnce> samples;
  const bool clamps = needsClamps<kType, kShading>(frame, box);
  // Places come first: they are a long chain of steps, and the processor works on those of several
  // slices at once.
  for (int j = first; j < last; ++j) {
    if ((places.known >> j & 1) != 0) continue;
    const V slice = hn::Add(k, all(static_cast<float>(j)));
    places.of[static_cast<size_t>(j)] = placeAt(line.cells, placeOn(line, slice, clamps));
    places.known |= uint32_t{1} << j;
  }
  VI counted = hn::Zero(I());
  V slice = hn::Add(k, all(static_cast<float>(first)));
  for (int j = first; j < last; ++j, slice = hn::Add(slice, one)) {
    M shows = hn::And(going, hn::And(hn::Ge(slice, from), hn::Lt(slice, end)));
    counted = hn::Sub(counted, hn::VecFromMask(I(), hn::RebindMask(I(), shows)));
    const Numbers numbers =
        numbersAt<kType, kShading>(frame, box, places.of[static_cast<size_t>(j)]);
    if (kType == DeviceType::kF32) shows = hn::AndNot(isNoNumber(numbers.value), shows);
    if (selects)
      shows = hn::And(shows, hn::And(hn::Ge(numbers.value, least), hn::Le(numbers.value, most)));
    samples[static_cast<size_t>(j)] = {shows, numbers.value, numbers.square};
  }
  if (frame.counts_taken) taken = hn::Add(taken, counted);
  slice = hn::Add(k, all(static_cast<float>(first)));
  for (int j = first; j < last; ++j, slice = hn::Add(slice, one)) {
    const auto& [shows, value, square] = samples[static_cast<size_t>(j)];
    if (hn::AllFalse(F(), shows)) continue;
    addColor(
        colorOf<kType, kShading>(frame, box, placeOn(line, slice, clamps),
                                 places.of[static_cast<size_t>(j)], value, square, way.ray_length),
        shows, j, mixtures);
  }
}

template <DeviceType kType>
Adding addingTyped(const KernelFrame& frame) {
  const AddSamples two =
      frame.labels ? &addSamples<kType, Shading::kShares> : &addSamples<kType, Shading::kSpread>;
  if (frame.lit || frame.rows > 0) return {&addSamples<kType, Shading::kGradients>, two};
  // Packets of four rays gain nothing: copying texels takes as long as the loads that it saves.
  const bool reads_values = kLanes >= 8 && kType == DeviceType::kU8 && !frame.labels;
  if (frame.perspective)
    return {&addSamples<kType, Shading::kLength>, two,
            reads_values ? &addValues<Shading::kLength> : nullptr};
  return {&addSamples<kType, Shading::kTable>, two,
          reads_values ? &addValues<Shading::kTable> : nullptr};
}
Adding addingOf(const KernelFrame& frame) {
  switch (frame.type) {
    case DeviceType::kU8:
      return addingTyped<DeviceType::kU8>(frame);
    case DeviceType::kU16:
      return addingTyped<DeviceType::kU16>(frame);
    case DeviceType::kF32:
      break;
  }
  return addingTyped<DeviceType::kF32>(frame);
}

HWY_INLINE void addWay(const KernelFrame& frame, const KernelBox& box, const Positions& positions,
                       const Packet& packet, const V3& step, const Adding& adding, uint32_t places,
                       BlockWay& all_ways) {
  const Slices slices = slicesIn(frame, box, packet, step);
  const M meets = hn::Gt(slices.count, hn::Zero(F()));
  // Channels whose box the packet misses cost nothing.
  if (hn::AllFalse(F(), meets)) return;
  ChannelWay& way = all_ways.ways[static_cast<size_t>(all_ways.count)];
  const bool is_long = frame.perspective || frame.lit || frame.rows > 0;
  way.frame = &frame;
  way.box = &box;
  const V3 pace = texelsAlong(box, step);
  way.line = {fartherBy(packet.jitter, pace, texelsAt(box, voxelsOf(positions, packet))), pace,
              all(box.first_slice), cellsOf(box)};
  const V never = all(1e15F);
  // Lanes that miss the box are never within it.
  way.from = hn::IfThenElse(meets, hn::Add(slices.from, way.line.start), never);
  way.end = hn::IfThenElse(meets, hn::Add(way.from, slices.count), hn::Neg(never));
  way.ray_length = is_long ? rayLengthOf(frame, packet) : all(1.0F);
  way.shown = way.from;
  way.bricks = box.distances != nullptr ? brickWay(box, way.line.first, pace) : noBrickWay();
  way.places = places;
  way.window_rows = windowRows(box, pace);
  all_ways.adds[static_cast<size_t>(all_ways.count)] = adding.of(box);
  all_ways.adds_values[static_cast<size_t>(all_ways.count)] = adding.valuesOf(box);
  all_ways.from = all_ways.count == 0 ? way.from : hn::Min(all_ways.from, way.from);
  all_ways.end = all_ways.count == 0 ? way.end : hn::Max(all_ways.end, way.end);
  ++all_ways.count;
}

// The first slices from k on at which some channel may show something; sets each way's own.
HWY_INLINE V nextSlices(BlockWay& block, const V& k, const M& going) {
  V next = block.end;
  for (int c = 0; c < block.count; ++c) {
    ChannelWay& way = block.ways[static_cast<size_t>(c)];
    const M unseen = hn::And(going, hn::And(hn::Le(way.shown, k), hn::Lt(k, way.end)));
    V shown = hn::Max(k, way.shown);
    // A channel that is known to show nothing yet needs no look.
    if (way.box->distances != nullptr && !hn::AllFalse(F(), unseen)) {
      bool leapt = false;
      const M asked = hn::And(going, hn::Lt(shown, way.end));
      const V at = hn::IfThenElse(asked, hn::Sub(shown, way.line.start), hn::Zero(F()));
      const V end = hn::IfThenElse(asked, hn::Sub(way.end, way.line.start), hn::Zero(F()));
      shown = hn::IfThenElse(
          asked, hn::Add(nextShown(*way.box, way.bricks, at, end, leapt), way.line.start), shown);
    }
    // Lanes through this box wait at the block's end, so that they do not hold back the others.
    way.shown = hn::IfThenElse(hn::Lt(shown, way.end), shown, block.end);
    next = hn::Min(next, way.shown);
  }
  return next;
}

// Sets the slices that some lane has in the box, from the first on that may show something.
HWY_INLINE void setSlices(const V& k, int slices, const M& going, ChannelWay& way) {
  way.first = way.last = 0;
  const M within = hn::And(going, hn::Lt(way.shown, way.end));
  if (hn::AllFalse(F(), within)) return;
  const V far = all(static_cast<float>(slices));
  const V from = hn::IfThenElse(within, hn::Sub(way.shown, k), far);
  const V to = hn::IfThenElseZero(within, hn::Min(hn::Sub(way.end, k), far));
  way.first = static_cast<int>(
      std::max(0.0F, std::min(kMostAtOnce, hn::GetLane(hn::MinOfLanes(F(), from)))));
  way.last = static_cast<int>(hn::GetLane(hn::MaxOfLanes(F(), to)));
}

// The block for one packet.
HWY_INLINE void drawBlock(const KernelFrame& frame, BlockWay& block, const M& going_at_first,
                          Pixels& pixels) {
  M going = going_at_first;
  V in_box = hn::Zero(F());
  V k = block.from;
  Mixtures mixtures;
  std::array<Places, kMostBlended> places;  // the boxes', not the ways'
  std::array<SliceValues, kMostBlended> values;
  const V one = all(1.0F);
  for (;;) {
    k = nextSlices(block, k, going);
    const V left = hn::IfThenElseZero(going, hn::Sub(block.end, k));
    const float most = hn::GetLane(hn::MaxOfLanes(F(), left));
    if (!(most > 0)) return;
    const int slices = static_cast<int>(std::min<float>(most, kSlicesAtOnce));
    mixtures.shown = mixtures.mixed = 0;
    for (int c = 0; c < block.count; ++c)
      places[block.ways[static_cast<size_t>(c)].places].known = 0;
    for (int c = 0; c < block.count; ++c)
      setSlices(k, slices, going, block.ways[static_cast<size_t>(c)]);
    const uint32_t read = readTogether(block, k, going, values);
    for (int c = 0; c < block.count; ++c) {
      const auto i = static_cast<size_t>(c);
      const ChannelWay& way = block.ways[i];
      if (way.first >= way.last) continue;
      if ((read >> c & 1) != 0)
        block.adds_values[i](way, k, going, values[i], mixtures, pixels.taken);
      else
        block.adds[i](way, k, going, places[way.places], mixtures, pixels.taken);
    }
    for (uint32_t rest = mixtures.shown; rest != 0; rest &= rest - 1) {
      const int j = std::countr_zero(rest);
      const Mixture& mixture = mixtures.of[static_cast<size_t>(j)];
      const Color color = (mixtures.mixed >> j & 1) != 0 ? colorOf(mixture) : mixture.sum;
      const V slice = hn::Add(k, all(static_cast<float>(j)));
      layBehind(frame, color, going, hn::Add(slice, block.middle), pixels);
      if (frame.box_opacity <= 1) {
        in_box = hn::MulAdd(hn::Sub(one, in_box), hn::IfThenElseZero(going, color.a), in_box);
        going = hn::And(going, hn::Lt(in_box, all(frame.box_opacity)));
      }
      going = hn::And(going, hn::Lt(pixels.sum.a, all(frame.ray_opacity)));
      if (hn::AllFalse(F(), going)) return;
    }
    k = hn::Add(k, all(static_cast<float>(slices)));
  }
}

// Whether the samples of two boxes lie at the same places in texels of the same layout.
bool havePlacesAlike(const KernelBox& a, const KernelBox& b) {
  return a.voxel0 == b.voxel0 && a.size == b.size && a.axes == b.axes &&
         a.texel_scale == b.texel_scale && a.texel_start == b.texel_start &&
         a.texel_hi == b.texel_hi && a.last_cell == b.last_cell && a.stride == b.stride &&
         a.clamps == b.clamps;
}

// Returns, for each of a block's boxes, the first one whose samples have the same places. Kinds of
// samples differ in whether places are clamped to the box.
std::array<uint32_t, kMostBlended> placesOf(const KernelFrame* const* frames, const Adding* adds,
                                            const KernelBox* boxes) {
  std::array<uint32_t, kMostBlended> places;
  for (uint32_t i = 0; i <= boxes[0].joined; ++i) {
    const KernelBox& box = boxes[i];
    places[i] = 0;
    while (places[i] < i) {
      const KernelBox& other = boxes[places[i]];
      if (adds[box.channel].of(box) == adds[other.channel].of(other) &&
          frames[box.channel]->labels == frames[other.channel]->labels &&
          havePlacesAlike(box, other))
        break;
      ++places[i];
    }
  }
  return places;
}

// The box at the front of a block's boxes, and those that join it.
HWY_NOINLINE void drawBoxes(const KernelFrame* const* frames, const Adding* adds,
                            const KernelBox* boxes, TilePixels& tile) {
  const KernelFrame& frame = *frames[0];
  const auto [x_lo, y_lo, x_hi, y_hi] = packetsOf(boxes[0], tile);
  std::array<Positions, kMostBlended> positions;
  for (uint32_t i = 0; i <= boxes[0].joined; ++i) positions[i] = positionsIn(boxes[i], tile);
  const std::array<uint32_t, kMostBlended> places = placesOf(frames, adds, boxes);
  for (int y = y_lo; y < y_hi; y += kPacketHeight)
    for (int x = x_lo; x < x_hi; x += kPacketWidth) {
      const int at = (y / kPacketHeight * (kTileSide / kPacketWidth) + x / kPacketWidth) * kLanes;
      Pixels pixels = loadPixels(frame, tile, at);
      const M going = goingOf(frame, tile, at, pixels.sum.a);
      if (hn::AllFalse(F(), going)) continue;
      const Packet packet = packetAt(frame, tile, x, y);
      const V3 step = stepOf(frame, packet);
      BlockWay block;
      block.middle = hn::Add(packet.jitter, all(0.5F));
      for (uint32_t i = 0; i <= boxes[0].joined; ++i) {
        const uint32_t channel = boxes[i].channel;
        addWay(*frames[channel], boxes[i], positions[i], packet, step, adds[channel], places[i],
               block);
      }
      if (block.count == 0) continue;
      drawBlock(frame, block, going, pixels);
      storePixels(frame, pixels, tile, at);
    }
}

}  // namespace

void drawBlended(const KernelFrame* const* frames, size_t channels, const KernelBox* boxes,
                 const uint32_t* indices, size_t count, TilePixels& tile) {
  std::array<Adding, kMostBlended> adds{};
  for (size_t c = 0; c < channels; ++c) adds[c] = addingOf(*frames[c]);
  constexpr size_t kBlocksBetweenLooks = 8;
  for (size_t i = 0; i < count; ++i) {
    if (i % kBlocksBetweenLooks == 0 && isThrough(*frames[0], tile)) return;
    drawBoxes(frames, adds.data(), boxes + indices[i], tile);
  }
}

}  // namespace sluice::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
