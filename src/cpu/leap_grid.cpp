#include "src/cpu/leap_grid.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <span>
#include <type_traits>

#include "src/base/error.h"
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

// Takes `count` texels into as many ranges.
template <class T>
void widen(const T* texels, T* lo, T* hi, int64_t count) {
  for (int64_t i = 0; i < count; ++i) {
    T least = texels[i];
    // Texels that are no number show nothing: they must not widen the range downwards.
    if constexpr (std::is_same_v<T, float>) least = least < kNoNumber ? kNothing<T>.lo : least;
    lo[i] = std::min(lo[i], least);
    hi[i] = std::max(hi[i], texels[i]);
  }
}

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

// Goes over the bricks: `begin()` before each row of them along x, `take(first texel of a row)` for
// each row of texels in it, and `finish(first, end)` for the columns of texels of each brick, and
// of `margin` more on every side.
void eachBrick(const ChunkTexels& chunk, Vec3i bricks, int64_t margin, const auto& begin,
               const auto& take, const auto& finish) {
  const Vec3i storage = chunk.storage_vox;
  const auto firstOf = [margin](int64_t brick) {
    return std::max<int64_t>(brick * kBrickSide - margin, 0);
  };
  // One texel more than cells: neighbouring bricks share a plane.
  const auto endOf = [margin](int64_t brick, int64_t texels) {
    return std::min((brick + 1) * kBrickSide + 1 + margin, texels);
  };
  for (int64_t bz = 0; bz < bricks.z; ++bz)
    for (int64_t by = 0; by < bricks.y; ++by) {
      begin();
      for (int64_t z = firstOf(bz); z < endOf(bz, storage.z); ++z)
        for (int64_t y = firstOf(by); y < endOf(by, storage.y); ++y)
          take((z * storage.y + y) * storage.x);
      for (int64_t bx = 0; bx < bricks.x; ++bx)
        finish(static_cast<size_t>(firstOf(bx)), static_cast<size_t>(endOf(bx, storage.x)));
    }
}

template <class T>
void setRanges(const ChunkTexels& chunk, int64_t margin, LeapGrid& grid) {
  const auto* texels = reinterpret_cast<const T*>(chunk.bytes.get());
  const int64_t columns = chunk.storage_vox.x;
  std::vector<T> lo(static_cast<size_t>(columns)), hi(lo.size());
  auto* out = reinterpret_cast<Range<T>*>(grid.ranges.data());
  eachBrick(
      chunk, grid.bricks, margin,
      [&] {
        std::ranges::fill(lo, kNothing<T>.lo);
        std::ranges::fill(hi, kNothing<T>.hi);
      },
      [&](int64_t row) { widen(texels + row, lo.data(), hi.data(), columns); },
      [&](size_t first, size_t end) {
        Range<T> range = kNothing<T>;
        for (size_t x = first; x < end; ++x)
          range = {std::min(range.lo, lo[x]), std::max(range.hi, hi[x])};
        *out++ = range;
      });
}

// `expected`: null if the means or labels alone count.
template <class T>
void setRangesOfSpreads(const ChunkTexels& chunk, const ExpectedLook* expected, int64_t margin,
                        LeapGrid& grid) {
  const auto* texels = reinterpret_cast<const T*>(chunk.bytes.get());
  const int64_t columns = chunk.storage_vox.x;
  std::vector<SpreadBounds<T>> bounds(static_cast<size_t>(columns));
  auto* out = reinterpret_cast<Range<T>*>(grid.ranges.data());
  eachBrick(
      chunk, grid.bricks, margin, [&] { std::ranges::fill(bounds, SpreadBounds<T>()); },
      [&](int64_t row) { widenBySpread(texels + 2 * row, bounds.data(), columns); },
      [&](size_t first, size_t end) {
        SpreadBounds<T> all;
        for (size_t x = first; x < end; ++x) {
          const SpreadBounds<T>& more = bounds[x];
          all.means = {std::min(all.means.lo, more.means.lo),
                       std::max(all.means.hi, more.means.hi)};
          all.spread = std::max(all.spread, more.spread);
        }
        *out++ = expected == nullptr ? all.means : shownBy(all, *expected);
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
  uint8_t byte(size_t i) const { return static_cast<uint8_t>(begin()[i / 8] >> (8 * (i % 8))); }
};

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

// Turns the marks of bricks that show, in whole eights, into the distances to them.
void spreadMarks(Vec3i size, std::span<uint8_t> marks) {
  const auto x = static_cast<size_t>(size.x), y = static_cast<size_t>(size.y);
  const auto bricks = static_cast<size_t>(volume(size));
  // Shifts by whole planes read this far beyond both ends.
  const size_t margin = x * y / 64 + 2;
  BrickBits bits(bricks, margin), other = bits;
  constexpr uint64_t kBitsOfBytes = 0x0102040810204080;
  const auto eights = marks.size() / 8;
  for (size_t i = 0; i < eights; ++i) {
    uint64_t bytes;
    std::memcpy(&bytes, &marks[8 * i], sizeof bytes);
    // The product moves bit 0 of each byte into the upper one.
    bits.begin()[i / 8] |= (bytes * kBitsOfBytes >> 56) << (8 * (i % 8));
  }
  const BrickBits inner_x = notFirst(bricks, margin, x, 1),
                  inner_y = notFirst(bricks, margin, y, x);
  const BrickBits inner_z = notFirst(bricks, margin, static_cast<size_t>(size.z), x * y);
  // A brick loses one for each round in which it is marked: those marked at first reach 0.
  std::vector<uint64_t> distances(eights, kMostDistance * uint64_t{0x0101010101010101});
  for (int distance = 0; distance < kMostDistance; ++distance) {
    for (size_t i = 0; i < eights; ++i) distances[i] -= kBytesOfBits[bits.byte(i)];
    // One axis after the other: a brick spreads to all 26 neighbours in a round.
    spread(bits, inner_x, 1, other);
    spread(other, inner_y, x, bits);
    spread(bits, inner_z, x * y, other);
    std::swap(bits, other);
  }
  std::memcpy(marks.data(), distances.data(), marks.size());
}

}  // namespace

LeapGrid leapGrid(const ChunkTexels& chunk, const ExpectedLook* expected, int64_t margin) {
  const Vec3i storage = chunk.storage_vox;
  LeapGrid grid;
  grid.margin = margin;
  // The last texel of an axis begins no cell.
  for (int a = 0; a < 3; ++a)
    grid.bricks[a] = (std::max<int64_t>(storage[a] - 1, 1) + kBrickSide - 1) / kBrickSide;
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
    const auto count = std::count(marks.begin(), marks.end(), uint8_t{1});
    grid.shown_share = static_cast<double>(count) / static_cast<double>(bricks);
    spreadMarks(grid.bricks, marks);
  });
}

}  // namespace sluice
