#include "src/cpu/leap_grid.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <type_traits>

#include "src/base/error.h"

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

// `expected`: null for labels.
template <class T>
void setRangesOfSpreads(const ChunkTexels& chunk, const ExpectedLook* expected, LeapGrid& grid) {
  const auto* texels = reinterpret_cast<const T*>(chunk.bytes.get());
  const int64_t columns = chunk.storage_vox.x;
  std::vector<SpreadBounds<T>> bounds(static_cast<size_t>(columns));
  auto* out = reinterpret_cast<Range<T>*>(grid.ranges.data());
  eachBrick(
      chunk, grid.bricks, 0, [&] { std::ranges::fill(bounds, SpreadBounds<T>()); },
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

// Of each value of one byte the least `hi` for which a sample from it to `hi` may show something;
// 256: none. Bricks are many more than bytes.
std::array<uint16_t, 256> leastShown(const ShownValues& shown) {
  std::array<uint16_t, 256> least{};
  uint16_t hi = 0;
  for (uint16_t lo = 0; lo < 256; ++lo) {
    hi = std::max(hi, lo);
    while (hi < 256 && !shown.anyIn(lo, hi)) ++hi;
    least[lo] = hi;
  }
  return least;
}

// 0 where something may show, otherwise kMostDistance. Returns how many bricks show something.
size_t markShown(const LeapGrid& grid, DeviceType type, const ShownValues& shown,
                 std::span<uint8_t> distances) {
  size_t count = 0;
  const auto mark = [&](size_t i, bool shows) {
    distances[i] = shows ? 0 : kMostDistance;
    count += shows ? 1 : 0;
  };
  visitDeviceType(type, [&](auto tag) {
    using T = decltype(tag);
    const auto* ranges = reinterpret_cast<const Range<T>*>(grid.ranges.data());
    if constexpr (std::is_same_v<T, uint8_t>) {
      const std::array<uint16_t, 256> least = leastShown(shown);
      for (size_t i = 0; i < distances.size(); ++i)
        mark(i, ranges[i].lo <= ranges[i].hi && ranges[i].hi >= least[ranges[i].lo]);
    } else {
      for (size_t i = 0; i < distances.size(); ++i)
        mark(i, shown.anyIn(static_cast<double>(ranges[i].lo), static_cast<double>(ranges[i].hi)));
    }
  });
  return count;
}

// Takes into `out` the distance over the bricks `in`, which are `way` bricks away.
void takeFrom(const uint8_t* __restrict in, uint8_t way, uint8_t* __restrict out, int64_t count) {
  for (int64_t i = 0; i < count; ++i) out[i] = std::min(out[i], std::max(in[i], way));
}

// The distance of the greatest axis is separable: along x those of a line, then for each further
// axis the least, over the bricks of a line, of the greater of their distance and the way to them.
void spreadAlongX(std::span<uint8_t> distances, int64_t count) {
  // A line with nothing on both sides, so that each way is one loop without a condition.
  const auto columns = static_cast<size_t>(count);
  std::vector<uint8_t> before(columns + 2 * kMostDistance, kMostDistance);
  for (size_t line = 0; line < distances.size(); line += columns) {
    uint8_t* const out = distances.data() + line;
    std::copy_n(out, columns, before.data() + kMostDistance);
    for (uint8_t way = 1; way < kMostDistance; ++way) {
      takeFrom(before.data() + kMostDistance - way, way, out, count);
      takeFrom(before.data() + kMostDistance + way, way, out, count);
    }
  }
}

// `stride` is the axis's, of which there are `count` bricks.
void spreadAlong(std::span<uint8_t> distances, int64_t count, int64_t stride,
                 std::vector<uint8_t>& before) {
  before.assign(distances.begin(), distances.end());
  const int64_t line = count * stride, all = static_cast<int64_t>(distances.size());
  for (int64_t at = 0; at < all; at += line)
    for (uint8_t way = 1; way < kMostDistance && way < count; ++way) {
      const int64_t shift = way * stride;
      takeFrom(before.data() + at, way, distances.data() + at + shift, line - shift);
      takeFrom(before.data() + at + shift, way, distances.data() + at, line - shift);
    }
}

}  // namespace

LeapGrid leapGrid(const ChunkTexels& chunk, const ExpectedLook* expected, int64_t margin) {
  const Vec3i storage = chunk.storage_vox;
  LeapGrid grid;
  grid.margin = margin;
  for (int a = 0; a < 3; ++a)
    grid.bricks[a] = (std::max<int64_t>(storage[a] - 1, 1) + kBrickSide - 1) / kBrickSide;
  const auto bricks = static_cast<size_t>(volume(grid.bricks));
  grid.ranges.resize(bricks * 2 * bytesPerVoxel(chunk.type));
  visitDeviceType(chunk.type, [&](auto tag) {
    using T = decltype(tag);
    if (chunk.has_spread)
      setRangesOfSpreads<T>(chunk, expected, grid);
    else
      setRanges<T>(chunk, margin, grid);
  });
  return grid;
}

void setDistances(LeapGrid& grid, DeviceType type, const ShownValues& shown) {
  const auto bricks = static_cast<size_t>(volume(grid.bricks));
  grid.distances.assign(bricks + 4, 0);
  const std::span distances(grid.distances.data(), bricks);
  const size_t count = markShown(grid, type, shown, distances);
  grid.shown_share = static_cast<double>(count) / static_cast<double>(bricks);
  if (count == 0) return;
  const Vec3i size = grid.bricks;
  std::vector<uint8_t> before;
  spreadAlongX(distances, size.x);
  spreadAlong(distances, size.y, size.x, before);
  spreadAlong(distances, size.z, size.x * size.y, before);
}

}  // namespace sluice
