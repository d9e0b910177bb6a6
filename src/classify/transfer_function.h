// TransferFunction: what a value looks like. Control points of colour and of opacity over volume
// values (after VolumeLayout's scale and offset), piecewise linear, constant beyond the first and
// the last point.
//
// Two points at one value make a step: below it the first holds, at it and above it the second.
// Plain data; makers of it are in transfer_makers.h and the files it is read from in
// transfer_file.h.
#pragma once

#include <string>
#include <vector>

#include "src/base/vec.h"
#include "src/base/volume_source.h"

namespace sluice {

struct ColorPoint {
  double value = 0;
  Vec3d rgb{1, 1, 1};  // 0..1, as shown on a screen, not premultiplied
};

struct OpacityPoint {
  double value = 0;
  double opacity = 0;  // 0..1, of one voxel length of the finest spacing
};

struct TransferFunction {
  std::vector<ColorPoint> colors;       // ascending by value, not empty
  std::vector<OpacityPoint> opacities;  // ascending by value, not empty
  std::string name;                     // for reports: "threshold 40", "viridis", a file's name
};

// The colour and the opacity at `value`. NaN has opacity 0.
Vec3d colorAt(const TransferFunction& transfer, double value);
double opacityAt(const TransferFunction& transfer, double value);

// Throws Error, starting with `where`, when a list is empty or descends, or a number is not finite
// or out of 0..1.
void validate(const TransferFunction& transfer, const std::string& where);

}  // namespace sluice
