#include "tests/support/reference_lighting.h"

#include <cmath>

namespace sluice {

double flatReference(const ReferenceScene& scene, double finest) {
  if (scene.transfer.labels) return 1e-3 / finest;
  return scene.lighting->flat_share * (scene.value_range.hi - scene.value_range.lo) / finest;
}

Vec3d litReference(const ReferenceScene& scene, const View& view, double flat, Vec3d gradient,
                   Vec3d rgb, std::array<double, 2> arriving) {
  const Lighting& lighting = *scene.lighting;
  const auto [key, open] = arriving;
  const double key_light = lighting.diffuse * lighting.lights[0].strength;
  const double other_light = lighting.ambient + lighting.diffuse * lighting.lights[1].strength;
  const double whole = key_light + other_light;
  const Vec3d flat_rgb =
      rgb * (whole > 0 ? (key * key_light + open * other_light) / whole : (key + open) / 2);
  const double g2 = dot(gradient, gradient);
  if (!(g2 > 0)) return flat_rgb;
  const double w = g2 / (g2 + flat * flat);
  const Vec3d n = normalized(gradient);
  const Vec3d viewer = -view.forward;
  double diffuse = 0, specular = 0, share = key;
  for (const Light& light : lighting.lights) {
    const Vec3d l =
        view.right * light.toward.x + view.up * light.toward.y + viewer * light.toward.z;
    diffuse += share * light.strength * std::abs(dot(n, l));
    specular += share * light.strength *
                std::pow(std::abs(dot(n, normalized(l + viewer))), lighting.shininess);
    share = open;
  }
  const double shine = lighting.specular * specular;
  const Vec3d shown =
      rgb * (lighting.ambient * open + lighting.diffuse * diffuse) + Vec3d{shine, shine, shine};
  return flat_rgb * (1 - w) + shown * w;
}

}  // namespace sluice
