// Conversion from double to single precision, for the kernels' input.
#pragma once

#include "src/base/values/vec.h"
#include "src/cpu/kernels/kernel_values.h"

namespace sluice {

inline Float3 asFloats(Vec3d v) {
  return {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)};
}

}  // namespace sluice
