#include "tests/support/plain_lighting.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace sluice {
namespace {

// The shares of the key light and of other light at an index position: trilinear.
std::array<double, 2> arrivingAt(const LightVolume& light, Vec3d at) {
  Vec3d texel = at * light.scale + light.offset;
  Vec3i low;
  for (int a = 0; a < 3; ++a) {
    texel[a] = std::clamp(texel[a], 0.0, static_cast<double>(light.dims[a] - 1));
    low[a] = std::min(static_cast<int64_t>(texel[a]), light.dims[a] - 2);
  }
  std::array<double, 2> shares{};
  for (int corner = 0; corner < 8; ++corner) {
    double weight = 1 / kAllLight;
    Vec3i here = low;
    for (int a = 0; a < 3; ++a) {
      const int up = corner >> a & 1;
      const double part = texel[a] - static_cast<double>(low[a]);
      here[a] += up;
      weight *= up != 0 ? part : 1 - part;
    }
    const auto i = static_cast<size_t>((here.z * light.dims.y + here.y) * light.dims.x + here.x);
    for (size_t n = 0; n < 2; ++n) shares[n] += weight * light.texels[2 * i + n];
  }
  return shares;
}

}  // namespace

Vec3d litPlainly(const FrameSetup& setup, Vec3d at, Vec3d rgb, const PlainSlopes& slopes,
                 double flatness) {
  const auto& [gradient, rough, here, seen] = slopes;
  const Lighting& lighting = setup.lighting;
  const auto [key, open] =
      setup.light != nullptr ? arrivingAt(*setup.light, at) : std::array<double, 2>{1, 1};
  const Vec3d plain = rgb * std::lerp(open, key, lighting.keyShare());
  const double along = dot(gradient, gradient) * here, squared = along + rough;
  if (!(squared > 0)) return plain;
  const Vec3d n = along > 0 ? normalized(gradient) : Vec3d{};
  const double directed = along / squared;
  double bright = lighting.ambient * open, shine = 0;
  for (size_t l = 0; l < lighting.lights.size(); ++l) {
    const Light& light = lighting.lights[l];
    const Vec3d halfway = normalized(light.toward + Vec3d{0, 0, 1});
    const double strength = light.strength * (l == 0 ? key : open);
    const double facing = std::lerp(0.5, std::abs(dot(n, light.toward)), directed);
    const double mirrored =
        std::lerp(1 / (lighting.shininess + 1),
                  std::pow(std::abs(dot(n, halfway)), lighting.shininess), directed);
    bright += lighting.diffuse * strength * facing;
    shine += lighting.specular * strength * mirrored;
  }
  const Vec3d lit = rgb * bright + Vec3d{shine, shine, shine};
  const double w = (seen * along + rough) / (squared + flatness * flatness);
  return plain * (1 - w) + lit * w;
}

}  // namespace sluice
