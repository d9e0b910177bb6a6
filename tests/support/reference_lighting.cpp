#include "tests/support/reference_lighting.h"

#include <cmath>

namespace sluice {

double flatReference(const ReferenceScene& scene, double finest) {
  if (scene.transfer.labels) return 0;
  return scene.lighting->flat_share * (scene.value_range.hi - scene.value_range.lo) / finest;
}

Vec3d litReference(const ReferenceScene& scene, const View& view, double flat, Vec3d gradient,
                   Vec3d rgb) {
  const Lighting& lighting = *scene.lighting;
  const double g2 = dot(gradient, gradient);
  if (!(g2 > 0)) return rgb;
  const double w = g2 / (g2 + flat * flat);
  const Vec3d n = normalized(gradient);
  const Vec3d viewer = -view.forward;
  double diffuse = 0, specular = 0;
  for (const Light& light : lighting.lights) {
    const Vec3d l =
        view.right * light.toward.x + view.up * light.toward.y + viewer * light.toward.z;
    diffuse += light.strength * std::abs(dot(n, l));
    specular +=
        light.strength * std::pow(std::abs(dot(n, normalized(l + viewer))), lighting.shininess);
  }
  const double shine = lighting.specular * specular;
  const Vec3d shown =
      rgb * (lighting.ambient + lighting.diffuse * diffuse) + Vec3d{shine, shine, shine};
  return rgb * (1 - w) + shown * w;
}

}  // namespace sluice
