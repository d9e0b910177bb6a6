// Texels of several channels side by side. Included once a target.
//
// Loads of single lanes take a quarter of the time of a blended sample. In the slices between two
// looks, a packet goes through few cells. The texels around them are copied into a window, where
// four bytes hold the texel of four channels, so that one load serves all of them. The values are
// to the bit those that are read channel by channel. Frames with gradients read four times as many
// texels, so that a larger window pays: a lit sample takes a quarter less time.

// A window is kWindowSide texels a side; rows and planes are so many bytes apart.
constexpr int kSideBySide = 4, kWindowSide = 16;
constexpr int kWindowRow = kSideBySide * kWindowSide, kWindowPlane = kWindowSide * kWindowRow;
// Rows of a window for each channel but the first: copying more takes longer than the loads that it
// saves.
constexpr float kRowsForChannel = 60, kLitRowsForChannel = 120;

// Channels whose samples have the same places, and the slices that they are read in. `margin`:
// texels beside the cells, for differences.
struct Alike {
  std::array<int, kSideBySide> ways;
  int count = 0, first = kSlicesAtOnce, last = 0, margin = 0;
};

// About how many rows the window of kSlicesAtOnce slices has.
HWY_INLINE float windowRows(const KernelBox& box, const V3& pace) {
  constexpr float kWidth = kPacketWidth - 1, kHeight = kPacketHeight - 1;
  const auto rows = [&](V along, size_t axis) {
    const auto i = static_cast<size_t>(box.axes[axis]);
    const float right = static_cast<float>(box.voxel_dx[box.axes[axis]]) * box.texel_scale[i];
    const float up = static_cast<float>(box.voxel_dy[box.axes[axis]]) * box.texel_scale[i];
    return 2.5F + (kMostAtOnce - 1) * std::abs(hn::GetLane(along)) + kWidth * std::abs(right) +
           kHeight * std::abs(up);
  };
  return rows(pace.y, 1) * rows(pace.z, 2);
}

// The window's cells and their texels.
struct Window {
  Cells cells;
  VI offset;  // of the first texel, by the strides of `cells`
  alignas(64) std::array<std::byte, size_t{kWindowSide} * kWindowPlane> texels;
};

// The first and the last of the cells that the lanes of `taking` have along an axis.
struct CellRange {
  int first, last;
  int texels() const { return last - first + 2; }
  void widen(int margin) { first -= margin, last += margin; }
};
HWY_INLINE CellRange rangeOf(const M& taking, V one, V other, V lo, V last) {
  const V a = cellOf(one, lo, last), b = cellOf(other, lo, last), far = all(1e9F);
  return {static_cast<int>(hn::GetLane(
              hn::MinOfLanes(F(), hn::IfThenElse(taking, hn::Min(a, b), far)))),
          static_cast<int>(hn::GetLane(
              hn::MaxOfLanes(F(), hn::IfThenElse(taking, hn::Max(a, b), hn::Neg(far)))))};
}

// Copies a row of the texels at this offset from each channel.
#if HWY_TARGET == HWY_SCALAR
HWY_INLINE void copyRow(const std::array<const std::byte*, kSideBySide>& from, int64_t offset,
                        std::byte* to) {
  for (int x = 0; x < kWindowSide; ++x)
    for (size_t c = 0; c < kSideBySide; ++c) *to++ = from[c][offset + x];
}
#elif HWY_TARGET == HWY_AVX3
// One store a row: a load whose bytes come from two stores waits until both are done.
HWY_INLINE void copyRow(const std::array<const std::byte*, kSideBySide>& from, int64_t offset,
                        std::byte* to) {
  const auto loaded = [&](size_t c) {
    return _mm_loadu_si128(reinterpret_cast<const __m128i*>(from[c] + offset));
  };
  const __m512i rows = _mm512_inserti64x4(_mm512_castsi256_si512(joined(loaded(0), loaded(1))),
                                          joined(loaded(2), loaded(3)), 1);
  // Four texels of each channel, and then the four channels of each texel.
  const __m512i fours = _mm512_permutexvar_epi32(
      _mm512_setr_epi32(0, 4, 8, 12, 1, 5, 9, 13, 2, 6, 10, 14, 3, 7, 11, 15), rows);
  const __m512i texels = _mm512_shuffle_epi8(
      fours, _mm512_broadcast_i32x4(
                 _mm_setr_epi8(0, 4, 8, 12, 1, 5, 9, 13, 2, 6, 10, 14, 3, 7, 11, 15)));
  _mm512_store_si512(to, texels);
}
#else
HWY_INLINE void copyRow(const std::array<const std::byte*, kSideBySide>& from, int64_t offset,
                        std::byte* to) {
  const hn::FixedTag<uint8_t, 16> bytes;
  const hn::Repartition<uint16_t, decltype(bytes)> pairs;
  const auto loaded = [&](size_t c) {
    return hn::LoadU(bytes, reinterpret_cast<const uint8_t*>(from[c] + offset));
  };
  const auto a = loaded(0), b = loaded(1), c = loaded(2), d = loaded(3);
  auto* const out = reinterpret_cast<uint8_t*>(to);
  const auto store = [&](auto first, auto second, int place) {
    const auto lower = hn::BitCast(pairs, first), upper = hn::BitCast(pairs, second);
    hn::Store(hn::BitCast(bytes, hn::InterleaveLower(pairs, lower, upper)), bytes, out + place);
    hn::Store(hn::BitCast(bytes, hn::InterleaveUpper(pairs, lower, upper)), bytes,
              out + place + 16);
  };
  store(hn::InterleaveLower(bytes, a, b), hn::InterleaveLower(bytes, c, d), 0);
  store(hn::InterleaveUpper(bytes, a, b), hn::InterleaveUpper(bytes, c, d), kWindowRow / 2);
}
#endif

