#include "src/classify/transfer/histogram_analysis.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numeric>
#include <optional>
#include <span>

namespace sluice {
namespace {

// Enough to tell the values of 8-bit data apart, few enough that noise does not look like valleys.
constexpr size_t kBins = 256;
// The share of all values, and of those that differ from the most frequent one, that is ignored at
// either end, so that outliers do not stretch the analysis.
constexpr double kFew = 0.0005, kFewOfOthers = 0.005;
// The share of the visible values that lie below the top.
constexpr double kTopShare = 0.997;

using Density = std::vector<double>;

double sum(std::span<const double> part) {
  return std::accumulate(part.begin(), part.end(), 0.0);
}

// Shares of the counted values in equal bins over `range`, each input bin spread evenly over the
// bins that it touches; values outside go to the first and the last bin.
Density resample(const Histogram& histogram, ValueRange range, size_t bins) {
  Density density(bins, 0.0);
  const auto all = static_cast<double>(total(histogram));
  const auto position = [&](double value) {
    const double share = (value - range.lo) / (range.hi - range.lo);
    return std::clamp(share, 0.0, 1.0) * static_cast<double>(bins);
  };
  for (size_t i = 0; i < histogram.counts.size(); ++i) {
    if (histogram.counts[i] == 0) continue;
    const double share = static_cast<double>(histogram.counts[i]) / all;
    const double a = position(binEdge(histogram, i)), b = position(binEdge(histogram, i + 1));
    const auto first = std::min(bins - 1, static_cast<size_t>(a));
    const auto last = std::min(bins - 1, static_cast<size_t>(std::max(a, std::ceil(b) - 1)));
    for (size_t bin = first; bin <= last; ++bin) {
      const double lo = std::max(a, static_cast<double>(bin));
      const double hi = std::min(b, static_cast<double>(bin + 1));
      // A bin without width goes whole into the one that it lies in.
      density[bin] += b > a ? share * std::max(0.0, hi - lo) / (b - a) : share;
    }
  }
  return density;
}

// Three box filters of 2 radius + 1 bins, close to a Gaussian; at the ends the filter is narrower.
Density smooth(std::span<const double> density, size_t radius) {
  Density result(density.begin(), density.end());
  for (int pass = 0; pass < 3; ++pass) {
    const Density from = result;
    for (size_t i = 0; i < from.size(); ++i) {
      // Narrower on both sides alike, so that the filter moves nothing.
      const size_t reach = std::min({radius, i, from.size() - 1 - i});
      const std::span<const double> window(from.data() + i - reach, 2 * reach + 1);
      result[i] = sum(window) / static_cast<double>(window.size());
    }
  }
  return result;
}

// The end of a peak's noise if the peak falls off as a normal distribution does; `mode` otherwise.
// A slower decay is no noise: fog.
size_t noiseEnd(const Density& density, size_t mode) {
  // A normal distribution has half its height at 1.1774 deviations, the root of 2 ln 2.
  constexpr double kDeviationsAtHalf = 1.1774, kNoise = 4;
  // A single exact value is no hump.
  if (mode + 2 >= density.size() ||
      std::max(density[mode + 1], density[mode + 2]) < 0.25 * density[mode])
    return mode;
  const Density curve = smooth(density, 1);  // integers leave bins fuller than others
  size_t half = mode;
  while (half < curve.size() && curve[half] > curve[mode] / 2) ++half;
  // At twice the half width a normal distribution has fallen to a sixteenth.
  const size_t twice = mode + 2 * (half - mode);
  if (half < mode + 2 || twice >= curve.size() || curve[twice] > 0.12 * curve[mode]) return mode;
  const double deviation = static_cast<double>(half - mode) / kDeviationsAtHalf;
  return std::min(density.size(), mode + static_cast<size_t>(std::ceil(kNoise * deviation)));
}

// The end of the background: the first bin after `mode` that belongs to something else. The peak
// ends where it has fallen to a tenth; a narrow hump right next to it is its noise and ends in the
// same way.
size_t backgroundEnd(const Density& density, size_t mode) {
  // Integers leave single bins empty, more or fewer with the range: one low bin ends nothing.
  const auto fallsToATenth = [&](size_t from) {
    const double tenth = 0.1 * density[from];
    const auto isLow = [&](size_t i) { return i >= density.size() || density[i] < tenth; };
    size_t i = from;
    while (i < density.size() && !(isLow(i) && isLow(i + 1))) ++i;
    return i;
  };
  size_t end = fallsToATenth(mode);
  for (int hump = 0; hump < 2 && end < density.size(); ++hump) {
    // The noise next to the peak is narrow: 8 % of the range at most.
    const size_t next = fallsToATenth(end);
    if (next - mode > density.size() * 8 / 100) break;
    end = next;
  }
  return std::max(end, noiseEnd(density, mode));
}

struct Valley {
  size_t middle, peak;  // bins
};

// The valley before the peak that stands out most; nothing if fewer values lie beyond it than
// before it, as in fog, whose tail also has ups and downs.
std::optional<Valley> valleyAfter(const Density& density, size_t end) {
  if (end + 2 >= density.size()) return std::nullopt;
  const std::span<const double> rest(density.data() + end, density.size() - end);
  const Density curve = smooth(rest, density.size() / 100);
  double floor = curve[0], prominence = 0, floor_of_peak = 0;
  size_t peak = 0;
  for (size_t i = 0; i < curve.size(); ++i) {
    floor = std::min(floor, curve[i]);
    if (curve[i] - floor > prominence) {
      prominence = curve[i] - floor;
      floor_of_peak = floor;
      peak = i;
    }
  }
  // A peak that rises above its floor by less than half of it is a ripple.
  if (prominence < 0.5 * floor_of_peak || prominence <= 0) return std::nullopt;
  std::vector<size_t> low;
  for (size_t i = 0; i < peak; ++i) {
    if (curve[i] <= floor_of_peak + 0.1 * prominence) low.push_back(i);
  }
  if (low.empty()) return std::nullopt;
  // Below the middle of the low bins, so that less of the object's foot is cut off.
  const size_t middle = low[low.size() * 2 / 5];
  if (sum(rest.subspan(middle)) < 0.75 * sum(rest.first(middle))) return std::nullopt;
  return Valley{end + middle, end + peak};
}

size_t largest(std::span<const double> density) {
  return static_cast<size_t>(std::max_element(density.begin(), density.end()) - density.begin());
}

// The share within a 30th of all bins to either side.
double massAround(const Density& density, size_t bin) {
  const size_t reach = density.size() / 30;
  const size_t first = bin - std::min(bin, reach);
  return sum(std::span(density).subspan(first, std::min(density.size() - first, 2 * reach + 1)));
}

// A CT's air after the padding around its field of view: close to it, or a great peak farther on if
// the padding is one exact value.
bool isAirAfterPadding(const Density& density, size_t mode, size_t peak) {
  if (peak - mode < density.size() / 10) return true;
  const bool exact = density[mode + 1] < 0.01 * density[mode];
  return exact && peak - mode < density.size() * 35 / 100 && massAround(density, peak) > 0.25;
}

// The bin at which the visible values begin.
struct Threshold {
  size_t bin;
  bool valley;
};

Threshold thresholdAfter(const Density& density, size_t mode) {
  const size_t end = backgroundEnd(density, mode);
  const auto valley = valleyAfter(density, end);
  if (!valley) return {end, false};
  if (isAirAfterPadding(density, mode, valley->peak)) {
    // Only if something else follows.
    const auto next = valleyAfter(density, backgroundEnd(density, valley->peak));
    if (next) return {next->middle, true};
  }
  return {valley->middle, true};
}

// A background at the high end holds many voxels. The upper of a mask's two values is none: the
// lower one is as exact.
bool isBrightField(const Density& density) {
  const size_t mode = largest(density);
  return mode > density.size() * 9 / 10 && massAround(density, mode) > 0.4 && density[0] < 0.05;
}

// kDiverging: most values near zero, fewer and fewer away from it on both sides.
bool diverges(const Density& density, ValueRange range) {
  if (!(range.lo < 0 && range.hi > 0)) return false;
  const double extent = range.hi - range.lo;
  // One side that is much shorter is no tail.
  if (std::min(-range.lo, range.hi) < 0.15 * extent) return false;
  const auto bins = static_cast<double>(density.size());
  const double zero = -range.lo / extent * bins;
  // The peak must lie at zero.
  if (std::abs(static_cast<double>(largest(density)) + 0.5 - zero) > 0.03 * bins) return false;
  // Air in a CT in Hounsfield units is a second peak far below zero: not a tail.
  const auto near_lo = static_cast<size_t>(zero / 2);
  const auto near_hi = static_cast<size_t>((zero + bins) / 2);
  const std::span<const double> all(density);
  const double middle = sum(all.subspan(near_lo, near_hi - near_lo));
  return sum(all.first(near_lo)) < 0.2 * middle && sum(all.subspan(near_hi)) < 0.2 * middle;
}

double topOf(const Histogram& histogram, double threshold) {
  const double visible = shareAbove(histogram, threshold);
  return std::max(threshold, percentile(histogram, 1 - visible * (1 - kTopShare)));
}

HistogramFindings divergingFindings(const Histogram& histogram) {
  const Histogram distance = folded(histogram);
  const Density density = resample(distance, {0, percentile(distance, 1 - kFew)}, kBins);
  // The far eighth of the values that are not background: the others are noise around zero.
  const size_t end = backgroundEnd(density, largest(density));
  const double beside = sum(std::span(density).subspan(std::min(end, density.size())));
  const double threshold = percentile(distance, 1 - beside / 8);
  return {HistogramKind::kDiverging, 0, threshold, topOf(distance, threshold), false};
}

HistogramFindings scaled(HistogramFindings findings, double factor) {
  findings.background *= factor;
  findings.threshold *= factor;
  findings.top *= factor;
  return findings;
}

Histogram scaled(Histogram histogram, double factor) {
  histogram.range = {histogram.range.lo * factor, histogram.range.hi * factor};
  return histogram;
}

// The hump around a peak, as wide as a normal distribution that falls off alike.
struct Hump {
  size_t peak;
  double deviation;  // bins, of the flatter side
  double share;      // share of all values within two deviations
};

Hump humpAt(const Density& curve, const Density& density, size_t peak) {
  // The width where the hump has fallen to half; a side that ends before does not count.
  constexpr double kDeviationsAtHalf = 1.1774;
  const double half = curve[peak] / 2;
  size_t left = peak, right = peak;
  while (left > 0 && curve[left] > half) --left;
  while (right + 1 < curve.size() && curve[right] > half) ++right;
  const double width =
      static_cast<double>(curve[left] > half    ? right - peak
                          : curve[right] > half ? peak - left
                                                : std::max(right - peak, peak - left));
  Hump hump{peak, std::max(1.0, width) / kDeviationsAtHalf, 0};
  const auto reach = static_cast<size_t>(2 * hump.deviation);
  const size_t first = peak - std::min(peak, reach);
  const size_t last = std::min(density.size(), peak + reach + 1);
  hump.share = sum(std::span(density).subspan(first, last - first));
  return hump;
}

constexpr size_t kSmoothing = kBins / 50;

// Whether nearly all values from `first` on form one broad hump, without other humps of note.
bool isSolid(const Density& density, size_t first) {
  constexpr double kLeastShare = 0.65, kLeastWidth = 0.18, kPeak = 0.15;
  const std::span<const double> part = std::span(density).subspan(first);
  const double share = sum(part);
  // Too few values, or too narrow a range, for one broad hump.
  if (share < kLeastShare || part.size() < density.size() / 2) return false;
  // Nothing but the hump's own foot at the low end.
  if (sum(part.first(part.size() / 10)) > 0.05 * share) return false;
  const Density curve = smooth(part, kSmoothing);
  const size_t peak = largest(curve);
  const auto at = static_cast<double>(peak) / static_cast<double>(curve.size());
  if (at < 0.2 || at > 0.85) return false;
  // Away from the peak it only falls, except for small ripples.
  const auto falls = [&](auto from, auto to) {
    double floor = *from;
    for (auto it = from; it != to; ++it) {
      if (*it > floor + kPeak * curve[peak]) return false;
      floor = std::min(floor, *it);
    }
    return true;
  };
  const auto middle = curve.begin() + static_cast<ptrdiff_t>(peak);
  if (!falls(middle, curve.end()) || !falls(std::reverse_iterator(middle), curve.rend()))
    return false;
  double below = 0;
  size_t low = 0, high = 0;
  // Between the 16th and the 84th percentile lie two deviations of a normal distribution.
  for (size_t i = 0; i < part.size(); ++i) {
    below += part[i] / share;
    if (below < 0.16) low = i;
    if (below < 0.84) high = i;
  }
  return static_cast<double>(high - low) > kLeastWidth * static_cast<double>(density.size());
}

// The first of the values that stand out far above the hump that a good part of all voxels is in.
// Needs more bins than the other analyses, because the hump may be narrow.
std::optional<double> tailAbove(const Histogram& histogram, double lo, double hi) {
  constexpr size_t kFineBins = 1024;
  constexpr double kLeastHump = 0.15, kLeastTail = 0.0005, kMostTail = 0.04, kFar = 2.5;
  constexpr double kHumpEnd = 3, kTailStart = 4.5;  // deviations of the hump
  const Density density = resample(histogram, {lo, hi}, kFineBins);
  const Density curve = smooth(density, kFineBins / 200);
  // The last peak of note is the hump; air lies before it. A ripple on a flank is none. A spike of
  // zeros at the end does not count either. Fog, and tissue whose dark parts reach down to the air,
  // stand on its flank: their bright values are no object of their own.
  constexpr size_t kFlank = kFineBins / 32;
  size_t peak = largest(curve);
  const double noted = 0.1 * curve[kFlank + largest(std::span(curve).subspan(kFlank))];
  for (size_t i = peak + kFlank; i + kFlank < curve.size(); ++i) {
    const std::span<const double> around(curve.data() + i - kFlank, 2 * kFlank + 1);
    if (curve[i] <= noted || largest(around) != kFlank) continue;
    const Hump hump = humpAt(curve, density, i);
    const double apart = static_cast<double>(i - peak);
    if (hump.share > kLeastHump && apart > kHumpEnd * hump.deviation) peak = i;
  }
  const Hump hump = humpAt(curve, density, peak);
  if (hump.deviation < 2 || hump.share < kLeastHump) return std::nullopt;
  const auto binAt = [&](double deviations) {
    return static_cast<size_t>(static_cast<double>(peak) + deviations * hump.deviation);
  };
  const size_t end = binAt(kTailStart), hump_end = binAt(kHumpEnd);
  if (end + 1 >= density.size()) return std::nullopt;
  const double tail = sum(std::span(density).subspan(end));
  if (tail < kLeastTail || tail > kMostTail) return std::nullopt;
  // A slow fall-off, as from dark to bright tissue, is the hump's own foot.
  if (sum(std::span(density).subspan(hump_end, end - hump_end)) > tail) return std::nullopt;
  // The tail must reach far beyond the hump, otherwise it is the hump's own end.
  if (static_cast<double>(density.size() - peak) < kFar * static_cast<double>(peak))
    return std::nullopt;
  return std::lerp(lo, hi, static_cast<double>(end) / static_cast<double>(kFineBins));
}

// The range of all but a few values at either end. The larger the share of the most frequent value,
// the fewer values are cut off, because the object may be small.
ValueRange usualRange(const Histogram& histogram) {
  const auto all = static_cast<double>(total(histogram));
  const auto most =
      static_cast<double>(*std::max_element(histogram.counts.begin(), histogram.counts.end()));
  const double few = all > 0 ? std::min(kFew, kFewOfOthers * (1 - most / all)) : kFew;
  return {percentile(histogram, few), percentile(histogram, 1 - few)};
}

}  // namespace

HistogramFindings analyse(const Histogram& histogram) {
  // The range of doubles may overflow a double: a quarter of it does not.
  if (!std::isfinite(histogram.range.hi - histogram.range.lo)) {
    return scaled(analyse(scaled(histogram, 0.25)), 4);
  }
  const ValueRange range = usualRange(histogram);
  const auto occupied = std::count_if(histogram.counts.begin(), histogram.counts.end(),
                                      [](uint64_t count) { return count > 0; });
  if (occupied <= 1 || !(range.hi > range.lo)) {
    return {HistogramKind::kConstant, range.lo, range.lo, range.lo, false};
  }
  Density density = resample(histogram, range, kBins);
  // Values above the range must not look like a peak at its end.
  density.back() = std::max(0.0, density.back() - shareAbove(histogram, range.hi));
  if (isSolid(density, 0)) return {HistogramKind::kSolid, range.lo, range.lo, range.hi, false};
  if (diverges(density, range)) return divergingFindings(histogram);
  if (isBrightField(density)) {
    HistogramFindings findings = scaled(analyse(mirrored(histogram)), -1);
    findings.kind = HistogramKind::kBelow;
    return findings;
  }
  // A tightly cropped object may hold more voxels than the background: look for that lower down.
  const size_t low_mode = largest(std::span(density).first(kBins / 2));
  const Threshold found = thresholdAfter(density, low_mode);
  const double width = (range.hi - range.lo) / static_cast<double>(kBins);
  const auto edge = [&](size_t bin) { return range.lo + width * static_cast<double>(bin); };
  const double background = edge(low_mode) + width / 2;
  // Fill values are one exact value with nothing next to it.
  const bool is_fill = density[low_mode] > 0.02 && low_mode + 1 < kBins &&
                       density[low_mode + 1] < 0.01 * density[low_mode];
  if (is_fill && found.valley && isSolid(density, found.bin))
    return {HistogramKind::kSolid, background, edge(found.bin), range.hi, true};
  if (const auto tail = tailAbove(histogram, range.lo, range.hi))
    return {HistogramKind::kTail, background, *tail, topOf(histogram, *tail), false};
  // Values all over the range, without a peak that ends anywhere.
  if (!found.valley && found.bin > kBins * 9 / 10)
    return {HistogramKind::kField, background, range.lo, range.hi, false};
  const double threshold = edge(found.bin);
  return {HistogramKind::kAbove, background, threshold, topOf(histogram, threshold), found.valley};
}

}  // namespace sluice
