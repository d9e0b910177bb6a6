// What the plain device reads at a place of a chunk and at a value of the tables, in plain loops.
#pragma once

#include <array>

#include "src/base/vec.h"
#include "src/device/device.h"

namespace sluice {

// Trilinear; texel centres at integers, beyond the chunk its outermost texels. Of a chunk with
// spreads number 0 is the mean and 1 the spread.
double valueAt(const ChunkTexels& chunk, Vec3d at, int number = 0);

// Of the eight texels around: the value that has the greatest weight, of two alike the greater.
double labelAt(const ChunkTexels& chunk, Vec3d at);

// The table's entry of a device value, and between two entries where it interpolates.
std::array<double, 4> lookedUp(const LookUp& look_up, double value, bool interpolates);

// The table's entry of a mean and a spread, premultiplied, and by what share it stands for them;
// the rest is what the mean looks like without spread.
struct ExpectedEntry {
  std::array<double, 4> rgba{};
  double share = 0;
};
ExpectedEntry expectedAt(const ExpectedLook& look, double mean, double spread);

// By what a gradient of that magnitude, at that value, multiplies the opacity; 1 without such a
// table.
double factorOf(const LookUp& look_up, double magnitude, double value);

}  // namespace sluice
