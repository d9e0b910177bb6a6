// ExpectedLook: how texels look that stand for many values each.
//
// A texel of a coarse level keeps two numbers: the mean of its voxels and their spread, which is
// twice their standard deviation. The transfer function of a mean is not the mean of the transfer
// function, so such a texel is drawn with the expected opacity and colour over its values.
//
// Their distribution is not known. It is taken as two uniform parts that meet at the mean and reach
// sqrt(3) standard deviations to either side. A part ends where the volume's values end; the other
// part then reaches far enough to keep mean and spread. If both end there, the share of the values
// that the spread asks for lies at the two ends. So mean and spread are always kept, nothing lies
// beyond the volume's values, and the greatest spread is two values alone (a net of thin bright
// lines).
//
// Between texels the mean is interpolated, and the square of the spread: values of two texels mixed
// have the mixed variances, and the difference between the means adds to them. That part is left
// out, since on a slope of values it would count the slope twice. Interpolating the spreads
// themselves would lose a quarter of the variance halfway from a thin line to the empty texel
// beside it, and with it a quarter of the line's opacity.
//
// The opacity applies to one unit length. Voxels along a ray count as independent draws: n lengths
// let (1 - expected opacity)^n through, and the colour is weighted by opacity.
//
// Pure functions.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "src/base/sources/volume_source.h"

namespace sluice {

struct LookUp;

// A share `at_ends` of the values lies at the ends of the volume's range and the rest is uniform on
// both sides of the mean; either has this mean.
struct SpreadValues {
  double mean = 0;
  double down = 0, up = 0;  // how far the uniform parts reach
  double at_ends = 0;
};
// A mean that cannot have such a spread within `range`, as rounding may bring about, counts as the
// nearest one that can.
SpreadValues spreadValues(double mean, double spread, ValueRange range);
// The least and the greatest of the values.
ValueRange spreadRange(double mean, double spread, ValueRange range);

struct ByteRange {
  uint8_t lo = 0, hi = 0;
};

// Entry e of a row stands for the mean device_range.lo + e * (hi - lo) / (entries - 1); row r for
// the spread (hi - lo) * ((r + 1) / rows)^2. Between entries and rows it is linear; between no
// spread, which is the LookUp itself, and the first row it is linear in (r + 1), the samples'
// corrected colours.
struct ExpectedLook {
  ValueRange device_range;
  int entries = 0, rows = 0;
  std::vector<float> rgba;  // row after row, premultiplied
  // For texels of bytes: shownRange() of each pair, rounded outwards, at [256 * mean + spread].
  // Empty for wider ones.
  std::vector<ByteRange> byte_ranges;
};
using ExpectedLookPtr = std::shared_ptr<const ExpectedLook>;

// The values that a sample with this mean and spread can show: those of all entries and rows that
// it is interpolated from.
ValueRange shownRange(double mean, double spread, const ExpectedLook& expected);

// `device_range` holds all device values of the volume. About a millisecond, and a few more for
// texels of bytes.
enum class TexelBytes { kOne, kMore };
ExpectedLook expectedLook(const LookUp& look_up, ValueRange device_range,
                          TexelBytes texels = TexelBytes::kMore);

}  // namespace sluice
