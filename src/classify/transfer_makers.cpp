#include "src/classify/transfer_makers.h"

#include <algorithm>

#include "src/base/error.h"

namespace sluice {

TransferFunction thresholdTransfer(double threshold, ValueRange range, double opacity,
                                   std::string_view map) {
  const double top = std::max(range.hi, threshold);
  TransferFunction transfer;
  transfer.name = fmt::format("threshold {}", threshold);
  transfer.colors = rescale(requireColorMap(map, "--map"), threshold, top);
  transfer.opacities = {{threshold, 0}, {threshold, 0.2 * opacity}};
  // Above the range there is no ramp to climb.
  if (threshold <= range.hi) transfer.opacities.push_back({range.hi, opacity});
  validate(transfer, transfer.name);
  return transfer;
}

TransferFunction mapTransfer(std::string_view map, ValueRange range, double opacity) {
  TransferFunction transfer;
  transfer.name = map;
  transfer.colors = rescale(requireColorMap(map, "--map"), range.lo, range.hi);
  transfer.opacities = {{range.lo, 0}, {range.hi, opacity}};
  validate(transfer, transfer.name);
  return transfer;
}

TransferFunction modulateByGradient(TransferFunction transfer, double full_magnitude) {
  if (!transfer.gradients.empty())
    fail("{}: expected a transfer function without gradients to modulate, found one with them",
         transfer.name);
  if (!(full_magnitude > 0))
    fail("{}: expected a gradient magnitude above 0 to modulate by, found {}", transfer.name,
         full_magnitude);
  transfer.gradients = {{0, {{0, 0}}}, {full_magnitude, {{0, 1}}}};
  transfer.name += ", modulated";
  validate(transfer, transfer.name);
  return transfer;
}

TransferFunction scaleOpacity(TransferFunction transfer, double factor) {
  for (OpacityPoint& point : transfer.opacities) {
    point.opacity = std::clamp(point.opacity * factor, 0.0, 1.0);
  }
  return transfer;
}

}  // namespace sluice
