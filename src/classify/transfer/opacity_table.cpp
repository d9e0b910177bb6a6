#include "src/classify/transfer/opacity_table.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstring>

#include "src/base/error.h"
#include "src/base/wide_vectors.h"
#include "src/classify/transfer/label_table.h"
#include "src/classify/transfer/segments.h"

namespace sluice {
namespace {

// Neighbouring entries may differ by this much, of 1: half of a step of an 8-bit picture.
constexpr float kVisible = 0.5F / 255;
// The least entries that a step is spread over, so that rounding changes little, and the most: if
// neighbours then differ invisibly, samples need not interpolate.
constexpr int kLeastStepEntries = 4, kMostStepEntries = 8;

// Widens `all` by the values that the colours span if voxels have 8 bits, for which there are
// entries enough. So a step of a series whose values span less gets the same entries as with the
// range of all steps.
ValueRange withColors(const TransferFunction& transfer, const ValueMap& map, ValueRange all) {
  constexpr double kMostOf8Bits = 255;
  // Tables of labels have an entry for each, and other types too many values for one each.
  if (map.type != DeviceType::kU8 || transfer.labels || !(all.lo < all.hi)) return all;
  const auto [from, to] = std::minmax(
      {map.deviceOf(transfer.colors.front().value), map.deviceOf(transfer.colors.back().value)});
  return {std::min(all.lo, std::max(std::floor(from), 0.0)),
          std::max(all.hi, std::min(std::ceil(to), kMostOf8Bits))};
}

// The part of `all` over which the transfer function changes, if it is so small a part that it
// would get few entries: simulations write a value far off the data where they know nothing. Beyond
// the table its ends hold.
ValueRange tableRange(const TransferFunction& transfer, const ValueMap& map, ValueRange all) {
  constexpr double kFewOfAll = 1.0 / 64, kMargin = 1.0 / 64;
  double lo = std::min(transfer.colors.front().value, transfer.opacities.front().value);
  double hi = std::max(transfer.colors.back().value, transfer.opacities.back().value);
  for (const IsoSurface& surface : transfer.surfaces) {
    lo = std::min(lo, surface.value);
    hi = std::max(hi, surface.value);
  }
  for (const GradientRow& row : transfer.gradients) {
    if (row.factors.size() == 1) continue;  // constant
    lo = std::min(lo, row.factors.front().value);
    hi = std::max(hi, row.factors.back().value);
  }
  const auto [from, to] = std::minmax({map.deviceOf(lo), map.deviceOf(hi)});
  // Something on both sides of a lone step too.
  const double margin = std::max(kMargin * (to - from), 1e-3 * std::max(-from, to));
  ValueRange part{from - margin, to + margin};
  if (map.type != DeviceType::kF32) part = {std::floor(part.lo), std::ceil(part.hi)};
  part = {std::max(part.lo, all.lo), std::min(part.hi, all.hi)};
  const bool is_few = part.lo < part.hi && part.hi - part.lo < kFewOfAll * (all.hi - all.lo);
  return is_few ? part : all;
}

// The entries that a table of labels may have: enough for each label to have its own, if there may
// be so many.
int labelEntries(ValueRange range) {
  constexpr double kLeast = 1 << 16;
  return static_cast<int>(
      std::clamp(std::floor(range.hi - range.lo) + 1, kLeast, double{kMostLabelEntries}));
}

// Each integer falls on an entry, of floats that hold integers too.
int entryCount(ValueRange range, int most) {
  const double span = range.hi - range.lo;
  const bool has_integers = std::floor(range.lo) == range.lo && std::floor(span) == span;
  if (!has_integers || span < 1 || span > most - 1) return most;
  return static_cast<int>(std::floor((most - 1) / span) * span) + 1;
}

// Makes ramps of the steps of `entries`, see the header. Returns over how many entries.
int spreadSteps(std::vector<float>& entries) {
  const std::vector<float> sharp = entries;
  const auto last = static_cast<ptrdiff_t>(sharp.size()) - 1;
  // Some more steps of nothing, so that the loop for the greatest takes eight at once.
  constexpr size_t kLanes = 8;
  std::vector<float> steps(sharp.size() + kLanes);
  for (size_t i = 0; i + 1 < sharp.size(); ++i) steps[i] = std::abs(sharp[i + 1] - sharp[i]);
  std::array<float, kLanes> lanes{};
  for (size_t i = 0; i < sharp.size(); i += kLanes)
    for (size_t lane = 0; lane < kLanes; ++lane)
      lanes[lane] = std::max(lanes[lane], steps[i + lane]);
  const float largest = std::ranges::max(lanes);
  // One part more than needed, for the colours and slopes next to the step.
  const auto parts = static_cast<int>(std::min(largest / kVisible, 1000.0F)) + 2;
  const int step_entries =
      parts - 1 <= kMostStepEntries ? std::max(parts - 1, kLeastStepEntries) : kLeastStepEntries;
  // Each entry from which a step is in sight becomes the mean of itself and the step_entries after
  // it: a ramp that ends where the step is, and never 0 for a visible value, even if two steps are
  // close together.
  ptrdiff_t done = 0;  // entries below are final
  for (ptrdiff_t step = 0; step < last; ++step) {
    if (steps[static_cast<size_t>(step)] <= kVisible) continue;
    for (ptrdiff_t i = std::max(done, step + 1 - step_entries); i <= step; ++i) {
      float sum = 0;
      for (ptrdiff_t k = i; k <= i + step_entries; ++k)
        sum += sharp[static_cast<size_t>(std::min(k, last))];
      entries[static_cast<size_t>(i)] = sum / static_cast<float>(step_entries + 1);
      done = i + 1;
    }
  }
  return step_entries;
}

}  // namespace

OpacityTable::OpacityTable(const TransferFunction& transfer, const ValueMap& map,
                           ValueRange device_range, int most_entries)
    : range_(tableRange(transfer, map, withColors(transfer, map, device_range))),
      volume_range_(device_range),
      labels_(transfer.labels) {
  SLUICE_CHECK_LE(2, most_entries);
  const int count = entryCount(range_, labels_ ? labelEntries(range_) : most_entries);
  const auto size = static_cast<size_t>(count);
  opacity_.resize(size);
  rgba_.resize(4 * size);
  inWideVectors([&] { sample(transfer, map); });
  // Labels lie on their entries, or far from steps.
  if (!labels_) step_entries_ = spreadSteps(opacity_);
  // Steps are spread before the opacity goes into the colours' table, so that both agree.
  for (size_t i = 0; i < size; ++i) rgba_[4 * i + 3] = opacity_[i];
  if (!labels_) must_interpolate_ = neighborsDiffer();
  addSurfaces(transfer, map);
  // Surfaces count as shown, even where the opacity is 0.
  shown_ = ShownValues(
      range_, count,
      [&](int entry) { return opacity_[static_cast<size_t>(entry)] > 0 || isSurfaceEntry(entry); },
      ShownValues::reachOf(labels_, range_, count));
  addGradients(transfer, map);
}

void OpacityTable::sample(const TransferFunction& transfer, const ValueMap& map) {
  const size_t size = opacity_.size();
  std::vector<double> values(size), ways(size), parts(size);
  // Copies, so that the loop can be vectorized.
  const ValueRange range = range_;
  const ValueMap to_value = map;
  const auto last = std::max(1.0, static_cast<double>(size) - 1);
  double* const out = values.data();
  for (int i = 0; i < entries(); ++i)
    out[i] = to_value.valueOf(range.lo + (range.hi - range.lo) * i / last);
  const auto put = [&](const auto& run, float* out, size_t stride) {
    for (size_t i = run.first; i < run.end; ++i) out[stride * i] = static_cast<float>(parts[i]);
  };
  eachRun(transfer.opacities, values, [&](const SegmentRun<OpacityPoint>& run) {
    waysOf(run, values, ways);
    lerpRun(run.a.opacity, run.b.opacity, run.of(ways), run.of(parts));
    put(run, opacity_.data(), 1);
  });
  eachRun(transfer.colors, values, [&](const SegmentRun<ColorPoint>& run) {
    waysOf(run, values, ways);
    for (int c = 0; c < 3; ++c) {
      lerpRun(run.a.rgb[c], run.b.rgb[c], run.of(ways), run.of(parts));
      put(run, rgba_.data() + c, 4);
    }
  });
}

void OpacityTable::addSurfaces(const TransferFunction& transfer, const ValueMap& map) {
  // Rounding grows with the values. Rounding of positions, of a few millionths of a voxel, grows
  // with their range. A wider tie would let more surfaces be met twice where two boxes meet.
  const double of_range = (range_.hi - range_.lo) / (1 << 17);
  const double of_values = std::max(std::abs(range_.lo), std::abs(range_.hi)) / (1 << 20);
  // Values this close to a level may be on either of its sides by rounding.
  const double tie = std::max(of_range, of_values) / 2;
  for (const IsoSurface& surface : transfer.surfaces)
    // A little below the value, so that plateaus of it lie clearly on one side.
    surfaces_.push_back({map.deviceOf(surface.value) - 2 * tie, surface.opacity, surface.rgb});
  std::ranges::sort(surfaces_, {}, &SurfaceLevel::level);
  const ShownValues all(range_, entries(), [](int) { return true; });
  for (const SurfaceLevel& surface : surfaces_)
    surface_entries_.push_back(all.entryOf(surface.level));
}

bool OpacityTable::isSurfaceEntry(int entry) const {
  return std::ranges::find(surface_entries_, entry) != surface_entries_.end();
}

void OpacityTable::addGradients(const TransferFunction& transfer, const ValueMap& map) {
  const std::vector<GradientRow>& rows = transfer.gradients;
  const bool depends = std::any_of(rows.begin(), rows.end(),
                                   [](const GradientRow& row) { return row.factors.size() > 1; });
  for (const GradientRow& row : rows) {
    magnitudes_.push_back(row.magnitude / std::abs(map.scale));
    std::vector<float> factors(depends ? opacity_.size() : 1);
    for (size_t i = 0; i < factors.size(); ++i)
      factors[i] = static_cast<float>(gradientFactorAt(row, map.valueOf(deviceAt(i))));
    if (depends) step_entries_ = std::max(step_entries_, spreadSteps(factors));
    // A factor is interpolated, so it reaches to the neighbouring entries.
    shown_in_row_.emplace_back(range_, entries(), [&](int entry) {
      const auto i = static_cast<size_t>(entry);
      if (isSurfaceEntry(entry)) return true;
      if (!(opacity_[i] > 0)) return false;
      if (!depends) return factors[0] > 0;
      return factors[i] > 0 || (i > 0 && factors[i - 1] > 0) ||
             (i + 1 < factors.size() && factors[i + 1] > 0);
    });
    factors_.insert(factors_.end(), factors.begin(), factors.end());
  }
}

bool OpacityTable::showsAny(double lo, double hi, double gradient_lo, double gradient_hi) const {
  if (magnitudes_.empty()) return shown_.anyIn(lo, hi);
  // From the last row at or below the least magnitude to the first at or above the greatest:
  // between two rows both have a part.
  // Rows hold beyond their ends, so that the first and the last answer for all magnitudes there.
  const auto above = std::upper_bound(magnitudes_.begin(), magnitudes_.end(), gradient_lo);
  const auto from = above == magnitudes_.begin() ? above : above - 1;
  const auto last = std::lower_bound(from, magnitudes_.end() - 1, gradient_hi);
  const auto begin = shown_in_row_.begin();
  return std::any_of(begin + (from - magnitudes_.begin()), begin + (last + 1 - magnitudes_.begin()),
                     [&](const ShownValues& shown) { return shown.anyIn(lo, hi); });
}

bool OpacityTable::neighborsDiffer() const {
  for (size_t i = 0; i + 1 < opacity_.size(); ++i)
    if (std::abs(opacity_[i + 1] - opacity_[i]) > kVisible) return true;
  // Four numbers at once: the last one stands for nothing.
  using Numbers [[gnu::vector_size(16)]] = float;
  const auto shownAt = [this](size_t entry) {
    Numbers rgba;
    std::memcpy(&rgba, &rgba_[4 * entry], sizeof rgba);
    return rgba * opacity_[entry];
  };
  Numbers before = shownAt(0);
  auto differs = before != before;
  for (size_t i = 1; i < opacity_.size(); ++i) {
    const Numbers now = shownAt(i), change = now - before;
    differs |= (change > kVisible) | (change < -kVisible);
    before = now;
  }
  return differs[0] != 0 || differs[1] != 0 || differs[2] != 0;
}

}  // namespace sluice
