// Device voxels that stand for NaN, for infinities, or for finite values beyond kLargest: they are
// left out of ranges of numbers, and the finite ones have a range of their own.
#pragma once

#include <type_traits>

#include "src/base/sources/volume_source.h"
#include "src/base/values/vec.h"
#include "src/volume/ranges/block_ranges.h"
#include "src/volume/voxels/device_voxel.h"

namespace sluice {

// `total`, the range of a block's voxels, without those that stand for NaN and infinities. They are
// rare, so that a second look at such a block costs nothing.
template <class T>
PlaneRange<T> numbersOf(PlaneRange<T> total, const T* voxels, Vec3i size, Vec3i stride_size) {
  if constexpr (std::is_same_v<T, float>) {
    if (total.lo > -kLargest && total.hi < kLargest) return total;
    total = kNoVoxels<T>;
    for (int64_t z = 0; z < size.z; ++z)
      for (int64_t y = 0; y < size.y; ++y) {
        const float* row = voxels + (z * stride_size.y + y) * stride_size.x;
        for (int64_t x = 0; x < size.x; ++x)
          if (row[x] > -kLargest && row[x] < kLargest) widen(total, {row[x], row[x]});
      }
  }
  return total;
}

// Widens a range; lo > hi: nothing.
void widenFar(ValueRange& range, const ValueRange& by);

// Whether one of a block's device voxels stands for an infinity or for a value as far away.
bool hasFarVoxels(const float* voxels, Vec3i size, Vec3i stride_size);

// The range of the finite stored values of a box that are beyond kLargest; lo > hi: there are none.
// Throws Error from the source.
ValueRange farRange(VolumeSource& source, int64_t time, const Box3& box);

}  // namespace sluice
