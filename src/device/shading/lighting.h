// Lighting: Phong with two directional lights fixed to the camera (Li 2003, section 5).
//
// The folder: the light of samples, and the tables of opacities and colours that devices look up
// (expected_look.h, integrated_look.h, look_up_texels.h).
//
// At a sample, g is the central difference of the interpolated values one texel to either side
// along each index axis (positions clamped to the volume), divided by twice the distance of texels
// in the world and turned to world directions. With n = g / |g|, w = |g|^2 / (|g|^2 + flat^2),
//   lit = colour * (ambient + diffuse * sum_l s_l |n.l|) + specular * sum_l s_l |n.h_l|^shininess
//   shown = mix(colour, lit, w),   h_l = normalized(l + toward the viewer), toward viewer =
//   -forward
// so that flat regions, of noisy direction, keep their own colour. With spreads: rough_light.h.
//
// The numbers of labels are no values. Their g is that of their opacity of one voxel length, by
// Sobel's operator at the eight texels around the sample, interpolated, so that only what shows has
// a surface, whatever the numbers, and the steps of voxels leave fewer traces on it: the brightness
// of a ball is half as far from a sphere's as with central differences of the numbers
// (tests/render/modes_test.cpp). Chunks with shares: see label_shares.h.
//
// With a LightVolume, a share `key` of the first light arrives at the sample, and a share `open` of
// all other light: s_1 is multiplied by `key`, s_2 and `ambient` by `open`, and the colour of flat
// regions by mix(open, key, keyShare()).
//
// A transfer function that looks at gradients multiplies the opacity of one voxel length by its
// factor for |g| before the opacity is corrected for the step, lit or unlit (Li 2003, figure 1).
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "src/base/values/vec.h"

namespace sluice {

// Labels: `flat` in opacities of one voxel length a finest spacing, less than any label's that is
// seen, and more than rounding.
inline constexpr double kFlatOpacity = 1e-3;

struct Light {
  Vec3d toward;     // unit, camera space: x right, y up, z toward the viewer
  double strength;  // s_l
};

struct Lighting {
  double ambient = 0.3, diffuse = 0.65, specular = 0.2, shininess = 24;
  // `flat` in value units a world unit is flat_share * (value range) / (finest spacing).
  double flat_share = 0.02;
  std::array<Light, 2> lights{
      {{{-0.3244428422615251, 0.48666426339228763, 0.8111071056538127}, 0.9},
       {{0.7844645405527362, -0.19611613513818404, 0.5883484054145521}, 0.35}}};

  // How much of the light matter takes away that lies between a place and the first light, and
  // around the place: 0 to 1, see LightVolume.
  double shadows = 0, occlusion = 0;
  bool looksAround() const { return shadows > 0 || occlusion > 0; }
  // The share of the first light in all that arrives.
  double keyShare() const {
    const double key = diffuse * lights[0].strength;
    const double others = ambient + diffuse * lights[1].strength;
    return key + others > 0 ? key / (key + others) : 0.5;
  }

  // The exponent of the highlights if multiplying it out is worth while; otherwise 0.
  int wholeShininess() const {
    constexpr double kMost = 256;
    const double whole = std::floor(std::clamp(shininess, 0.0, kMost));
    return whole == shininess ? static_cast<int>(whole) : 0;
  }
};

}  // namespace sluice