// Copies the texels of the channels' samples in slices from k on. Returns false if they are too
// many.
HWY_INLINE bool fillWindow(const BlockWay& block, const Alike& alike, const V& k, const M& going,
                           Window& window) {
  const ChannelWay& way = block.ways[static_cast<size_t>(alike.ways[0])];
  const KernelBox& box = *way.box;
  // The samples of a lane lie between its first and its last one.
  const V first = hn::Max(hn::Add(k, all(static_cast<float>(alike.first))), way.from);
  const V last = hn::Min(hn::Add(k, all(static_cast<float>(alike.last - 1))),
                         hn::Sub(way.end, all(1.0F)));
  const M taking = hn::And(going, hn::Le(first, last));
  const Line& line = way.line;
  const bool clamps = box.clamps || alike.margin > 0;
  const V3 one = placeOn(line, first, clamps), other = placeOn(line, last, clamps);
  const Cells& cells = line.cells;
  CellRange y = rangeOf(taking, one.y, other.y, cells.lo.y, cells.last.y);
  CellRange z = rangeOf(taking, one.z, other.z, cells.lo.z, cells.last.z);
  CellRange x = rangeOf(taking, one.x, other.x, cells.lo.x, cells.last.x);
  if (x.last < x.first) return false;
  for (CellRange* const range : {&x, &y, &z}) range->widen(alike.margin);
  if (std::max({x.texels(), y.texels(), z.texels()}) > kWindowSide) return false;
  const auto row = static_cast<int64_t>(box.stride[1]), plane = static_cast<int64_t>(box.stride[2]);
  const auto offsetOf = [&](int64_t at_x, int64_t at_y, int64_t at_z) {
    return at_x + at_y * row + at_z * plane;
  };
  const auto storageOffset = [&](const Float3& at) {
    return offsetOf(static_cast<int64_t>(at[0]), static_cast<int64_t>(at[1]),
                    static_cast<int64_t>(at[2]));
  };
  // Four channels are copied, and of fewer the first one again. The chunks may begin and end at
  // different texels.
  std::array<const std::byte*, kSideBySide> from;
  int64_t storage_lo = storageOffset(box.storage_lo), storage_hi = storageOffset(box.storage_hi);
  for (size_t c = 0; c < kSideBySide; ++c) {
    const auto i = static_cast<size_t>(alike.ways[c < static_cast<size_t>(alike.count) ? c : 0]);
    const KernelBox& each = *block.ways[i].box;
    storage_lo = std::max(storage_lo, storageOffset(each.storage_lo));
    storage_hi = std::min(storage_hi, storageOffset(each.storage_hi));
    from[c] = each.texels;
  }
  // Rows are read whole. The last one must not end behind the chunks' texels.
  const int64_t end = offsetOf(x.first + kWindowSide - 1, y.last + 1, z.last + 1);
  x.first -= static_cast<int>(std::max<int64_t>(0, end - storage_hi));
  const int64_t start = offsetOf(x.first, y.first, z.first);
  if (x.texels() > kWindowSide || start < storage_lo) return false;
  for (int j = 0; j < z.texels(); ++j)
    for (int i = 0; i < y.texels(); ++i)
      copyRow(from, start + i * row + j * plane,
              window.texels.data() + j * kWindowPlane + i * kWindowRow);
  const auto cell = [](int at) { return all(static_cast<float>(at)); };
  const int m = alike.margin;
  const V3 lo{cell(x.first + m), cell(y.first + m), cell(z.first + m)};
  window.cells = {lo,
                  lo,
                  {cell(x.last - m), cell(y.last - m), cell(z.last - m)},
                  {all(static_cast<float>(kSideBySide)), all(static_cast<float>(kWindowRow)),
                   all(static_cast<float>(kWindowPlane))}};
  window.offset =
      hn::Set(I(), x.first * kSideBySide + y.first * kWindowRow + z.first * kWindowPlane);
  return true;
}

