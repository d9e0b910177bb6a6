// Slice ranges as the tests build them, and a look at each voxel to check them against.
#pragma once

#include <functional>
#include <limits>

#include "src/base/values/voxel_type.h"
#include "src/volume/ranges/slice_ranges.h"
#include "tests/support/memory_source.h"

namespace sluice {

// The ranges of a time step in blocks of `size` voxels a side.
SliceRanges buildRanges(VolumeSource& source, int64_t size, int ghost = 0, int threads = 2,
                        int64_t time = 0);

// A stored value as levels 2 to 4 hold it, written down from device_voxel.h.
double deviceValue(VoxelType type, double stored);
// The device voxel of a volume in memory.
double voxelAt(const MemorySource& source, int64_t time, Vec3i p);

struct VoxelRange {
  double lo = std::numeric_limits<double>::infinity(), hi = -lo;
  void take(double v);
};
// The device voxel at a place.
using VoxelAt = std::function<double(Vec3i)>;
// The voxels of a box, one at a time.
VoxelRange rangeOf(const Box3& box, const VoxelAt& voxel);

// Every array of every block against a look at each voxel; blocks that are not held must be nothing
// but background. Fails fatally (HasFatalFailure) at the first that differs.
void expectRangesOf(const SliceRanges& ranges, const VoxelAt& voxel);

}  // namespace sluice
