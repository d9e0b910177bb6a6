#include "src/visibility/plenoptic/opacity_function.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "src/base/error.h"

namespace sluice {
namespace {

constexpr float kOutside = std::numeric_limits<float>::max();

// Slabs of parts that a ray must cross whole for the table's ratio.
int64_t leastSlabs(int64_t slabs) {
  return std::max<int64_t>(1, slabs / 2 - 1);
}

// A block's parts as seen along one axis: excess over the floor, u fastest, w the axis.
struct Turned {
  int64_t nu, nv, nw;
  double last_slab = 1;  // how much of a slab the last one is
  double voxel = 0.25;   // in slabs
  std::vector<float> excess;

  const float* row(int64_t v, int64_t w) const { return excess.data() + (w * nv + v) * nu; }
  double slab(int64_t w) const { return w + 1 == nw ? last_slab : 1; }
};

Turned turnedTo(int axis, const BlockParts& parts, float floor) {
  const Vec3i count = parts.grid.count();
  const int u = (axis + 1) % 3, v = (axis + 2) % 3;
  Turned turned{count[u], count[v], count[axis], 1, 1 / static_cast<double>(parts.grid.side), {}};
  turned.last_slab =
      static_cast<double>(parts.grid.cells[axis] - (turned.nw - 1) * parts.grid.side) *
      turned.voxel;
  turned.excess.resize(parts.least.size());
  std::array<int64_t, 3> stride = {1, count.x, count.x * count.y};
  size_t to = 0;
  for (int64_t w = 0; w < turned.nw; ++w)
    for (int64_t j = 0; j < turned.nv; ++j)
      for (int64_t i = 0; i < turned.nu; ++i, ++to) {
        const int64_t from = i * stride[static_cast<size_t>(u)] +
                             j * stride[static_cast<size_t>(v)] +
                             w * stride[static_cast<size_t>(axis)];
        turned.excess[to] = parts.least[static_cast<size_t>(from)] - floor;
      }
  return turned;
}

void takeLeast(const float* __restrict from, float* __restrict least, int64_t count) {
  for (int64_t i = 0; i < count; ++i) least[i] = std::min(least[i], from[i]);
}

// The parts lo..hi, in whole parts, that rays through [0, 1] at the reference plane can reach in
// slab w.
struct Window {
  int64_t lo, hi;
};
Window windowAt(double slope_lo, double slope_hi, double from, double to) {
  // A product of two intervals has its extremes at their ends.
  const auto [a, b] = std::minmax({slope_lo * from, slope_lo * to, slope_hi * from, slope_hi * to});
  return {static_cast<int64_t>(std::floor(a)), static_cast<int64_t>(std::ceil(b))};
}

// Beams: all rays of one cell of directions that pass through one part of the middle plane, or of
// its continuation outside the block. In each slab a beam may be in a window of parts, and has at
// least the least of their extinctions.
class Beams {
 public:
  Beams(const Turned& parts, const DirectionSlopes& slopes) : parts_(parts) {
    const double middle = 0.5 * static_cast<double>(parts.nw);
    Window u{0, 0}, v{0, 0};
    for (int64_t w = 0; w < parts.nw; ++w) {
      const double from = static_cast<double>(w) - middle, to = from + parts.slab(w);
      u_.push_back(windowAt(slopes.u_lo, slopes.u_hi, from, to));
      v_.push_back(windowAt(slopes.v_lo, slopes.v_hi, from, to));
      u = {std::min(u.lo, u_.back().lo), std::max(u.hi, u_.back().hi)};
      v = {std::min(v.lo, v_.back().lo), std::max(v.hi, v_.back().hi)};
    }
    // All beams that can meet the block somewhere, also those whose middle lies outside.
    first_u_ = -u.hi, count_u_ = parts.nu - u.lo + u.hi;
    first_v_ = -v.hi, count_v_ = parts.nv - v.lo + v.hi;
    gather();
  }

  // The least mean excess of any run of slabs that is long enough.
  float leastRatio() const {
    const int64_t least = leastSlabs(parts_.nw);
    float ratio = kOutside;
    // At 0 or below, the table says no more than the floor.
    for (int64_t beam = 0; beam < count_u_ * count_v_ && ratio > 0; ++beam) {
      int64_t first = 0;
      while (first < parts_.nw) {
        if (inSlab(beam, first) == kOutside) {
          ++first;
          continue;
        }
        int64_t end = first + 1;
        while (end < parts_.nw && inSlab(beam, end) != kOutside) ++end;
        ratio = std::min(ratio, leastOfRuns(beam, first, end, least));
        first = end;
      }
    }
    return ratio == kOutside ? 0 : std::max(ratio, 0.0F);
  }

 private:
  float inSlab(int64_t beam, int64_t w) const {
    return least_[static_cast<size_t>(w * count_u_ * count_v_ + beam)];
  }

  // Window minima, one axis after the other: a window's minimum is the minimum of its rows' minima.
  void gather() {
    least_.assign(static_cast<size_t>(parts_.nw * count_u_ * count_v_), kOutside);
    std::vector<float> rows(static_cast<size_t>(parts_.nv * count_u_));
    for (int64_t w = 0; w < parts_.nw; ++w) {
      const Window u = u_[static_cast<size_t>(w)], v = v_[static_cast<size_t>(w)];
      std::ranges::fill(rows, kOutside);
      for (int64_t j = 0; j < parts_.nv; ++j)
        // All beams of a row at once, one part of their windows after the other.
        for (int64_t shift = first_u_ + u.lo; shift <= first_u_ + u.hi; ++shift) {
          const int64_t first = std::max<int64_t>(0, -shift);
          const int64_t count = std::min(count_u_, parts_.nu - shift) - first;
          if (count > 0)
            takeLeast(parts_.row(j, w) + first + shift, rows.data() + j * count_u_ + first, count);
        }
      float* to = least_.data() + w * count_u_ * count_v_;
      for (int64_t j = 0; j < count_v_; ++j) {
        const int64_t end = std::min(parts_.nv - 1, first_v_ + j + v.hi);
        for (int64_t k = std::max<int64_t>(0, first_v_ + j + v.lo); k <= end; ++k)
          takeLeast(rows.data() + k * count_u_, to + j * count_u_, count_u_);
      }
    }
  }