// A channel's texels of the window.
template <int kChannel>
HWY_INLINE V texelIn(VI bytes) {
  return hn::ConvertTo(F(), hn::And(hn::ShiftRight<8 * kChannel>(bytes), hn::Set(I(), 255)));
}
template <int kChannel>
HWY_INLINE Rows pairsIn(const Wide (&rows)[4]) {
  Rows pairs;
  for (int i = 0; i < 4; ++i)
    pairs.pair[i] = {texelIn<kChannel>(rows[i].first), texelIn<kChannel>(rows[i].second)};
  return pairs;
}
// The value of a channel of the window. `rows`: as rowsAround() has them.
template <int kChannel>
HWY_INLINE V valueIn(const Wide (&rows)[4], const Place& place) {
  return withinRows(pairsIn<kChannel>(rows).pair, place);
}

// The texels of all channels around a place of the window, as differencesIn() takes them.
struct WindowRows {
  VI near[4][4];  // of each long row the four texels
  Wide along_y[4], along_z[4];
};
HWY_INLINE WindowRows windowRowsAt(const std::byte* texels, VI offset) {
  constexpr int kX = kSideBySide, kY = kWindowRow, kZ = kWindowPlane;
  // From the first texel of the margin on: the compiler takes a place before the window for an
  // error.
  const VI from = hn::Sub(offset, hn::Set(I(), kX + kY + kZ));
  WindowRows rows;
  const int near[4] = {kY + kZ, 2 * kY + kZ, kY + 2 * kZ, 2 * kY + 2 * kZ};
  for (int i = 0; i < 4; ++i) {
    const Quad quad = quadAt(texels + near[i], from);
    for (int x = 0; x < 4; ++x) rows.near[i][x] = hn::BitCast(I(), quad.of[x]);
  }
  const std::byte* const first = texels + kX;
  wideOfEach({first + kZ, first + 2 * kZ, first + 3 * kY + kZ, first + 3 * kY + 2 * kZ}, from,
             rows.along_y);
  wideOfEach({first + kY, first + 2 * kY, first + kY + 3 * kZ, first + 2 * kY + 3 * kZ}, from,
             rows.along_z);
  return rows;
}
// Sets the value and the differences of a channel of the window.
template <int kChannel>
HWY_INLINE void setSlopeIn(const WindowRows& rows, const Place& place, V& value, V3& differences) {
  LongRows near;
  Pair pairs[4];
  for (int i = 0; i < 4; ++i) {
    near.before[i] = texelIn<kChannel>(rows.near[i][0]);
    near.first[i] = pairs[i].first = texelIn<kChannel>(rows.near[i][1]);
    near.second[i] = pairs[i].second = texelIn<kChannel>(rows.near[i][2]);
    near.after[i] = texelIn<kChannel>(rows.near[i][3]);
  }
  value = withinRows(pairs, place);
  differences = differencesIn<DeviceType::kU8>(
      near, place, [&] { return pairsIn<kChannel>(rows.along_y); },
      [&] { return pairsIn<kChannel>(rows.along_z); });
}

