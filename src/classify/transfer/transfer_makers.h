// Makers of transfer functions from --threshold, --map, --opacity, --opacities and --labels.
// automatic_look.h makes the one used without any option.
//
// Opacities apply to one voxel length of the finest spacing. Pure functions of their arguments.
#pragma once

#include <string_view>
#include <vector>

#include "src/classify/transfer/color_maps.h"
#include "src/classify/transfer/transfer_function.h"

namespace sluice {

// The default of --opacity: the opacity at the top of a ramp.
inline constexpr double kDefaultOpacity = 0.05;

// Opacity 0 below the threshold, 0.2 `opacity` at it, linear to `opacity` at the top of the value
// range; `map` is stretched from the threshold to the top. A threshold above the range leaves
// nothing visible, one below it everything. Throws Error when the threshold is not finite, the
// opacity not in 0..1 or the map unknown.
TransferFunction thresholdTransfer(double threshold, ValueRange range,
                                   double opacity = kDefaultOpacity,
                                   std::string_view map = kDefaultColorMap);

// The map over `map_range` (reversed if lo > hi) and these opacities. Throws Error when the map is
// unknown or the points are not valid.
TransferFunction pointsTransfer(std::string_view map, ValueRange map_range,
                                std::vector<OpacityPoint> opacities);

// Everything shows, in the colours of the map over the range: for modes that look at values alone.
TransferFunction wholeRangeTransfer(std::string_view map, ValueRange range);

// Li 2003, figure 1: multiplies each opacity by a ramp of the gradient magnitude, 0 where the
// volume is flat and 1 from `full_magnitude` on (value units a voxel length). Throws Error when
// `transfer` looks at gradients already or the magnitude is not above 0.
TransferFunction modulateByGradient(TransferFunction transfer, double full_magnitude);

// Every opacity times `factor` (>= 0), at most 1.
TransferFunction scaleOpacity(TransferFunction transfer, double factor);

}  // namespace sluice
