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
void drawComposite(const KernelFrame& frame, const KernelBox* boxes, const uint32_t* indices,
                   size_t count, TilePixels& tile);
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
#include "src/cpu/kernels/mixtures.inl"
// clang-format on

#include "src/cpu/kernels/channel_ways.inl"
#include "src/cpu/kernels/side_by_side.inl"

template <DeviceType kType, Shading kShading, class Into>
HWY_NOINLINE bool addSamples(const ChannelWay& way, const V& k, const M& going, Places& places,
                             Into& into, VI& taken) {
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
    const Color color =
        colorOf<kType, kShading>(frame, box, placeOn(line, slice, clamps),
                                 places.of[static_cast<size_t>(j)], value, square, way.ray_length);
    if (!show(way, color, shows, hn::Add(slice, way.middle), j, into)) return false;
  }
  return true;
}

template <class Into, DeviceType kType>
Adding<Into> addingTyped(const KernelFrame& frame) {
  const AddSamples<Into> two = frame.labels ? &addSamples<kType, Shading::kShares, Into>
                                            : &addSamples<kType, Shading::kSpread, Into>;
  // Packets of four rays gain nothing: copying texels takes as long as the loads that it saves.
  const bool reads_values = kLanes >= 8 && kType == DeviceType::kU8 && !frame.labels;
  if (frame.lit || frame.rows > 0)
    return {&addSamples<kType, Shading::kGradients, Into>, two,
            reads_values ? &addValues<Shading::kGradients, Into> : nullptr, true};
  if (frame.perspective)
    return {&addSamples<kType, Shading::kLength, Into>, two,
            reads_values ? &addValues<Shading::kLength, Into> : nullptr};
  return {&addSamples<kType, Shading::kTable, Into>, two,
          reads_values ? &addValues<Shading::kTable, Into> : nullptr};
}
template <class Into>
Adding<Into> addingOf(const KernelFrame& frame) {
  switch (frame.type) {
    case DeviceType::kU8:
      return addingTyped<Into, DeviceType::kU8>(frame);
    case DeviceType::kU16:
      return addingTyped<Into, DeviceType::kU16>(frame);
    case DeviceType::kF32:
      break;
  }
  return addingTyped<Into, DeviceType::kF32>(frame);
}

