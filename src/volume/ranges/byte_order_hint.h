// Whether the values of a volume look as if their bytes had been read in the wrong order.
//
// In numbers that are read right, the upper part tells where in the range a value lies, so that it
// is uneven over a volume; the lower part is nearly random, so that it is even. Swapped, it is the
// other way round; floats swapped have any exponent, or none. Pure.
#pragma once

#include "src/base/values/voxel_type.h"
#include "src/volume/ranges/slice_ranges.h"

namespace sluice {

// True only if it is obvious; never for voxels of one byte. A false one costs a line of text, so
// that 8-bit values kept in the upper halves of 16 bits are let pass.
bool looksByteSwapped(const SliceRanges& ranges, VoxelType type);

}  // namespace sluice
