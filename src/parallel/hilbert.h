// Hilbert's curve through a cube of cells: neighbours on the curve share a face. Pure function.
#pragma once

#include <cstdint>

#include "src/base/values/vec.h"

namespace sluice {

// The position on the curve of cell `at` of a cube of 2^bits cells a side, from 0 to 2^(3 bits)
// - 1. The curve turns in each octant so that it enters where the last one was left (J. Skilling,
// Programming the Hilbert Curve, 2004). Requires: 0 <= at < 2^bits on each axis, bits <= 21.
uint64_t hilbertPosition(Vec3i at, int bits);

}  // namespace sluice
