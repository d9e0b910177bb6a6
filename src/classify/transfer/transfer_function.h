// TransferFunction: colours and opacities by value. Control points of colour and of opacity over
// volume values (after VolumeLayout's scale and offset), piecewise linear, constant beyond the
// first and the last point.
//
// Two points at one value make a step: below it the first holds, at it and above it the second.
//
// With gradients it is a function of the plane of values and gradient magnitudes: the opacity over
// values times a factor that rows at some magnitudes give, each a curve over values. Magnitudes of
// the gradient are in the world, in value units a voxel length of the finest spacing. Plain data;
// makers of it are in transfer_makers.h and the files it is read from in transfer_file.h.
#pragma once

#include <string>
#include <vector>

#include "src/base/looks/surface_look.h"
#include "src/base/sources/volume_source.h"
#include "src/base/values/vec.h"

namespace sluice {

struct ColorPoint {
  double value = 0;
  Vec3d rgb{1, 1, 1};  // 0..1, as shown on a screen, not premultiplied
};

struct OpacityPoint {
  double value = 0;
  double opacity = 0;  // 0..1, of one voxel length of the finest spacing
};

// The share of the opacity that remains at one gradient magnitude, by value.
struct GradientRow {
  double magnitude = 0;
  std::vector<OpacityPoint> factors;  // 0..1 over values, as `opacities` is; not empty
};
inline constexpr size_t kMostGradientRows = 16;

// A surface where the volume has one value. It shows wherever a ray meets it, whatever the angle.
struct IsoSurface {
  double value = 0;
  double opacity = 1;  // 0..1, of a meeting
  Vec3d rgb{1, 1, 1};
};

inline constexpr double kDefaultAttenuation = 0.05, kMostAttenuation = 1000;

struct TransferFunction {
  std::vector<ColorPoint> colors;       // ascending by value, not empty
  std::vector<OpacityPoint> opacities;  // ascending by value, not empty
  std::string name;                     // for reports: "threshold 40", "viridis", a file's name
  // Strictly ascending by magnitude from 0 on, at most kMostGradientRows; linear in between and
  // constant beyond. Empty: the gradient makes no difference.
  std::vector<GradientRow> gradients = {};
  // Values are labels, with nothing between them: instead of interpolating, a sample takes the one
  // of the eight voxels around it whose value has the greatest weight among them.
  bool labels = false;
  // At most kMostSurfaces different values, in any order; not of labels. They are drawn together
  // with what the opacities show.
  std::vector<IsoSurface> surfaces = {};
  // Attenuated maximum: how much a voxel length of the finest spacing at the last colour's value
  // dims what is behind it, by exp(-attenuation); in proportion from the first colour's value on.
  double attenuation = kDefaultAttenuation;
};

// The colour and the opacity at `value`, whatever the gradient: the most that any shows. NaN has
// opacity 0.
Vec3d colorAt(const TransferFunction& transfer, double value);
double opacityAt(const TransferFunction& transfer, double value);
// The share of the opacity that remains at a row's gradient magnitude.
double gradientFactorAt(const GradientRow& row, double value);

// Throws Error, starting with `where`, when a list is empty or descends, there are too many rows,
// or a number is not finite or out of 0..1.
void validate(const TransferFunction& transfer, const std::string& where);

}  // namespace sluice
