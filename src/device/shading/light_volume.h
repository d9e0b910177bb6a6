// LightVolume: how much light arrives at the places of a volume, in few texels: the key light,
// Lighting::lights[0], with the shadows that matter casts in it, and all other light with what
// matter around a place keeps away from it. Samples take both numbers trilinearly; beyond the
// outermost texels these continue.
//
// Plain data. It follows from the volume, the look, the light and what a frame shows of the volume,
// and not from blocks or memory.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "src/base/values/vec.h"

namespace sluice {

inline constexpr double kAllLight = 65535;

struct LightVolume {
  Vec3i dims;  // texels, each at least 2
  // Index position p has the texel coordinate p * scale + offset; texel centres are at integers.
  Vec3d scale{1, 1, 1}, offset;
  // x fastest, two numbers a texel, of kAllLight: of the key light, and of all other light.
  std::vector<uint16_t> texels;
  // Whether either is less than all of it anywhere: a device need not look at what is not.
  bool key_varies = true, other_varies = true;
};
using LightVolumePtr = std::shared_ptr<const LightVolume>;

}  // namespace sluice
