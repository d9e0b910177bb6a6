// The ways of a packet through the boxes of several channels, and where their samples show: in the
// mixtures of one medium, or in pixels of each channel's own. Included once a target.

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
  V middle;  // of a slice, in slices
  BrickWay bricks;
  // No slice before it shows anything, as far as is known; the block's end for lanes that are
  // through the box.
  V shown;
  uint32_t places;    // whose Places these samples have, see placesOf()
  float window_rows;  // about how many a window has, see side_by_side.inl
  // Slices k + first, ..., k + last - 1 are sampled next, see drawBlock().
  int first, last;
};

// The values of a channel in the slices between two looks, and, of frames with gradients, their
// differences along each axis.
struct SliceValues {
  std::array<V, kSlicesAtOnce> of;
  std::array<V3, kSlicesAtOnce> differences;
};

// A channel whose picture is added to the others': its own pixels, in which its rays end.
struct ChannelPixels {
  Pixels pixels;
  V in_box;  // opacity
  M going;
};

// Shows a colour at slice k + j. Returns whether the channel goes on.
HWY_INLINE bool show(const ChannelWay&, const Color& color, const M& shows, const V&, int j,
                     Mixtures& mixtures) {
  addColor(color, shows, j, mixtures);
  return true;
}
HWY_INLINE bool show(const ChannelWay& way, const Color& color, const M& shows, const V& middle,
                     int, ChannelPixels& channel) {
  const KernelFrame& frame = *way.frame;
  const M shown = hn::And(shows, channel.going);
  layBehind(frame, color, shown, middle, channel.pixels);
  if (frame.box_opacity <= 1) {
    channel.in_box = hn::MulAdd(hn::Sub(all(1.0F), channel.in_box),
                                hn::IfThenElseZero(shown, color.a), channel.in_box);
    channel.going = hn::And(channel.going, hn::Lt(channel.in_box, all(frame.box_opacity)));
  }
  return !hn::AllFalse(
      F(), hn::And(channel.going, hn::Lt(channel.pixels.sum.a, all(frame.ray_opacity))));
}

// Shows the channel's samples of slices from k on: in the mixtures of these slices, or in its
// pixels. `places` are shared by the channels whose samples have the same ones. Returns whether the
// channel goes on.
template <class Into>
using AddSamples = bool (*)(const ChannelWay& way, const V& k, const M& going, Places& places,
                            Into& into, VI& taken);
// The same of samples that are read already.
template <class Into>
using AddValues = bool (*)(const ChannelWay& way, const V& k, const M& going,
                           const SliceValues& values, Into& into, VI& taken);

// A channel shows its samples by these: in boxes of one number a texel, and of two.
template <class Into>
struct Adding {
  AddSamples<Into> one = nullptr, two = nullptr;
  AddValues<Into> values = nullptr;  // in boxes of one number; null if samples are read one by one
  bool needs_margin = false;         // `values` are of boxes with a margin

  AddSamples<Into> of(const KernelBox& box) const { return box.has_spread ? two : one; }
  AddValues<Into> valuesOf(const KernelBox& box) const {
    return box.has_spread || (needs_margin && !box.has_margin) ? nullptr : values;
  }
};

// The ways of a packet through a block's boxes.
struct BlockWay {
  std::array<ChannelWay, kMostBlended> ways;
  int count = 0;
  uint32_t reads_values = 0;  // a bit for each way that takes samples that are read already
  V from, end;                // of all
};

// Whether the samples of two boxes lie at the same places in texels of the same layout.
bool havePlacesAlike(const KernelBox& a, const KernelBox& b) {
  return a.voxel0 == b.voxel0 && a.size == b.size && a.axes == b.axes &&
         a.texel_scale == b.texel_scale && a.texel_start == b.texel_start &&
         a.texel_hi == b.texel_hi && a.last_cell == b.last_cell && a.stride == b.stride &&
         a.clamps == b.clamps;
}

// Returns, for each of a block's boxes, the first one whose samples have the same places. Kinds of
// samples differ in whether places are clamped to the box.
template <class Into>
std::array<uint32_t, kMostBlended> placesOf(const KernelFrame* const* frames,
                                            const Adding<Into>* adds, const KernelBox* boxes) {
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
