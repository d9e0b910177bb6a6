#include "src/classify/transfer/opacity_table.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "src/base/error.h"
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

// Entries of a table of labels.
constexpr int kMostLabelEntries = 1 << 16;

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
  const auto stepAt = [&](ptrdiff_t i) {
    return std::abs(sharp[static_cast<size_t>(i) + 1] - sharp[static_cast<size_t>(i)]);
  };
  float largest = 0;
  for (ptrdiff_t i = 0; i < last; ++i) largest = std::max(largest, stepAt(i));
  // One part more than needed, for the colours and slopes next to the step.
  const auto parts = static_cast<int>(std::min(largest / kVisible, 1000.0F)) + 2;
  const int step_entries =
      parts - 1 <= kMostStepEntries ? std::max(parts - 1, kLeastStepEntries) : kLeastStepEntries;
  // Each entry from which a step is in sight becomes the mean of itself and the step_entries after
  // it: a ramp that ends where the step is, and never 0 for a visible value, even if two steps are
  // close together.
  ptrdiff_t done = 0;  // entries below are final
  for (ptrdiff_t step = 0; step < last; ++step) {
    if (stepAt(step) <= kVisible) continue;
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
  // Each label has an entry of its own.
  const int count =
      entryCount(range_, labels_ && range_.hi - range_.lo < kMostLabelEntries ? kMostLabelEntries
                                                                              : most_entries);
  const auto size = static_cast<size_t>(count);
  opacity_.resize(size);
  rgb_.resize(3 * size);
  SegmentCursor colors(transfer.colors);
  SegmentCursor opacities(transfer.opacities);
  for (size_t i = 0; i < size; ++i) {
    const double value = map.valueOf(deviceAt(i));
    const Vec3d color = colorIn(colors.at(value));
    opacity_[i] = static_cast<float>(opacityIn(opacities.at(value)));
    for (int channel = 0; channel < 3; ++channel)
      rgb_[3 * i + static_cast<size_t>(channel)] = static_cast<float>(color[channel]);
  }
  // Labels lie on their entries, or far from steps.
  if (!labels_) {
    step_entries_ = spreadSteps(opacity_);
    must_interpolate_ = neighborsDiffer();
  }
  addSurfaces(transfer, map);
  shown_ = ShownValues(
      range_, count,
      [&](int entry) { return opacity_[static_cast<size_t>(entry)] > 0 || isSurfaceEntry(entry); },
      ShownValues::reachOf(labels_, range_, count));
  addGradients(transfer, map);
}

void OpacityTable::addSurfaces(const TransferFunction& transfer, const ValueMap& map) {
  // Rounding grows with the values. Rounding of positions, of a few millionths of a voxel, grows
  // with their range. A wider tie would let more surfaces be met twice where two boxes meet.
  const double of_range = (range_.hi - range_.lo) / (1 << 17);
  const double of_values = std::max(std::abs(range_.lo), std::abs(range_.hi)) / (1 << 20);
  surface_tie_ = std::max(of_range, of_values) / 2;
  for (const IsoSurface& surface : transfer.surfaces)
    surfaces_.push_back(
        {map.deviceOf(surface.value) - 2 * surface_tie_, surface.opacity, surface.rgb});
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
  const auto above = std::upper_bound(magnitudes_.begin(), magnitudes_.end(), gradient_lo);
  const auto from = above == magnitudes_.begin() ? above : above - 1;
  const auto last = std::lower_bound(from, magnitudes_.end() - 1, gradient_hi);
  const auto begin = shown_in_row_.begin();
  return std::any_of(begin + (from - magnitudes_.begin()), begin + (last + 1 - magnitudes_.begin()),
                     [&](const ShownValues& shown) { return shown.anyIn(lo, hi); });
}

bool OpacityTable::neighborsDiffer() const {
  for (size_t i = 0; i + 1 < opacity_.size(); ++i) {
    if (std::abs(opacity_[i + 1] - opacity_[i]) > kVisible) return true;
    for (size_t c = 0; c < 3; ++c)
      if (std::abs(opacity_[i + 1] * rgb_[3 * i + 3 + c] - opacity_[i] * rgb_[3 * i + c]) >
          kVisible)
        return true;
  }
  return false;
}

}  // namespace sluice
