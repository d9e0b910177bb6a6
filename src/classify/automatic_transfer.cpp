// automaticTransfer: from what histogram_analysis.h finds to colours and opacities.
#include <algorithm>
#include <array>
#include <cmath>

#include "src/base/error.h"
#include "src/classify/histogram_analysis.h"
#include "src/classify/transfer_makers.h"

namespace sluice {
namespace {

// Optical depth (-ln of what passes) of a ray through all that is visible: dense enough that the
// front is read as a surface, thin enough that what lies behind adds to it.
constexpr double kOpticalDepth = 3;
// No voxel hides all that is behind it: steps between voxels would show as rings.
constexpr double kLargestOpacity = 0.5;
// Where between threshold and top the ramp has points, and how much of its height it has there.
constexpr std::array<double, 9> kPlaces = {0, 0.03, 0.1, 0.2, 0.35, 0.5, 0.65, 0.8, 1};

// The opacity of a voxel of an object that fills `share` of the volume, so that a ray through the
// object reaches the optical depth. A compact object is as thick as the cube root of its share.
double opacityOf(double share, double thickness_vox) {
  const double chord_vox = std::max(1.0, std::sqrt(share) * std::max(1.0, thickness_vox));
  return std::min(kLargestOpacity, 1 - std::exp(-kOpticalDepth / chord_vox));
}

std::vector<ColorPoint> chosenMap(const AutomaticOptions& options, std::string_view otherwise) {
  return requireColorMap(options.map.empty() ? otherwise : options.map, "--map");
}

// The ramp from `threshold` up to `top`: at each value as much as suits the object that the values
// from there on form, so that the few high ones shine through the many low ones.
std::vector<OpacityPoint> ramp(const Histogram& histogram, const HistogramFindings& found,
                               double thickness_vox) {
  std::vector<OpacityPoint> points;
  for (const double place : kPlaces) {
    const double value = std::lerp(found.threshold, found.top, place);
    // Never less than at a lower value, and at the foot nothing: a surface without a jagged edge.
    const double weight = 0.25 + 0.75 * place;
    const double opacity =
        place == 0 ? 0 : weight * opacityOf(shareAbove(histogram, value), thickness_vox);
    points.push_back({value, points.empty() ? 0 : std::max(points.back().opacity, opacity)});
  }
  return points;
}

template <class Point>
void mirror(std::vector<Point>& points) {
  std::reverse(points.begin(), points.end());
  for (Point& point : points) point.value = -point.value;
}

TransferFunction aboveTransfer(const Histogram& histogram, const HistogramFindings& found,
                               const AutomaticOptions& options) {
  TransferFunction transfer;
  transfer.name = fmt::format("automatic above {:.4g}", found.threshold);
  transfer.colors = rescale(chosenMap(options, kDefaultColorMap), found.threshold, found.top);
  transfer.opacities = ramp(histogram, found, options.thickness_vox);
  return transfer;
}

TransferFunction belowTransfer(const Histogram& histogram, const HistogramFindings& found,
                               const AutomaticOptions& options) {
  const HistogramFindings flipped{HistogramKind::kAbove, -found.background, -found.threshold,
                                  -found.top, found.valley};
  TransferFunction transfer = aboveTransfer(mirrored(histogram), flipped, options);
  mirror(transfer.colors);
  mirror(transfer.opacities);
  transfer.name = fmt::format("automatic below {:.4g}", found.threshold);
  return transfer;
}

TransferFunction divergingTransfer(const Histogram& histogram, const HistogramFindings& found,
                                   const AutomaticOptions& options) {
  TransferFunction transfer;
  transfer.name = fmt::format("automatic beyond +-{:.4g}", found.threshold);
  transfer.colors = rescale(chosenMap(options, "cool-warm"), -found.top, found.top);
  const auto above = ramp(folded(histogram), found, options.thickness_vox);
  transfer.opacities = above;
  mirror(transfer.opacities);
  transfer.opacities.insert(transfer.opacities.end(), above.begin(), above.end());
  return transfer;
}

TransferFunction constantTransfer(double value, const AutomaticOptions& options) {
  TransferFunction transfer;
  transfer.name = fmt::format("automatic, all {:.4g}", value);
  const TransferFunction map{chosenMap(options, kDefaultColorMap), {{0, 1}}, ""};
  transfer.colors = {{value, colorAt(map, 0.7)}};
  // A quarter of the usual depth: the whole block is in the way, and nothing is behind its front.
  transfer.opacities = {
      {value, 1 - std::exp(-0.25 * kOpticalDepth / std::max(1.0, options.thickness_vox))}};
  return transfer;
}

// Three voxels thick, so that a step of one voxel meets it; narrow bands reach three to each side.
TransferFunction shellTransfer(ValueRange range, const AutomaticOptions& options) {
  const double reach = std::min(-range.lo, range.hi);
  const double wanted = options.finest_spacing > 0 ? 1.5 * options.finest_spacing : reach / 2;
  const double half = std::min(wanted, 0.9 * reach);
  TransferFunction transfer;
  transfer.name = fmt::format("automatic, shell of +-{:.4g}", half);
  transfer.colors = rescale(chosenMap(options, kDefaultColorMap), -2 * half, half);
  transfer.opacities = {{-half, 0}, {-half / 3, 0.7}, {half / 3, 0.7}, {half, 0}};
  return transfer;
}

}  // namespace

TransferFunction automaticTransfer(const Histogram& histogram, const AutomaticOptions& options) {
  if (options.signed_distance && histogram.range.lo < 0 && histogram.range.hi > 0) {
    return shellTransfer(histogram.range, options);
  }
  const HistogramFindings found = analyse(histogram);
  switch (found.kind) {
    case HistogramKind::kConstant:
      return constantTransfer(found.background, options);
    case HistogramKind::kAbove:
      return aboveTransfer(histogram, found, options);
    case HistogramKind::kBelow:
      return belowTransfer(histogram, found, options);
    case HistogramKind::kDiverging:
      break;
  }
  return divergingTransfer(histogram, found, options);
}

}  // namespace sluice
