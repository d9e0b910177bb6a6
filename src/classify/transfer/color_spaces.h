// The colour spaces in which ParaView's colour maps are interpolated.
//
// RGB is sRGB in 0..1. Pure functions.
#pragma once

#include "src/base/values/vec.h"

namespace sluice {

// CIELAB under D65: lightness 0..100, a, b.
Vec3d labFromRgb(Vec3d rgb);
// A colour that no screen shows is darkened until its largest channel is 1; channels below 0 are 0.
Vec3d rgbFromLab(Vec3d lab);

// Hue, saturation and value, each in 0..1.
Vec3d hsvFromRgb(Vec3d rgb);
Vec3d rgbFromHsv(Vec3d hsv);

// The colour at `t` (0..1) between two colours.
Vec3d mixLab(Vec3d a, Vec3d b, double t);
// Hues are numbers: from 0.9 to 0.1 passes 0.5.
Vec3d mixHsv(Vec3d a, Vec3d b, double t);
// Hues are a circle: from 0.9 to 0.1 passes 0.
Vec3d mixHsvShortWay(Vec3d a, Vec3d b, double t);
// Passes through white if both are saturated and their hues differ (Moreland 2009, "Diverging Color
// Maps for Scientific Visualization", sections 4 and 5).
Vec3d mixDiverging(Vec3d a, Vec3d b, double t);

}  // namespace sluice
