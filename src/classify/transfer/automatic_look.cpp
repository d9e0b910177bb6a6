// automaticLook: from the findings of histogram_analysis.h to colours and opacities.
#include "src/classify/transfer/automatic_look.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <limits>
#include <numeric>
#include <utility>

#include "src/base/error.h"
#include "src/classify/transfer/color_maps.h"
#include "src/classify/transfer/histogram_analysis.h"
#include "src/classify/transfer/hounsfield.h"
#include "src/classify/transfer/transfer_makers.h"

namespace sluice {
namespace {

// Bins of a histogram, for decisions that need fine ones.
constexpr size_t kFineBins = 4096;
// Optical depth (-ln of the transmittance) of a ray through everything visible: dense enough that
// the front is read as a surface, thin enough that matter behind it adds to it.
constexpr double kOpticalDepth = 6;
// No voxel hides all that is behind it: steps between voxels would show as rings.
constexpr double kLargestOpacity = 0.5;
// The ramp's points between threshold and top, as shares of its width and height.
constexpr std::array<double, 9> kPlaces = {0, 0.03, 0.1, 0.2, 0.35, 0.5, 0.65, 0.8, 1};

// `value` with as few digits as tell 5000 values of `span` apart; finite, whatever was added to it.
double tidy(double value, double span) {
  constexpr double kMost = std::numeric_limits<double>::max();
  value = std::clamp(value, -kMost, kMost);
  if (value == 0 || !(std::abs(span) > 0) || !std::isfinite(span)) return value;
  const double digits =
      4 + std::floor(std::log10(std::abs(value))) - std::floor(std::log10(std::abs(span)));
  const int precision = static_cast<int>(std::clamp(digits, 1.0, 17.0));
  const double rounded = std::strtod(fmt::format("{:.{}g}", value, precision).c_str(), nullptr);
  return std::isfinite(rounded) ? rounded : value;
}

double tidyOpacity(double opacity) {
  return std::min(1.0, std::strtod(fmt::format("{:.3g}", opacity).c_str(), nullptr));
}

// A look before its numbers are rounded to few digits.
struct Draft {
  std::string name;
  std::string_view map;
  ValueRange map_range;
  std::vector<OpacityPoint> opacities;
  bool lit = true;
};

AutomaticLook lookOf(Draft draft, const AutomaticOptions& options) {
  const double span = std::abs(draft.map_range.hi - draft.map_range.lo);
  AutomaticLook look;
  look.map = options.map.empty() ? draft.map : options.map;
  look.map_range = {tidy(draft.map_range.lo, span), tidy(draft.map_range.hi, span)};
  for (OpacityPoint& point : draft.opacities)
    point = {tidy(point.value, span), tidyOpacity(point.opacity)};
  look.transfer = pointsTransfer(look.map, look.map_range, std::move(draft.opacities));
  look.transfer.name = std::move(draft.name);
  look.lit = draft.lit;
  return look;
}

// The opacity of a voxel of an object that fills `share` of the volume, so that a ray through the
// object reaches the optical depth. A compact object is as thick as the cube root of its share.
double opacityOf(double share, double thickness_vox) {
  const double chord_vox = std::max(1.0, std::sqrt(share) * std::max(1.0, thickness_vox));
  return std::min(kLargestOpacity, 1 - std::exp(-kOpticalDepth / chord_vox));
}

// The ramp from `threshold` up to `top`: at each value as much as suits the object that the values
// from there on form, so that the few high ones shine through the many low ones.
std::vector<OpacityPoint> ramp(const Histogram& histogram, const HistogramFindings& found,
                               double thickness_vox) {
  std::vector<OpacityPoint> points;
  for (const double place : kPlaces) {
    const double value = std::lerp(found.threshold, found.top, place);
    // Opacities never fall with the value, and begin at nothing: a surface without a jagged edge.
    const double weight = 0.25 + 0.75 * place;
    const double opacity =
        place == 0 ? 0 : weight * opacityOf(shareAbove(histogram, value), thickness_vox);
    points.push_back({value, points.empty() ? 0 : std::max(points.back().opacity, opacity)});
  }
  return points;
}

void mirror(std::vector<OpacityPoint>& points) {
  std::reverse(points.begin(), points.end());
  for (OpacityPoint& point : points) point.value = -point.value;
}

Draft aboveDraft(const Histogram& histogram, const HistogramFindings& found,
                 const AutomaticOptions& options) {
  return {fmt::format("automatic above {:.4g}", found.threshold),
          kNeutralColorMap,
          {found.threshold, found.top},
          ramp(histogram, found, options.thickness_vox)};
}

Draft belowDraft(const Histogram& histogram, const HistogramFindings& found,
                 const AutomaticOptions& options) {
  const HistogramFindings flipped{HistogramKind::kAbove, -found.background, -found.threshold,
                                  -found.top, found.valley};
  Draft draft = aboveDraft(mirrored(histogram), flipped, options);
  mirror(draft.opacities);
  draft.map_range = {found.threshold, found.top};
  draft.name = fmt::format("automatic below {:.4g}", found.threshold);
  return draft;
}

Draft divergingDraft(const Histogram& histogram, const HistogramFindings& found,
                     const AutomaticOptions& options) {
  const auto above = ramp(folded(histogram), found, options.thickness_vox);
  auto opacities = above;
  mirror(opacities);
  opacities.insert(opacities.end(), above.begin(), above.end());
  return {fmt::format("automatic beyond +-{:.4g}", found.threshold),
          "cool-warm",
          {-found.top, found.top},
          std::move(opacities)};
}

// The values that stand out are thin and few. They become opaque soon, so that the near ones hide
// the far ones.
Draft tailDraft(const HistogramFindings& found) {
  const auto at = [&](double place) { return std::lerp(found.threshold, found.top, place); };
  return {fmt::format("automatic, tail above {:.4g}", found.threshold),
          "hot",
          {at(-0.3), found.top},
          {{found.threshold, 0}, {at(0.15), 0.25}, {at(0.5), 0.7}, {found.top, 0.9}}};
}

// A block with its faces, as a microscopist shows it. It is not lit, because its texture is no
// surface.
Draft solidDraft(const Histogram& histogram, const HistogramFindings& found, std::string_view map) {
  const double visible = shareAbove(histogram, found.threshold);
  const auto valueAbove = [&](double share) { return percentile(histogram, 1 - visible * share); };
  Draft draft{fmt::format("automatic, solid above {:.4g}", found.threshold),
              map,
              {valueAbove(0.995), valueAbove(0.005)},
              {},
              false};
  draft.opacities = {{found.threshold, 0.9}};
  // If the block ends at fill values, the dark values interpolated towards them must not hide it.
  if (found.valley)
    draft.opacities = {{found.threshold, 0}, {draft.map_range.lo, 0.1}, {valueAbove(0.5), 0.9}};
  return draft;
}

Draft constantDraft(double value, const AutomaticOptions& options) {
  constexpr double kMost = std::numeric_limits<double>::max() / 4;
  const double unit = std::clamp(std::abs(value), 1e-300, kMost) * 1e-3;
  const double middle = std::clamp(value, -kMost, kMost);
  // Some of the usual depth: the whole block is in the way, and nothing is behind its front.
  return {fmt::format("automatic, all {:.4g}", value),
          kNeutralColorMap,
          {middle - 0.7 * unit, middle + 0.3 * unit},
          {{value, 1 - std::exp(-0.15 * kOpticalDepth / std::max(1.0, options.thickness_vox))}},
          false};
}

// Three voxels thick and opaque within one, so that a step of one voxel meets it and nothing
// behind it shows; narrow bands reach three to each side.
Draft shellDraft(ValueRange range, const AutomaticOptions& options) {
  const double reach = std::min(-range.lo, range.hi);
  const double wanted = options.finest_spacing > 0 ? 1.5 * options.finest_spacing : reach / 2;
  const double half = std::min(wanted, 0.9 * reach);
  return {fmt::format("automatic, shell of +-{:.4g}", half),
          kNeutralColorMap,
          {-2 * half, half},
          {{-half, 0}, {-half / 3, 1}, {half / 3, 1}, {half, 0}}};
}

// The surface half way, opaque.
Draft binaryDraft(double lo, double hi) {
  return {fmt::format("automatic, surface between {:.4g} and {:.4g}", lo, hi),
          kNeutralColorMap,
          {std::lerp(lo, hi, -1), hi},
          {{std::lerp(lo, hi, 0.4), 0}, {std::lerp(lo, hi, 0.6), 1}}};
}

bool areSingleValues(const ValueCounts& counts) {
  return counts.entries.size() <= kMostValueCounts &&
         std::all_of(counts.entries.begin(), counts.entries.end(),
                     [](const ValueCount& entry) { return entry.lo == entry.hi; });
}

const ValueCount& mostFrequent(const ValueCounts& counts) {
  return *std::max_element(
      counts.entries.begin(), counts.entries.end(),
      [](const ValueCount& a, const ValueCount& b) { return a.count < b.count; });
}

uint64_t secondMostFrequent(const ValueCounts& counts) {
  std::vector<uint64_t> each;
  for (const ValueCount& entry : counts.entries) each.push_back(entry.count);
  std::nth_element(each.begin(), each.begin() + 1, each.end(), std::greater<>());
  return each[1];
}

// Fill values: farther from all other values than these are from one another, written by programs
// where nothing is known.
struct WithoutFill {
  ValueCounts counts;
  bool below = false, above = false;
};

WithoutFill withoutFill(const ValueCounts& counts) {
  WithoutFill result{counts};
  const auto isFar = [&](double gap) {
    // Values of few voxels must not stretch the range.
    const Histogram rest = histogramOf(result.counts, kFineBins);
    return gap > percentile(rest, 0.9995) - percentile(rest, 0.0005);
  };
  std::vector<ValueCount>& entries = result.counts.entries;
  if (entries.size() > 2) {
    const ValueCount first = entries.front();
    entries.erase(entries.begin());
    result.below = isFar(entries.front().lo - first.hi);
    if (!result.below) entries.insert(entries.begin(), first);
  }
  if (entries.size() > 2) {
    const ValueCount last = entries.back();
    entries.pop_back();
    result.above = isFar(last.lo - rangeOf(result.counts).hi);
    if (!result.above) entries.push_back(last);
  }
  return result;
}

// Fill values show nothing, nor do values interpolated on the way to them.
void endAt(std::vector<OpacityPoint>& opacities, ValueRange range, const WithoutFill& rest) {
  const double beside = 1e-3 * (range.hi - range.lo);
  if (rest.below && opacities.front().opacity > 0) {
    const OpacityPoint first = opacities.front();
    const double end = std::min(first.value, range.lo);
    opacities.insert(opacities.begin(), {{end - beside, 0}, {end, first.opacity}});
  }
  if (rest.above && opacities.back().opacity > 0) {
    const OpacityPoint last = opacities.back();
    const double end = std::max(last.value, range.hi);
    opacities.insert(opacities.end(), {{end, last.opacity}, {end + beside, 0}});
  }
}

// --- CT

// Shows bone if there is some. It stands above the table that the patient lies on, which skin does
// not.
Draft hounsfieldDraft(const ValueCounts& values, const AutomaticOptions& options) {
  constexpr double kSkin = -300;
  const Histogram histogram = histogramOf(values, kFineBins);
  const bool bone = hasBone(values);
  const double threshold = bone ? kBone : kSkin;
  const double visible = shareAbove(histogram, threshold);
  const HistogramFindings found{
      HistogramKind::kAbove, -1000, threshold,
      std::max(threshold + 100, percentile(histogram, 1 - 0.003 * visible)), true};
  return {fmt::format("automatic above {:.4g}, {} of a CT", threshold, bone ? "bone" : "skin"),
          bone ? kDefaultColorMap : std::string_view("ct-soft-tissue"),
          {found.threshold, found.top},
          ramp(histogram, found, options.thickness_vox)};
}

Draft draftOf(const Histogram& histogram, const AutomaticOptions& options) {
  const HistogramFindings found = analyse(histogram);
  switch (found.kind) {
    case HistogramKind::kConstant:
      return constantDraft(found.background, options);
    case HistogramKind::kAbove:
      return aboveDraft(histogram, found, options);
    case HistogramKind::kBelow:
      return belowDraft(histogram, found, options);
    case HistogramKind::kSolid:
      return solidDraft(histogram, found, "grey");
    case HistogramKind::kField:
      return solidDraft(histogram, found, "viridis");
    case HistogramKind::kTail:
      return tailDraft(found);
    case HistogramKind::kDiverging:
      break;
  }
  return divergingDraft(histogram, found, options);
}

}  // namespace

double backgroundLabel(const ValueCounts& counts) {
  SLUICE_CHECK(!counts.entries.empty());
  for (const ValueCount& entry : counts.entries)
    if (entry.lo <= 0 && entry.hi >= 0) return 0;
  return mostFrequent(counts).lo;
}

bool areLabels(const ValueCounts& counts) {
  // Voxels that a thing has on its way along x, and how far the value jumps at its end, as a share
  // of the range: fields that are smooth in 8 bits change seldom too, but by little.
  constexpr double kLeastRun = 1.8, kLeastJump = 0.03;
  // Two media and the values interpolated between them are no labels: if there are many values, all
  // but the two most frequent are in runs of their own.
  constexpr double kLeastRunOfMany = 1.3;
  constexpr size_t kMany = 16;
  if (counts.entries.size() < 3 || !areSingleValues(counts)) return false;
  for (const ValueCount& entry : counts.entries)
    if (std::floor(entry.lo) != entry.lo) return false;
  const double changes = static_cast<double>(counts.changes);
  const auto things = static_cast<double>(total(counts) - mostFrequent(counts).count);
  const ValueRange range = rangeOf(counts);
  if (counts.entries.size() > kMany &&
      things - static_cast<double>(secondMostFrequent(counts)) < kLeastRunOfMany * changes)
    return false;
  return things > kLeastRun * changes &&
         static_cast<double>(counts.jumps) > kLeastJump * (range.hi - range.lo) * changes;
}

std::vector<LabelStyle> labelStylesOf(const ValueCounts& counts, std::string_view map) {
  std::vector<double> values;
  if (areSingleValues(counts)) {
    for (const ValueCount& entry : counts.entries)
      if (values.empty() || entry.lo > values.back()) values.push_back(entry.lo);
  } else {
    const ValueRange range = rangeOf(counts);
    const double first = std::ceil(range.lo), span = std::floor(range.hi) - first;
    if (!(span < static_cast<double>(kMostLabels)))
      failRequest("labels from {} to {}: expected at most {} of them", range.lo, range.hi,
                  kMostLabels);
    for (int i = 0; i <= static_cast<int>(span); ++i) values.push_back(first + i);
  }
  if (values.empty()) values = {0};
  return labelStyles(values, counts.entries.empty() ? 0 : backgroundLabel(counts), map);
}

AutomaticLook automaticLook(const ValueCounts& counts, const AutomaticOptions& options) {
  const ValueRange range = rangeOf(counts);
  if (options.signed_distance && range.lo < 0 && range.hi > 0)
    return lookOf(shellDraft(range, options), options);
  if (counts.entries.size() <= 1)
    return lookOf(constantDraft(std::midpoint(range.lo, range.hi), options), options);
  if (counts.entries.size() == 2 && areSingleValues(counts) && std::isfinite(range.hi - range.lo))
    return lookOf(binaryDraft(range.lo, range.hi), options);
  if (areLabels(counts)) {
    AutomaticLook look;
    look.transfer = labelsTransfer(labelStylesOf(counts, options.map));
    look.map = options.map;
    look.map_range = range;
    return look;
  }
  const WithoutFill rest = withoutFill(counts);
  const ValueCounts hounsfield = withoutPadding(rest.counts);
  Draft draft = looksLikeHounsfield(hounsfield)
                    ? hounsfieldDraft(hounsfield, options)
                    : draftOf(histogramOf(rest.counts, kFineBins), options);
  endAt(draft.opacities, rangeOf(rest.counts), rest);
  return lookOf(std::move(draft), options);
}

}  // namespace sluice