  // The least ratio over runs of at least `least` slabs within [first, end), the slabs that the
  // beam may pass. Only runs shorter than 2 * `least` are looked at, because longer ones consist of
  // them.
  float leastOfRuns(int64_t beam, int64_t first, int64_t end, int64_t least) const {
    float ratio = kOutside;
    for (int64_t from = first; from + least <= end; ++from) {
      // Samples at distances of up to a voxel may miss that much of each rise: see the header of
      // visibility_estimate.h. Rises are counted from the slab before the run on, whose excess is
      // itself one, to the one behind it.
      double sum = 0, length = 0;
      double rises = from > first ? inSlab(beam, from - 1) : 0;
      float last = from > first ? inSlab(beam, from - 1) : 0;
      for (int64_t w = from; w < std::min(end, from + 2 * least); ++w) {
        const float here = inSlab(beam, w);
        rises += std::max(0.0F, here - last);
        last = here;
        sum += static_cast<double>(here) * parts_.slab(w);
        length += parts_.slab(w);
        if (w + 1 - from < least) continue;
        const double behind = w + 1 < end ? std::max(0.0F, inSlab(beam, w + 1) - here) : 0;
        ratio =
            std::min(ratio, static_cast<float>((sum - (rises + behind) * parts_.voxel) / length));
      }
    }
    return ratio;
  }

  const Turned& parts_;
  std::vector<Window> u_, v_;
  int64_t first_u_ = 0, first_v_ = 0, count_u_ = 0, count_v_ = 0;
  std::vector<float> least_;  // [slab][v][u]; kOutside if a beam is outside the block
};

}  // namespace

double leastDepthVox(const PartGrid& grid, int axis) {
  return static_cast<double>((leastSlabs(grid.count()[axis]) + 1) * grid.side);
}

OpacityFunction opacityFunction(const BlockParts& cubes, const DirectionGrid& directions,
                                int detail_bits) {
  OpacityFunction function;
  std::vector<uint8_t> packed(cubes.least.size());
  std::ranges::transform(cubes.least, packed.begin(), packExtinction);
  DetailedParts detailed = detailedParts(cubes.grid, packed, detail_bits);
  BlockParts parts{partsOfCubes(cubes.grid), {}};
  for (const uint8_t v : detailed.parts) parts.least.push_back(unpackExtinction(v));
  const float floor = parts.floor();
  function.floor = packExtinction(floor);
  // All parts are alike: the floor tells everything.
  if (detailed.detail.empty() && parts.uniform()) return function;
  function.parts = std::move(detailed.parts);
  function.detail = std::move(detailed.detail);
  if (parts.uniform()) return function;
  const std::array<Turned, 3> turned = {turnedTo(0, parts, floor), turnedTo(1, parts, floor),
                                        turnedTo(2, parts, floor)};
  for (int cell = 0; cell < directions.count(); ++cell) {
    const DirectionSlopes slopes = directions.slopesOf(cell);
    const Beams beams(turned[static_cast<size_t>(slopes.axis)], slopes);
    function.ratios.push_back(packExtinction(floor + beams.leastRatio()));
  }
  // A table that says no more than the floor takes space for nothing.
  const bool says_more = std::any_of(function.ratios.begin(), function.ratios.end(),
                                     [&](uint8_t ratio) { return ratio > function.floor; });
  if (!says_more) function.ratios.clear();
  return function;
}

OpacityFunction combined(const std::vector<const OpacityFunction*>& functions,
                         const std::vector<double>& exponents, const PartGrid& cubes) {
  SLUICE_CHECK_EQ(functions.size(), exponents.size());
  OpacityFunction result;
  std::vector<float> ratios, of_cubes;
  // Extinctions add up, each times its exponent (equation 4 of Gao 2004).
  float floor = 0;
  for (size_t i = 0; i < functions.size(); ++i) {
    const OpacityFunction& function = *functions[i];
    const auto k = static_cast<float>(exponents[i]);
    if (function.empty() || k == 0) continue;
    const auto add = [&](const std::vector<uint8_t>& values, std::vector<float>& sums) {
      // `floor` holds what functions of a floor alone have added so far.
      if (sums.empty() && !values.empty()) sums.assign(values.size(), floor);
      for (size_t at = 0; at < sums.size(); ++at)
        sums[at] += k * unpackExtinction(values.empty() ? function.floor : values[at]);
    };
    add(function.ratios, ratios);
    add(function.parts.empty() ? function.parts : cubesOf(cubes, function.parts, function.detail),
        of_cubes);
    floor += k * unpackExtinction(function.floor);
  }
  result.floor = packExtinction(floor);
  for (const float ratio : ratios) result.ratios.push_back(packExtinction(ratio));
  if (of_cubes.empty()) return result;
  std::vector<uint8_t> packed(of_cubes.size());
  std::ranges::transform(of_cubes, packed.begin(), packExtinction);
  // Packed anew: the sum of several functions may be worth other bits than each of them.
  DetailedParts detailed = detailedParts(cubes, packed, kMostDetailBits);
  result.parts = std::move(detailed.parts);
  result.detail = std::move(detailed.detail);
  return result;
}

}  // namespace sluice
