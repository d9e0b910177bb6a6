#include "src/cpu/leap_grid.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <numeric>
#include <span>
#include <type_traits>

#include "src/base/error.h"
#include "src/base/vector_of.h"
#include "src/base/wide_vectors.h"

namespace sluice {
namespace {

// Below it lies the stand-in for texels that are no number.
constexpr float kNoNumber = -2e30F;

template <class T>
struct Range {
  T lo, hi;
};

template <class T>
constexpr Range<T> kNothing{std::numeric_limits<T>::max(), std::numeric_limits<T>::lowest()};

// The least and the greatest means of texels with spreads, and the greatest spread.
template <class T>
struct SpreadBounds {
  Range<T> means = kNothing<T>;
  T spread = 0;
};

// Takes `count` texels into as many bounds.
template <class T>
void widenBySpread(const T* texels, SpreadBounds<T>* bounds, int64_t count) {
  for (int64_t i = 0; i < count; ++i) {
    const T mean = texels[2 * i];
    if constexpr (std::is_same_v<T, float>)
      if (mean < kNoNumber) continue;
    bounds[i].means = {std::min(bounds[i].means.lo, mean), std::max(bounds[i].means.hi, mean)};
    bounds[i].spread = std::max(bounds[i].spread, texels[2 * i + 1]);
  }
}

// The values that a sample with this mean and spread can show, rounded outwards.
template <class T>
Range<T> shownBy(T mean, T spread, const ExpectedLook& expected) {
  if constexpr (std::is_same_v<T, uint8_t>) {
    if (!expected.byte_ranges.empty()) {
      const ByteRange range = expected.byte_ranges[size_t{256} * mean + spread];
      return {range.lo, range.hi};
    }
  }
  constexpr double kLeast = static_cast<double>(std::numeric_limits<T>::lowest());
  constexpr double kMost = static_cast<double>(std::numeric_limits<T>::max());
  const ValueRange range = shownRange(mean, spread, expected);
  return {static_cast<T>(std::clamp(std::floor(range.lo), kLeast, kMost)),
          static_cast<T>(std::clamp(std::ceil(range.hi), kLeast, kMost))};
}

// Means and spreads are interpolated by themselves, so a sample may have any mean between two
// texels' with any spread up to the greatest. Between two means the ends of shownRange() lie
// between its ends at these two, and a greater spread only widens it.
template <class T>
Range<T> shownBy(const SpreadBounds<T>& bounds, const ExpectedLook& expected) {
  if (bounds.means.lo > bounds.means.hi) return kNothing<T>;
  const Range<T> lower = shownBy(bounds.means.lo, bounds.spread, expected);
  const Range<T> upper = shownBy(bounds.means.hi, bounds.spread, expected);
  return {std::min(lower.lo, upper.lo), std::max(lower.hi, upper.hi)};
}

// The texels of brick `at` along an axis of so many texels, and `margin` more on both sides.
struct BrickSpan {
  BrickSpan(int64_t at, int64_t texels, int64_t margin)
      : lo(std::max<int64_t>(at * kBrickSide - margin, 0)),
        // One texel more than cells: neighbouring bricks share a plane.
        hi(std::min((at + 1) * kBrickSide + 1 + margin, texels)) {}
  int64_t lo, hi;
};

// Calls `body` with the texels along y and z of each row of bricks along x.
void eachRowOfBricks(const ChunkTexels& chunk, Vec3i bricks, int64_t margin, const auto& body) {
  for (int64_t z = 0; z < bricks.z; ++z)
    for (int64_t y = 0; y < bricks.y; ++y)
      body(BrickSpan(y, chunk.size_vox.y, margin), BrickSpan(z, chunk.size_vox.z, margin));
}

// The least and the greatest texels of the columns of a row of bricks. Before and behind lie
// columns of nothing, so that windows of columns may reach beyond the chunk.
template <class T>
struct ColumnRanges {
  static constexpr size_t kBeside = 8;
  explicit ColumnRanges(int64_t columns)
      : lo(static_cast<size_t>(columns) + 2 * kBeside), hi(lo.size()) {}
  std::vector<T> lo, hi;
};

// Sets the columns, kAtOnce of them in a `Texels`. Requires: the chunk has so many.
template <int64_t kAtOnce, class Texels, class T>
void setColumns(const ChunkTexels& chunk, BrickSpan y_span, BrickSpan z_span,
                ColumnRanges<T>& ranges) {
  const auto* texels = reinterpret_cast<const T*>(chunk.bytes.get());
  const Vec3i storage = chunk.storage_vox;
  const int64_t columns = chunk.size_vox.x;
  Texels most{}, least{};
  most += kNothing<T>.lo;
  least += kNothing<T>.hi;
  for (int64_t x = 0; x < columns; x += kAtOnce) {
    // The last columns are taken twice rather than fewer at once.
    const int64_t first = std::min(x, columns - kAtOnce);
    Texels lo = most, hi = least;
    for (int64_t z = z_span.lo; z < z_span.hi; ++z)
      for (int64_t y = y_span.lo; y < y_span.hi; ++y) {
        Texels row;
        std::memcpy(&row, texels + (z * storage.y + y) * storage.x + first, sizeof row);
        hi = row > hi ? row : hi;
        // Texels that are no number show nothing: they must not widen the range downwards.
        if constexpr (std::is_same_v<T, float>) row = row < kNoNumber ? most : row;
        lo = row < lo ? row : lo;
      }
    const size_t at = ranges.kBeside + static_cast<size_t>(first);
    std::memcpy(&ranges.lo[at], &lo, sizeof lo);
    std::memcpy(&ranges.hi[at], &hi, sizeof hi);
  }
}

// Makes each column the range of itself and the three behind it.
template <class T>
void takeFours(ColumnRanges<T>& ranges) {
  const size_t columns = ranges.lo.size();
  T *const lo = ranges.lo.data(), *const hi = ranges.hi.data();
  for (const size_t beside : {size_t{1}, size_t{2}})
    for (size_t x = 0; x + beside < columns; ++x) {
      lo[x] = std::min(lo[x], lo[x + beside]);
      hi[x] = std::max(hi[x], hi[x + beside]);
    }
}

template <class T>
void setRanges(const ChunkTexels& chunk, int64_t margin, LeapGrid& grid) {
  using Texels = typename VectorOf<T, 32>::Type;
  constexpr auto kAtOnce = static_cast<int64_t>(sizeof(Texels) / sizeof(T));
  const int64_t columns = chunk.size_vox.x;
  ColumnRanges<T> ranges(columns);
  constexpr size_t kBeside = ranges.kBeside;
  // Two windows of four columns, which overlap, are those of a brick.
  SLUICE_CHECK_LE(margin, 1);
  const auto second = static_cast<size_t>(1 + 2 * margin);
  auto* out = reinterpret_cast<Range<T>*>(grid.ranges.data());
  eachRowOfBricks(chunk, grid.bricks, margin, [&](BrickSpan y, BrickSpan z) {
    std::fill_n(ranges.lo.begin(), kBeside, kNothing<T>.lo);
    std::fill_n(ranges.hi.begin(), kBeside, kNothing<T>.hi);
    std::fill_n(ranges.lo.end() - kBeside, kBeside, kNothing<T>.lo);
    std::fill_n(ranges.hi.end() - kBeside, kBeside, kNothing<T>.hi);
    if (columns >= kAtOnce)
      setColumns<kAtOnce, Texels>(chunk, y, z, ranges);
    else
      setColumns<1, T>(chunk, y, z, ranges);
    takeFours(ranges);
    for (int64_t x = 0; x < grid.bricks.x; ++x) {
      const size_t at = kBeside + static_cast<size_t>(x * kBrickSide - margin);
      *out++ = {std::min(ranges.lo[at], ranges.lo[at + second]),
                std::max(ranges.hi[at], ranges.hi[at + second])};
    }
  });
}

// `expected`: null if the means or labels alone count.
template <class T>
void setRangesOfSpreads(const ChunkTexels& chunk, const ExpectedLook* expected, int64_t margin,
                        LeapGrid& grid) {
  const auto* texels = reinterpret_cast<const T*>(chunk.bytes.get());
  const Vec3i storage = chunk.storage_vox;
  const int64_t columns = chunk.size_vox.x;
  std::vector<SpreadBounds<T>> bounds(static_cast<size_t>(columns));
  auto* out = reinterpret_cast<Range<T>*>(grid.ranges.data());
  eachRowOfBricks(chunk, grid.bricks, margin, [&](BrickSpan y_span, BrickSpan z_span) {
    std::ranges::fill(bounds, SpreadBounds<T>());
    for (int64_t z = z_span.lo; z < z_span.hi; ++z)
      for (int64_t y = y_span.lo; y < y_span.hi; ++y)
        widenBySpread(texels + 2 * (z * storage.y + y) * storage.x, bounds.data(), columns);
    for (int64_t brick = 0; brick < grid.bricks.x; ++brick) {
      SpreadBounds<T> all;
      const BrickSpan x_span(brick, columns, margin);
      for (int64_t x = x_span.lo; x < x_span.hi; ++x) {
        const SpreadBounds<T>& more = bounds[static_cast<size_t>(x)];
        all.means = {std::min(all.means.lo, more.means.lo), std::max(all.means.hi, more.means.hi)};
        all.spread = std::max(all.spread, more.spread);
      }
      *out++ = expected == nullptr ? all.means : shownBy(all, *expected);
    }
  });
}

// Sets 1 where something may show, otherwise 0.
template <class T>
void markShown(const Range<T>* ranges, const ShownVoxels<T>& shown, std::span<uint8_t> marks) {
  // Each of a few intervals is one loop over the bricks.
  constexpr size_t kFewIntervals = 4;
  if (shown.intervals().size() > kFewIntervals) {
    for (size_t i = 0; i < marks.size(); ++i)
      // A brick of nothing but NaN has lo > hi, and shows nothing.
      marks[i] = ranges[i].lo <= ranges[i].hi && shown.any(ranges[i].lo, ranges[i].hi) ? 1 : 0;
    return;
  }
  std::ranges::fill(marks, uint8_t{0});
  for (const auto [lo, hi] : shown.intervals())
    for (size_t i = 0; i < marks.size(); ++i) {
      const Range<T> range = ranges[i];
      const bool shows = (range.lo <= hi) & (range.hi >= lo) & (range.lo <= range.hi);
      marks[i] = static_cast<uint8_t>(marks[i] | static_cast<uint8_t>(shows));
    }
}

// A bit a brick, in their order, so that one operation spreads 64 bricks. Before and behind lie
// `margin` words of nothing.
struct BrickBits {
  BrickBits(size_t bricks, size_t margin)
      : margin(margin), words(2 * margin + (bricks + 63) / 64) {}
  size_t margin;
  std::vector<uint64_t> words;
  size_t size() const { return words.size() - 2 * margin; }
  uint64_t* begin() { return words.data() + margin; }
  const uint64_t* begin() const { return words.data() + margin; }
  size_t count() const {
    return std::accumulate(words.begin(), words.end(), size_t{0}, [](size_t count, uint64_t word) {
      return count + static_cast<size_t>(std::popcount(word));
    });
  }
};

// The bits of marks, which are 0 or 1, in whole eights.
BrickBits bitsOf(std::span<const uint8_t> marks, size_t margin) {
  BrickBits bits(marks.size(), margin);
  constexpr uint64_t kBitsOfBytes = 0x0102040810204080;
  for (size_t i = 0; i < marks.size() / 8; ++i) {
    uint64_t bytes;
    std::memcpy(&bytes, &marks[8 * i], sizeof bytes);
    // The product moves bit 0 of each byte into the upper one.
    bits.begin()[i / 8] |= (bytes * kBitsOfBytes >> 56) << (8 * (i % 8));
  }
  return bits;
}

// The bits of bricks that are not the first ones of their line along an axis, lines of `count`
// bricks at distances of `stride`.
BrickBits notFirst(size_t bricks, size_t margin, size_t count, size_t stride) {
  BrickBits bits(bricks, margin);
  std::fill_n(bits.begin(), bits.size(), ~uint64_t{0});
  // Nothing spreads behind the last brick.
  if (bricks % 64 != 0) bits.begin()[bricks / 64] = (uint64_t{1} << (bricks % 64)) - 1;
  for (size_t line = 0; line < bricks; line += count * stride)
    for (size_t i = line; i < std::min(line + stride, bricks); ++i)
      bits.begin()[i / 64] &= ~(uint64_t{1} << (i % 64));
  return bits;
}

// out = in and the neighbours of its bricks at a distance of `stride` bits, in one line.
void spread(const BrickBits& in, const BrickBits& not_first, size_t stride, BrickBits& out) {
  const auto words = static_cast<ptrdiff_t>(stride / 64), size = static_cast<ptrdiff_t>(in.size());
  const auto bits = static_cast<int>(stride % 64);
  const uint64_t *const from = in.begin(), *const mask = not_first.begin();
  uint64_t* const to = out.begin();
  // Two shifts, since one by 64 bits is not defined.
  for (ptrdiff_t i = 0; i < size; ++i) {
    const uint64_t up = (from[i - words] << bits) | ((from[i - words - 1] >> 1) >> (63 - bits));
    const ptrdiff_t a = i + words, b = a + 1;
    const uint64_t down =
        ((from[a] & mask[a]) >> bits) | (((from[b] & mask[b]) << 1) << (63 - bits));
    to[i] = from[i] | (up & mask[i]) | down;
  }
}

// Byte i of entry e is bit i of e.
constexpr std::array<uint64_t, 256> kBytesOfBits = [] {
  std::array<uint64_t, 256> bytes{};
  for (size_t e = 0; e < 256; ++e)
    for (size_t bit = 0; bit < 8; ++bit) bytes[e] |= uint64_t{e >> bit & 1} << (8 * bit);
  return bytes;
}();

// Sets the distances, in whole eights, of bricks to those that `bits` mark. `bits` has words enough
// on both sides for shifts by a plane of bricks.
void setDistancesTo(BrickBits bits, Vec3i size, std::span<uint8_t> distances) {
  const auto x = static_cast<size_t>(size.x), y = static_cast<size_t>(size.y);
  const auto bricks = static_cast<size_t>(volume(size));
  const size_t margin = bits.margin, words = bits.size();
  BrickBits other = bits;
  const BrickBits inner_x = notFirst(bricks, margin, x, 1),
                  inner_y = notFirst(bricks, margin, y, x);
  const BrickBits inner_z = notFirst(bricks, margin, static_cast<size_t>(size.z), x * y);
  // A distance is the number of rounds in which a brick is not marked: a number of three bits.
  static_assert(kMostDistance < 8);
  std::vector<uint64_t> ones(words), twos(words), fours(words);
  for (int distance = 0; distance < kMostDistance; ++distance) {
    const uint64_t* const marked = bits.begin();
    for (size_t i = 0; i < words; ++i) {
      const uint64_t one = ~marked[i], two = ones[i] & one;
      ones[i] ^= one;
      fours[i] ^= twos[i] & two;
      twos[i] ^= two;
    }
    // One axis after the other: a brick spreads to all 26 neighbours in a round.
    spread(bits, inner_x, 1, other);
    spread(other, inner_y, x, bits);
    spread(bits, inner_z, x * y, other);
    std::swap(bits, other);
  }
  for (size_t i = 0; i < distances.size() / 8; ++i) {
    const auto bytesOf = [i](const std::vector<uint64_t>& bits) {
      return kBytesOfBits[bits[i / 8] >> (8 * (i % 8)) & 0xFF];
    };
    const uint64_t bytes = bytesOf(ones) + 2 * bytesOf(twos) + 4 * bytesOf(fours);
    std::memcpy(&distances[8 * i], &bytes, sizeof bytes);
  }
}

}  // namespace

LeapGrid leapGrid(const ChunkTexels& chunk, const ExpectedLook* expected, int64_t margin) {
  LeapGrid grid;
  grid.margin = margin;
  // The last texel of an axis begins no cell.
  for (int a = 0; a < 3; ++a)
    grid.bricks[a] = (std::max<int64_t>(chunk.size_vox[a] - 1, 1) + kBrickSide - 1) / kBrickSide;
  const auto bricks = static_cast<size_t>(volume(grid.bricks));
  grid.ranges.resize(bricks * 2 * bytesPerVoxel(chunk.type));
  inWideVectors([&] {
    visitDeviceType(chunk.type, [&](auto tag) {
      using T = decltype(tag);
      if (chunk.has_spread)
        setRangesOfSpreads<T>(chunk, expected, margin, grid);
      else
        setRanges<T>(chunk, margin, grid);
    });
  });
  return grid;
}

void setDistances(LeapGrid& grid, DeviceType type, const ShownValues& shown) {
  const auto bricks = static_cast<size_t>(volume(grid.bricks));
  const size_t eights = (bricks + 7) / 8 * 8;
  // Four bytes more, as kernels read four at each brick.
  grid.distances.assign(eights + 4, 0);
  const std::span marks(grid.distances.data(), eights);
  inWideVectors([&] {
    visitDeviceType(type, [&](auto tag) {
      using T = decltype(tag);
      markShown(reinterpret_cast<const Range<T>*>(grid.ranges.data()), ShownVoxels<T>(shown),
                marks.first(bricks));
    });
    // Shifts by whole planes read this far beyond both ends.
    const auto margin = static_cast<size_t>(grid.bricks.x * grid.bricks.y) / 64 + 2;
    const BrickBits bits = bitsOf(marks, margin);
    grid.shown_share = static_cast<double>(bits.count()) / static_cast<double>(bricks);
    setDistancesTo(bits, grid.bricks, marks);
  });
}

}  // namespace sluice