HWY_INLINE bool addWay(const KernelFrame& frame, const KernelBox& box, const Positions& positions,
                       const Packet& packet, const V3& step, bool reads_values, uint32_t places,
                       BlockWay& all_ways) {
  const Slices slices = slicesIn(frame, box, packet, step);
  const M meets = hn::Gt(slices.count, hn::Zero(F()));
  // Channels whose box the packet misses cost nothing.
  if (hn::AllFalse(F(), meets)) return false;
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
  way.middle = hn::Add(packet.jitter, all(0.5F));
  if (reads_values) all_ways.reads_values |= uint32_t{1} << all_ways.count;
  all_ways.from = all_ways.count == 0 ? way.from : hn::Min(all_ways.from, way.from);
  all_ways.end = all_ways.count == 0 ? way.end : hn::Max(all_ways.end, way.end);
  ++all_ways.count;
  return true;
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

// The adding of a block's ways.
template <class Into>
using BlockAdding = std::array<const Adding<Into>*, kMostBlended>;

// The samples of the channels in some slices between two looks.
struct SlicesRead {
  std::array<Places, kMostBlended> places;  // the boxes', not the ways'
  std::array<SliceValues, kMostBlended> values;
};

// Moves k to the next slices that may show something, and shows the ways' samples in them: way c
// in into(c). Returns how many slices these are; 0: none is left. `ended(c)`: way c goes on no
// more.
template <class Into, class IntoOf, class Ended>
HWY_INLINE int showSlices(const BlockAdding<Into>& adding, BlockWay& block, V& k, const M& going,
                          SlicesRead& room, VI& taken, const IntoOf& into, const Ended& ended) {
  k = nextSlices(block, k, going);
  const V left = hn::IfThenElseZero(going, hn::Sub(block.end, k));
  const float most = hn::GetLane(hn::MaxOfLanes(F(), left));
  if (!(most > 0)) return 0;
  const int slices = static_cast<int>(std::min<float>(most, kSlicesAtOnce));
  for (int c = 0; c < block.count; ++c)
    room.places[block.ways[static_cast<size_t>(c)].places].known = 0;
  for (int c = 0; c < block.count; ++c)
    setSlices(k, slices, going, block.ways[static_cast<size_t>(c)]);
  const uint32_t read = readTogether(block, k, going, room.values);
  for (int c = 0; c < block.count; ++c) {
    const auto i = static_cast<size_t>(c);
    const ChannelWay& way = block.ways[i];
    if (way.first >= way.last) continue;
    const bool goes_on =
        (read >> c & 1) != 0
            ? adding[i]->values(way, k, going, room.values[i], into(i), taken)
            : adding[i]->of(*way.box)(way, k, going, room.places[way.places], into(i), taken);
    if (!goes_on) ended(i);
  }
  return slices;
}

// The block for one packet, as one medium.
HWY_INLINE void drawBlock(const KernelFrame& frame, const BlockAdding<Mixtures>& adding,
                          BlockWay& block, const M& going_at_first, Pixels& pixels) {
  M going = going_at_first;
  V in_box = hn::Zero(F());
  V k = block.from;
  Mixtures mixtures;
  SlicesRead room;
  const V one = all(1.0F);
  const auto into = [&](size_t) -> Mixtures& { return mixtures; };
  for (;;) {
    mixtures.shown = mixtures.mixed = 0;
    const int slices =
        showSlices<Mixtures>(adding, block, k, going, room, pixels.taken, into, [](size_t) {});
    if (slices == 0) return;
    for (uint32_t rest = mixtures.shown; rest != 0; rest &= rest - 1) {
      const int j = std::countr_zero(rest);
      const Mixture& mixture = mixtures.of[static_cast<size_t>(j)];
      const Color color = (mixtures.mixed >> j & 1) != 0 ? colorOf(mixture) : mixture.sum;
      const V slice = hn::Add(k, all(static_cast<float>(j)));
      layBehind(frame, color, going, hn::Add(slice, block.ways[0].middle), pixels);
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

// The block for one packet, each channel with pixels of its own.
HWY_INLINE void drawBlock(const BlockAdding<ChannelPixels>& adding, BlockWay& block,
                          std::array<ChannelPixels, kMostBlended>& channels) {
  SlicesRead room;
  V k = block.from;
  M going = hn::MaskFromVec(hn::Zero(F()));
  for (size_t c = 0; c < static_cast<size_t>(block.count); ++c)
    going = hn::Or(going, channels[c].going);
  VI taken = hn::Zero(I());
  const auto into = [&](size_t c) -> ChannelPixels& { return channels[c]; };
  const auto ended = [&](size_t c) { block.ways[c].end = all(-1e15F); };
  while (const int slices =
             showSlices<ChannelPixels>(adding, block, k, going, room, taken, into, ended))
    k = hn::Add(k, all(static_cast<float>(slices)));
}

// Calls draw(at, block, adding, add) for each packet that may see the boxes. add(i) adds the
// packet's way through box i to the block, and returns false if the packet misses it.
template <class Into, class Draw>
HWY_INLINE void eachPacket(const KernelFrame* const* frames, const Adding<Into>* adds,
                           const KernelBox* boxes, const TilePixels& tile, const Draw& draw) {
  const KernelFrame& frame = *frames[0];
  const auto [x_lo, y_lo, x_hi, y_hi] = packetsOf(boxes[0], tile);
  std::array<Positions, kMostBlended> positions;
  for (uint32_t i = 0; i <= boxes[0].joined; ++i) positions[i] = positionsIn(boxes[i], tile);
  const std::array<uint32_t, kMostBlended> places = placesOf(frames, adds, boxes);
  for (int y = y_lo; y < y_hi; y += kPacketHeight)
    for (int x = x_lo; x < x_hi; x += kPacketWidth) {
      const int at = (y / kPacketHeight * (kTileSide / kPacketWidth) + x / kPacketWidth) * kLanes;
      const Packet packet = packetAt(frame, tile, x, y);
      const V3 step = stepOf(frame, packet);
      BlockWay block;
      BlockAdding<Into> adding;
      const auto add = [&](uint32_t i) {
        const uint32_t channel = boxes[i].channel;
        adding[static_cast<size_t>(block.count)] = &adds[channel];
        return addWay(*frames[channel], boxes[i], positions[i], packet, step,
                      adds[channel].valuesOf(boxes[i]) != nullptr, places[i], block);
      };
      draw(at, block, adding, add);
    }
}

// The box at the front of a block's boxes, and those that join it, as one medium.
HWY_NOINLINE void drawBoxes(const KernelFrame* const* frames, const Adding<Mixtures>* adds,
                            const KernelBox* boxes, TilePixels& tile) {
  const KernelFrame& frame = *frames[0];
  eachPacket(frames, adds, boxes, tile,
             [&](int at, BlockWay& block, BlockAdding<Mixtures>& adding, const auto& add) {
               Pixels pixels = loadPixels(frame, tile, at);
               const M going = goingOf(frame, tile, at, pixels.sum.a);
               if (hn::AllFalse(F(), going)) return;
               for (uint32_t i = 0; i <= boxes[0].joined; ++i) add(i);
               if (block.count == 0) return;
               drawBlock(frame, adding, block, going, pixels);
               storePixels(frame, pixels, tile, at);
             });
}

// The same with a tile for each channel.
HWY_NOINLINE void drawBoxes(const KernelFrame* const* frames, const Adding<ChannelPixels>* adds,
                            const KernelBox* boxes, TilePixels* tiles) {
  eachPacket(frames, adds, boxes, tiles[0],
             [&](int at, BlockWay& block, BlockAdding<ChannelPixels>& adding, const auto& add) {
               std::array<ChannelPixels, kMostBlended> channels;
               std::array<uint32_t, kMostBlended> channel_of;
               for (uint32_t i = 0; i <= boxes[0].joined; ++i) {
                 const uint32_t channel = boxes[i].channel;
                 const KernelFrame& frame = *frames[channel];
                 const Pixels pixels = loadPixels(frame, tiles[channel], at);
                 const M going = goingOf(frame, tiles[channel], at, pixels.sum.a);
                 const auto way = static_cast<size_t>(block.count);
                 if (hn::AllFalse(F(), going) || !add(i)) continue;
                 channels[way] = {pixels, hn::Zero(F()), going};
                 channel_of[way] = channel;
               }
               if (block.count == 0) return;
               drawBlock(adding, block, channels);
               for (size_t c = 0; c < static_cast<size_t>(block.count); ++c)
                 storePixels(*frames[channel_of[c]], channels[c].pixels, tiles[channel_of[c]], at);
             });
}

}  // namespace

void drawBlended(const KernelFrame* const* frames, size_t channels, const KernelBox* boxes,
                 const uint32_t* indices, size_t count, TilePixels& tile) {
  std::array<Adding<Mixtures>, kMostBlended> adds{};
  for (size_t c = 0; c < channels; ++c) adds[c] = addingOf<Mixtures>(*frames[c]);
  constexpr size_t kBlocksBetweenLooks = 8;
  for (size_t i = 0; i < count; ++i) {
    if (i % kBlocksBetweenLooks == 0 && isThrough(*frames[0], tile)) return;
    drawBoxes(frames, adds.data(), boxes + indices[i], tile);
  }
}

void drawAdded(const KernelFrame* const* frames, size_t channels, const KernelBox* boxes,
               const uint32_t* indices, size_t count, TilePixels* tiles) {
  std::array<Adding<ChannelPixels>, kMostBlended> adds{};
  for (size_t c = 0; c < channels; ++c) adds[c] = addingOf<ChannelPixels>(*frames[c]);
  for (size_t i = 0; i < count;) {
    const KernelBox& box = boxes[indices[i]];
    if (box.joined > 0) {
      drawBoxes(frames, adds.data(), &box, tiles);
      ++i;
      continue;
    }
    // Boxes of one channel share nothing.
    size_t end = i + 1;
    while (end < count && boxes[indices[end]].joined == 0 &&
           boxes[indices[end]].channel == box.channel)
      ++end;
    drawComposite(*frames[box.channel], boxes, indices + i, end - i, tiles[box.channel]);
    i = end;
  }
}

}  // namespace sluice::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