// Reads the channels' values at their slices from k on. Returns false, and reads none, if they are
// to be read channel by channel.
HWY_NOINLINE bool readAlike(const BlockWay& block, const Alike& alike, const V& k, const M& going,
                            std::array<SliceValues, kMostBlended>& values) {
  Window window;
  if (!fillWindow(block, alike, k, going, window)) return false;
  const ChannelWay& way = block.ways[static_cast<size_t>(alike.ways[0])];
  const bool clamps = way.box->clamps || alike.margin > 0;
  const std::byte* const texels = window.texels.data();
  const auto valuesOf = [&](size_t c) -> std::array<V, kSlicesAtOnce>& {
    return values[static_cast<size_t>(alike.ways[c])].of;
  };
  // All places come first. A load from a window that was stored just before waits for the stores.
  std::array<Place, kSlicesAtOnce> places;
  for (int j = alike.first; j < alike.last; ++j) {
    const V slice = hn::Add(k, all(static_cast<float>(j)));
    Place& place = places[static_cast<size_t>(j)];
    place = placeAt(window.cells, placeOn(way.line, slice, clamps));
    place.offset = hn::Sub(place.offset, window.offset);
  }
  if (alike.margin > 0) {
    for (int j = alike.first; j < alike.last; ++j) {
      const auto at = static_cast<size_t>(j);
      const Place& place = places[at];
      const WindowRows rows = windowRowsAt(texels, place.offset);
      const auto slopesOf = [&](size_t c) -> V3& {
        return values[static_cast<size_t>(alike.ways[c])].differences[at];
      };
      setSlopeIn<0>(rows, place, valuesOf(0)[at], slopesOf(0));
      setSlopeIn<1>(rows, place, valuesOf(1)[at], slopesOf(1));
      if (alike.count > 2) setSlopeIn<2>(rows, place, valuesOf(2)[at], slopesOf(2));
      if (alike.count > 3) setSlopeIn<3>(rows, place, valuesOf(3)[at], slopesOf(3));
    }
    return true;
  }
  for (int j = alike.first; j < alike.last; ++j) {
    const Place& place = places[static_cast<size_t>(j)];
    Wide rows[4];
    wideOfEach({texels, texels + kWindowRow, texels + kWindowPlane,
                texels + kWindowPlane + kWindowRow},
               place.offset, rows);
    const auto at = static_cast<size_t>(j);
    valuesOf(0)[at] = valueIn<0>(rows, place);
    valuesOf(1)[at] = valueIn<1>(rows, place);
    if (alike.count > 2) valuesOf(2)[at] = valueIn<2>(rows, place);
    if (alike.count > 3) valuesOf(3)[at] = valueIn<3>(rows, place);
  }
  return true;
}

// Reads the values of the channels that have the same places, in slices from k on. Returns a bit
// for each way whose values are set.
HWY_INLINE uint32_t readTogether(const BlockWay& block, const V& k, const M& going,
                                 std::array<SliceValues, kMostBlended>& values) {
  uint32_t tried = 0, read = 0;
  for (int c = 0; c < block.count; ++c) {
    if ((block.reads_values >> c & 1) == 0 || (tried >> c & 1) != 0) continue;
    const ChannelWay& first = block.ways[static_cast<size_t>(c)];
    Alike alike;
    uint32_t ways = 0;
    for (int i = c; i < block.count && alike.count < kSideBySide; ++i) {
      const ChannelWay& way = block.ways[static_cast<size_t>(i)];
      if (way.places != first.places || way.first >= way.last || (tried >> i & 1) != 0) continue;
      alike.ways[static_cast<size_t>(alike.count++)] = i;
      alike.first = std::min(alike.first, way.first);
      alike.last = std::max(alike.last, way.last);
      ways |= uint32_t{1} << i;
    }
    tried |= ways;
    const bool has_slopes = first.frame->lit || first.frame->rows > 0;
    alike.margin = has_slopes ? 1 : 0;
    const float most_rows = (has_slopes ? kLitRowsForChannel : kRowsForChannel) *
                            static_cast<float>(alike.count - 1);
    const bool pays = first.window_rows < most_rows;
    if (pays && readAlike(block, alike, k, going, values)) read |= ways;
  }
  return read;
}

// See AddValues.
template <Shading kShading, class Into>
HWY_NOINLINE bool addValues(const ChannelWay& way, const V& k, const M& going,
                            const SliceValues& values, Into& into, VI& taken) {
  const KernelFrame& frame = *way.frame;
  const V least = all(frame.least_visible), most = all(frame.most_visible);
  constexpr bool kHasSlopes = kShading == Shading::kGradients;
  for (int j = way.first; j < way.last; ++j) {
    const V slice = hn::Add(k, all(static_cast<float>(j)));
    const V value = values.of[static_cast<size_t>(j)];
    M shows = hn::And(going, hn::And(hn::Ge(slice, way.from), hn::Lt(slice, way.end)));
    if (frame.counts_taken)
      taken = hn::Sub(taken, hn::VecFromMask(I(), hn::RebindMask(I(), shows)));
    if (!frame.shades_every_sample)
      shows = hn::And(shows, hn::And(hn::Ge(value, least), hn::Le(value, most)));
    if (hn::AllFalse(F(), shows)) continue;
    // Colours without gradients need no place.
    const V3 at = kHasSlopes ? placeOn(way.line, slice, true) : way.line.first;
    const ReadPlace place = kHasSlopes ? ReadPlace{values.differences[static_cast<size_t>(j)]}
                                       : ReadPlace{way.line.first};
    const Color color = colorOf<DeviceType::kU8, kShading>(frame, *way.box, at, place, value, value,
                                                           way.ray_length);
    if (!show(way, color, shows, hn::Add(slice, way.middle), j, into)) return false;
  }
  return true;
}
