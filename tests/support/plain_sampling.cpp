#include "tests/support/plain_sampling.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>

namespace sluice {
namespace {

double texelAt(const ChunkTexels& chunk, Vec3i texel, int number = 0) {
  const Vec3i size = chunk.storage_vox;
  for (int a = 0; a < 3; ++a) texel[a] = std::clamp<int64_t>(texel[a], 0, size[a] - 1);
  const int64_t numbers = chunk.has_spread ? 2 : 1;
  const auto i =
      static_cast<size_t>(((texel.z * size.y + texel.y) * size.x + texel.x) * numbers + number);
  return visitDeviceType(chunk.type, [&](auto tag) {
    decltype(tag) value;
    std::memcpy(&value, chunk.bytes.get() + i * sizeof(value), sizeof(value));
    return static_cast<double>(value);
  });
}

// A position among `count` entries, and the interpolation at it.
struct Entry {
  size_t first = 0, second = 0;
  double part = 0;
};
Entry entryOf(double at, size_t count, bool interpolates) {
  at = std::clamp(at, 0.0, static_cast<double>(count - 1));
  if (!interpolates) at = std::floor(at + 0.5);
  const auto first = static_cast<size_t>(at);
  return {first, std::min(first + 1, count - 1), at - static_cast<double>(first)};
}
double between(const Entry& entry, double first, double second) {
  return first * (1 - entry.part) + second * entry.part;
}

double entryPosition(const LookUp& look_up, double value) {
  const ValueRange range = look_up.device_range;
  if (!(range.hi > range.lo)) return 0;
  return (value - range.lo) / (range.hi - range.lo) *
         (static_cast<double>(look_up.rgba.size() / 4) - 1);
}

// The trilinear weights of the eight texels around, times `number_of` of each texel.
template <class NumberOf>
double interpolated(Vec3d at, const NumberOf& number_of) {
  const Vec3i lo{static_cast<int64_t>(std::floor(at.x)), static_cast<int64_t>(std::floor(at.y)),
                 static_cast<int64_t>(std::floor(at.z))};
  const Vec3d part = at - toDouble(lo);
  double sum = 0;
  for (int corner = 0; corner < 8; ++corner) {
    double weight = 1;
    Vec3i texel = lo;
    for (int a = 0; a < 3; ++a) {
      const int up = corner >> a & 1;
      texel[a] += up;
      weight *= up != 0 ? part[a] : 1 - part[a];
    }
    if (weight > 0) sum += weight * number_of(texel);
  }
  return sum;
}

}  // namespace

double valueAt(const ChunkTexels& chunk, Vec3d at) {
  return interpolated(at, [&](Vec3i texel) { return texelAt(chunk, texel); });
}

double spreadAt(const ChunkTexels& chunk, Vec3d at) {
  return std::sqrt(interpolated(at, [&](Vec3i texel) {
    const double spread = std::max(texelAt(chunk, texel, 1), 0.0);
    return spread * spread;
  }));
}

namespace {

double othersShareAt(const ChunkTexels& chunk, Vec3i texel) {
  return std::clamp(texelAt(chunk, texel, 1) / wholeShare(chunk.type), 0.0, 1.0);
}

// The label with the greatest weight among the texels around that count, which these are.
template <class Counts>
double heaviestAt(const ChunkTexels& chunk, Vec3d at, const Counts& counts) {
  std::map<double, double> weights;
  interpolated(at, [&](Vec3i texel) {
    const double label = texelAt(chunk, texel);
    if (counts(label)) weights[label] = 0;
    return 0.0;
  });
  double best = texelAt(
      chunk, {static_cast<int64_t>(std::floor(at.x)), static_cast<int64_t>(std::floor(at.y)),
              static_cast<int64_t>(std::floor(at.z))});
  double most = -1;
  for (const auto& entry : weights) {
    const double label = entry.first;
    const double weight =
        interpolated(at, [&](Vec3i texel) { return texelAt(chunk, texel) == label ? 1.0 : 0.0; });
    if (weight > most - kLabelTie) {
      best = label;
      most = weight;
    }
  }
  return best;
}

// The 4 x 4 x 4 texels around a place, x fastest; the first is the one before that at or below the
// place.
using Around = std::array<double, 64>;
Vec3i texelAround(Vec3d at, size_t i) {
  const auto n = static_cast<int64_t>(i);
  return Vec3i{static_cast<int64_t>(std::floor(at.x)) - 1,
               static_cast<int64_t>(std::floor(at.y)) - 1,
               static_cast<int64_t>(std::floor(at.z)) - 1} +
         Vec3i{n % 4, n / 4 % 4, n / 16};
}
double partAlong(Vec3d at, int axis) {
  return at[axis] - std::floor(at[axis]);
}

// The sum of the texels by the products of three axes' weights.
using AxisWeights = std::array<double, 4>;
double weighted(const Around& numbers, const std::array<AxisWeights, 3>& weights) {
  double sum = 0;
  for (size_t i = 0; i < numbers.size(); ++i)
    sum += numbers[i] * weights[0][i % 4] * weights[1][i / 4 % 4] * weights[2][i / 16];
  return sum;
}
// The weights that three texels have at the two texels around, interpolated between these.
AxisWeights alongAxis(double part, const std::array<double, 3>& three) {
  AxisWeights weights{};
  for (size_t i = 0; i < three.size(); ++i) {
    weights[i] += (1 - part) * three[i];
    weights[i + 1] += part * three[i];
  }
  return weights;
}
std::array<AxisWeights, 3> smoothingAt(Vec3d at) {
  std::array<AxisWeights, 3> weights{};
  for (int a = 0; a < 3; ++a)
    weights[static_cast<size_t>(a)] = alongAxis(partAlong(at, a), {0.25, 0.5, 0.25});
  return weights;
}

// The slope along each axis of Sobel's operator at the eight texels around a place, trilinear.
Vec3d sobelAt(Vec3d at, const Around& numbers) {
  Vec3d slopes;
  for (int axis = 0; axis < 3; ++axis) {
    auto weights = smoothingAt(at);
    weights[static_cast<size_t>(axis)] = alongAxis(partAlong(at, axis), {-0.5, 0, 0.5});
    slopes[axis] = weighted(numbers, weights);
  }
  return slopes;
}
// The mean of the same texels by 1/4, 1/2 and 1/4 along each axis.
double smoothedAt(Vec3d at, const Around& numbers) {
  return weighted(numbers, smoothingAt(at));
}
// The least of the same texels: along each axis the least of four, the outer ones as
// rough_light.h says; then along the next axis.
double leastAt(Vec3d at, Around numbers) {
  size_t count = numbers.size() / 4;
  for (int axis = 0; axis < 3; ++axis, count /= 4) {
    const double part = partAlong(at, axis);
    const double after = std::max(0.0, 2 * part - 1), before = std::max(0.0, 1 - 2 * part);
    for (size_t i = 0; i < count; ++i) {
      const double* four = &numbers[4 * i];
      numbers[i] = std::min({four[0] * (1 - after) + four[1] * after, four[1], four[2],
                             four[3] * (1 - before) + four[2] * before});
    }
  }
  return numbers[0];
}

}  // namespace

double labelAt(const ChunkTexels& chunk, Vec3d at) {
  return heaviestAt(chunk, at, [](double) { return true; });
}

ShownLabel shownLabelAt(const ChunkTexels& chunk, const LookUp& look_up, Vec3d at) {
  const auto shows = [&](double label) {
    return label >= kNoNumber && lookedUp(look_up, label, false)[3] > 0;
  };
  double fullest = 0;
  for (int64_t corner = 0; corner < 8; ++corner) {
    const Vec3i texel{static_cast<int64_t>(std::floor(at.x)) + corner % 2,
                      static_cast<int64_t>(std::floor(at.y)) + corner / 2 % 2,
                      static_cast<int64_t>(std::floor(at.z)) + corner / 4};
    if (shows(texelAt(chunk, texel))) fullest = std::max(fullest, 1 - othersShareAt(chunk, texel));
  }
  const double body = std::clamp(4 * fullest - 2, 0.0, 1.0);
  const double share = interpolated(at, [&](Vec3i texel) {
    const double others = othersShareAt(chunk, texel);
    return shows(texelAt(chunk, texel)) ? 1 - others : body * others;
  });
  return {heaviestAt(chunk, at, shows),
          (1 - body) * share + body * std::clamp(2 * share - 0.5, 0.0, 1.0)};
}

double sharedOpacity(double opacity, double part, double lengths, double voxel) {
  const double whole = 1 - std::pow(1 - opacity, voxel);
  return 1 - std::pow(1 - part * whole, lengths / voxel);
}

Vec3d labelSlopesAt(const ChunkTexels& chunk, const LookUp& look_up, Vec3d at) {
  Around opacities{};
  std::map<double, double> shown;  // labels and their opacities
  for (size_t i = 0; i < opacities.size(); ++i) {
    const double label = texelAt(chunk, texelAround(at, i));
    opacities[i] = label < kNoNumber ? 0.0 : lookedUp(look_up, label, false)[3];
    if (opacities[i] > 0) shown[label] = opacities[i];
  }
  if (chunk.has_spread && shown.size() == 1) {
    double fullest = 0;
    for (size_t i = 0; i < opacities.size(); ++i)
      if (opacities[i] > 0)
        fullest = std::max(fullest, 1 - othersShareAt(chunk, texelAround(at, i)));
    const double body = std::clamp(4 * fullest - 2, 0.0, 1.0);
    for (size_t i = 0; i < opacities.size(); ++i) {
      const double others = othersShareAt(chunk, texelAround(at, i));
      opacities[i] = shown.begin()->second * (opacities[i] > 0 ? 1 - others : body * others);
    }
  }
  return sobelAt(at, opacities);
}

std::optional<WideSlopes> wideSlopesAt(const ChunkTexels& chunk, Vec3d at, double texel_voxels) {
  const double first = texelAt(chunk, texelAround(at, 21));  // at or below the place
  Around means{}, below{}, squares{}, spreads{};
  for (size_t i = 0; i < means.size(); ++i) {
    const Vec3i texel = texelAround(at, i);
    const double value = texelAt(chunk, texel);
    if (value < kNoNumber) return {};
    means[i] = value - first;
    below[i] = -means[i];
    spreads[i] = std::max(texelAt(chunk, texel, 1), 0.0);
    squares[i] = means[i] * means[i] + spreads[i] * spreads[i] / 4;
  }
  const Vec3d slopes = sobelAt(at, means);
  const double mean = smoothedAt(at, means);
  const double variance = std::max(0.0, smoothedAt(at, squares) - mean * mean);
  const double spread = spreadAt(chunk, at);
  const double bottom = leastAt(at, means);
  const double height = -leastAt(at, below) - bottom;
  const double calm = leastAt(at, spreads);

  // Values that are all alike have no edge.
  const double full = height > 0 ? std::clamp((mean - bottom) / height, 0.02, 1.0) : 1;
  const double of_edge =
      height > 0 ? variance / (height * height * std::max(full * (1 - full), 1e-3)) : 0;
  const double sharp = std::clamp((of_edge - 0.2) / (0.7 - 0.2), 0.0, 1.0);
  // Ten voxels.
  const double layer = height > 0 ? 10 / texel_voxels * length(slopes) / height : 1;
  const double narrow = std::max(0.01, std::lerp(1, std::min(1.0, layer), sharp));
  // A spread is twice the deviation, whose square counts twice.
  const double even = dot(slopes, slopes), own = even * 5 / 6 + 2 * (spread / 2) * (spread / 2);
  const double here = variance > 0 ? std::pow(std::min(1.0, own / variance), 3) : 1.0;
  const double counted = std::min(spread * spread, std::max(0.0, 4 * variance - 3 * even));
  const double noise = std::max(0.0, std::min(calm * calm, counted) - even / 3);
  return WideSlopes{slopes, std::lerp(here, 1, sharp) / (narrow * narrow),
                    std::lerp(1, std::min(1.0, layer / (2 * full)), sharp), std::sqrt(counted),
                    std::sqrt(noise)};
}

MeanLook::MeanLook(const LookUp& look_up) {
  const size_t entries = look_up.rgba.size() / 4;
  const ValueRange range = look_up.device_range;
  if (range.hi > range.lo) scale_ = static_cast<double>(entries - 1) / (range.hi - range.lo);
  offset_ = -range.lo * scale_;
  const auto extinctionOf = [&](size_t entry) {
    const float* rgba = &look_up.rgba[4 * entry];
    const double clear = 1 - static_cast<double>(rgba[3]);
    const double extinction = clear > 0 ? std::min(-std::log2(clear), 16.0) : 16;
    return std::array<double, 4>{rgba[0] * extinction, rgba[1] * extinction, rgba[2] * extinction,
                                 extinction};
  };
  sums_.push_back({});
  alone_.push_back(extinctionOf(0));
  for (size_t i = 0; i + 1 < std::max<size_t>(entries, 2); ++i) {
    const auto a = extinctionOf(i), b = extinctionOf(std::min(i + 1, entries - 1));
    alone_.push_back(b);
    auto sum = sums_.back();
    auto& density = densities_.emplace_back();
    for (size_t c = 0; c < 4; ++c) {
      density[c] = (a[c] + b[c]) / 2;
      sum[c] += density[c];
    }
    sums_.push_back(sum);
  }
}

std::array<double, 4> MeanLook::densityAt(double entry) const {
  const double last = static_cast<double>(densities_.size()) - 1;
  return densities_[static_cast<size_t>(std::clamp(std::floor(entry), 0.0, last))];
}

std::array<double, 4> MeanLook::sumBelow(double entry) const {
  const double last = static_cast<double>(densities_.size()) - 1;
  const double first = std::clamp(std::floor(entry), 0.0, last);
  std::array<double, 4> sum = sums_[static_cast<size_t>(first)];
  for (size_t c = 0; c < 4; ++c) sum[c] += densityAt(entry)[c] * (entry - first);
  return sum;
}

std::array<double, 4> MeanLook::between(double from, double to) const {
  const double a = from * scale_ + offset_, b = to * scale_ + offset_;
  const Entry middle = entryOf((a + b) / 2, alone_.size(), true);
  std::array<double, 4> mean{};
  for (size_t c = 0; c < 4; ++c)
    mean[c] = std::lerp(alone_[middle.first][c], alone_[middle.second][c], middle.part);
  const double last = static_cast<double>(alone_.size()) - 1;
  const bool beyond = std::max(a, b) <= 0 || std::min(a, b) >= last;
  if (std::abs(b - a) > 1e-6 && !beyond) {
    const auto below_a = sumBelow(a), below_b = sumBelow(b);
    for (size_t c = 0; c < 4; ++c) mean[c] = (below_b[c] - below_a[c]) / (b - a);
  }
  for (size_t c = 0; c < 3; ++c) mean[c] = mean[3] > 0 ? mean[c] / mean[3] : 0;
  mean[3] = 1 - std::exp2(-mean[3]);
  return mean;
}

std::array<double, 4> lookedUp(const LookUp& look_up, double value, bool interpolates) {
  const Entry entry = entryOf(entryPosition(look_up, value), look_up.rgba.size() / 4, interpolates);
  std::array<double, 4> rgba{};
  for (size_t c = 0; c < 4; ++c)
    rgba[c] = between(entry, look_up.rgba[4 * entry.first + c], look_up.rgba[4 * entry.second + c]);
  return rgba;
}

ExpectedEntry expectedAt(const ExpectedLook& look, double mean, double spread) {
  const double span = look.device_range.hi - look.device_range.lo;
  const double row = std::sqrt(std::max(spread, 0.0) / span) * look.rows;
  const Entry in_row = entryOf((mean - look.device_range.lo) / span * (look.entries - 1),
                               static_cast<size_t>(look.entries), true);
  const Entry rows = entryOf(row - 1, static_cast<size_t>(look.rows), true);
  ExpectedEntry result;
  for (size_t c = 0; c < 4; ++c) {
    const auto inRow = [&](size_t r) {
      const float* of_row = &look.rgba[4 * r * static_cast<size_t>(look.entries)];
      return between(in_row, of_row[4 * in_row.first + c], of_row[4 * in_row.second + c]);
    };
    result.rgba[c] = between(rows, inRow(rows.first), inRow(rows.second));
  }
  result.share = std::min(row, 1.0);
  return result;
}

double factorOf(const LookUp& look_up, double magnitude, double value) {
  const std::vector<double>& rows = look_up.magnitudes;
  if (rows.empty()) return 1;
  const size_t entries = look_up.factors.size() / rows.size();
  const Entry entry = entryOf(entries > 1 ? entryPosition(look_up, value) : 0, entries, true);
  const auto inRow = [&](size_t row) {
    const float* factors = &look_up.factors[row * entries];
    return between(entry, factors[entry.first], factors[entry.second]);
  };
  if (magnitude <= rows.front()) return inRow(0);
  for (size_t row = 1; row < rows.size(); ++row)
    if (magnitude < rows[row])
      return between({0, 0, (magnitude - rows[row - 1]) / (rows[row] - rows[row - 1])},
                     inRow(row - 1), inRow(row));
  return inRow(rows.size() - 1);
}

}  // namespace sluice
