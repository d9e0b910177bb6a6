// Samples a chunk's texels and the tables as the plain device does, in plain loops.
#pragma once

#include <array>

#include "src/base/values/vec.h"
#include "src/device/device.h"

namespace sluice {

// Trilinear; texel centres at integers, beyond the chunk its outermost texels. The mean in a chunk
// with spreads.
double valueAt(const ChunkTexels& chunk, Vec3d at);
// The spread there, whose square is trilinear; texels that are no number have none. Requires: the
// chunk has spreads.
double spreadAt(const ChunkTexels& chunk, Vec3d at);

// The value with the greatest weight among the eight texels around; of two with the same weight,
// the greater.
double labelAt(const ChunkTexels& chunk, Vec3d at);

// The table's entry of a device value, interpolated between two entries if it interpolates.
std::array<double, 4> lookedUp(const LookUp& look_up, double value, bool interpolates);

// The table's entry of a mean and a spread, premultiplied, and the share by which it stands for
// them; the rest is the mean's look without spread.
struct ExpectedEntry {
  std::array<double, 4> rgba{};
  double share = 0;
};
ExpectedEntry expectedAt(const ExpectedLook& look, double mean, double spread);

// The factor of the opacity at a gradient of that magnitude and that value; 1 without such a table.
double factorOf(const LookUp& look_up, double magnitude, double value);

}  // namespace sluice
