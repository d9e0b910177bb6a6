// Makers of transfer functions: what --threshold, --map, --opacity and no option at all mean.
//
// Opacities are those of one voxel length of the finest spacing. Pure functions of their arguments.
#pragma once

#include <string_view>

#include "src/base/histogram.h"
#include "src/classify/color_maps.h"
#include "src/classify/transfer_function.h"

namespace sluice {

// --opacity where none is given: the opacity at the top of a ramp.
inline constexpr double kDefaultOpacity = 0.05;

// Opacity 0 below the threshold, 0.2 `opacity` at it, linear to `opacity` at the top of the value
// range; `map` is stretched from the threshold to the top. A threshold above the range leaves
// nothing visible, one below it everything. Throws Error when the threshold is not finite, the
// opacity not in 0..1 or the map unknown.
TransferFunction thresholdTransfer(double threshold, ValueRange range,
                                   double opacity = kDefaultOpacity,
                                   std::string_view map = kDefaultColorMap);

// The map over the whole range, the opacity linear from 0 at its low end to `opacity` at its high
// one. Throws Error when the map is unknown or the opacity not in 0..1.
TransferFunction mapTransfer(std::string_view map, ValueRange range,
                             double opacity = kDefaultOpacity);

struct AutomaticOptions {
  // How many voxel lengths of the finest spacing a ray spends in the volume: about the mean of the
  // three sides. Opacities follow from it, so that one sees into a thick volume as into a thin one.
  double thickness_vox = 256;
  // The volume is a distance to a surface (an OpenVDB level set): show a shell around zero.
  bool signed_distance = false;
  // World units, where known: the shell of a signed distance is some of these thick.
  double finest_spacing = 0;
  // Replaces the map that would be chosen; empty: chosen.
  std::string_view map = {};
};

// A picture worth looking at from the counts alone:
// - background and its noise at the low end: what lies above is visible, coloured from its lowest
//   value to the one that 3 in 1000 of it exceed;
// - most values near zero and tails on both sides (a statistic, a vorticity): both tails are
//   visible, cool below and warm above, zero grey whatever the range;
// - background at the high end (a bright field): what lies below is visible;
// - a signed distance: a shell around zero;
// - one value: translucent everywhere.
// Its name says what was chosen: "automatic above 40". Throws Error when the map is unknown.
TransferFunction automaticTransfer(const Histogram& histogram,
                                   const AutomaticOptions& options = {});

// Li 2003, figure 1: each opacity times a ramp of the gradient magnitude, 0 where the volume is
// flat and 1 from `full_magnitude` on (value units a voxel length). Throws Error when `transfer`
// looks at gradients already or the magnitude is not above 0.
TransferFunction modulateByGradient(TransferFunction transfer, double full_magnitude);

// Every opacity times `factor` (>= 0), at most 1.
TransferFunction scaleOpacity(TransferFunction transfer, double factor);

}  // namespace sluice
