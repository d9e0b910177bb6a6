// What the plain device reads at a place of a chunk and at a value of the tables, in plain loops.
#pragma once

#include <array>

#include "src/base/vec.h"
#include "src/device/device.h"

namespace sluice {

// Trilinear; texel centres at integers, beyond the chunk its outermost texels.
double valueAt(const ChunkTexels& chunk, Vec3d at);

// Of the eight texels around: the value that has the greatest weight, of two alike the greater.
double labelAt(const ChunkTexels& chunk, Vec3d at);

// The table's entry of a device value, and between two entries where it interpolates.
std::array<double, 4> lookedUp(const LookUp& look_up, double value, bool interpolates);

// By what a gradient of that magnitude, at that value, multiplies the opacity; 1 without such a
// table.
double factorOf(const LookUp& look_up, double magnitude, double value);

}  // namespace sluice
