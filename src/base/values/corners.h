// Corners of boxes, by number: bit 0 of it chooses the side along x, bit 1 along y, bit 2 along z.
#pragma once

#include "src/base/values/vec.h"

namespace sluice {

// Requires: 0 <= corner < 8.
template <class T>
constexpr Vec3<T> cornerOf(Vec3<T> lo, Vec3<T> hi, int corner) {
  return {(corner & 1) != 0 ? hi.x : lo.x, (corner & 2) != 0 ? hi.y : lo.y,
          (corner & 4) != 0 ? hi.z : lo.z};
}
constexpr Vec3i cornerOf(const Box3& box, int corner) {
  return cornerOf(box.lo, box.hi, corner);
}

}  // namespace sluice
