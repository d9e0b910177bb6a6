// A light that makes the normals of a picture's surfaces visible.
#pragma once

#include "src/device/shading/lighting.h"

namespace sluice {

// A single light, whose brightness is the product of its direction and the normal.
inline Lighting oneLight(Vec3d toward) {
  Lighting lighting;
  lighting.ambient = lighting.specular = 0;
  lighting.diffuse = 1;
  lighting.lights = {{{toward, 1}, {toward, 0}}};
  return lighting;
}

}  // namespace sluice
