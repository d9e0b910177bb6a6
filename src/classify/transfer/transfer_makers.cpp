#include "src/classify/transfer/transfer_makers.h"

#include <algorithm>
#include <utility>

#include "src/base/error.h"
#include "src/base/values/tidy_number.h"

namespace sluice {

TransferFunction thresholdTransfer(double threshold, ValueRange range, double opacity,
                                   std::string_view map) {
  // A threshold above the range must not turn the map round.
  const double top = std::max(range.hi, threshold);
  TransferFunction transfer;
  transfer.name = fmt::format("threshold {}", threshold);
  transfer.colors = rescale(requireColorMap(map, "--map"), threshold, top);
  // A fifth at once, so that the surface at the threshold is seen.
  transfer.opacities = {{threshold, 0}, {threshold, 0.2 * opacity}};
  // Above the range there is no ramp to climb.
  if (threshold <= range.hi) transfer.opacities.push_back({range.hi, opacity});
  validate(transfer, transfer.name);
  return transfer;
}

TransferFunction pointsTransfer(std::string_view map, ValueRange map_range,
                                std::vector<OpacityPoint> opacities) {
  TransferFunction transfer;
  transfer.name = map;
  std::vector<ColorPoint> colors = requireColorMap(map, "--map");
  // rescale() needs ascending values: the map is turned round instead.
  if (map_range.lo > map_range.hi) {
    std::reverse(colors.begin(), colors.end());
    for (ColorPoint& point : colors) point.value = 1 - point.value;
    std::swap(map_range.lo, map_range.hi);
  }
  transfer.colors = rescale(std::move(colors), map_range.lo, map_range.hi);
  transfer.opacities = std::move(opacities);
  validate(transfer, "--opacities");
  return transfer;
}

TransferFunction wholeRangeTransfer(std::string_view map, ValueRange range) {
  TransferFunction transfer = pointsTransfer(map, range, {{0, 1}});
  transfer.name = fmt::format("all values, {:.6g} to {:.6g}", range.lo, range.hi);
  return transfer;
}

TransferFunction modulateByGradient(TransferFunction transfer, double full_magnitude) {
  if (!transfer.gradients.empty())
    fail("{}: expected a transfer function without gradients to modulate, found one with them",
         transfer.name);
  if (!(full_magnitude > 0))
    failRequest("{}: expected a gradient magnitude above 0 to modulate by, found {}", transfer.name,
                full_magnitude);
  transfer.gradients = {{0, {{0, 0}}}, {full_magnitude, {{0, 1}}}};
  transfer.name += ", modulated";
  validate(transfer, transfer.name);
  return transfer;
}

TransferFunction scaleOpacity(TransferFunction transfer, double factor) {
  for (OpacityPoint& point : transfer.opacities) {
    point.opacity = std::clamp(tidyNumber(point.opacity * factor), 0.0, 1.0);
  }
  return transfer;
}

}  // namespace sluice
