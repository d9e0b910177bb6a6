#include "tests/support/reference_gradients.h"

#include <algorithm>
#include <cmath>

namespace sluice {

Vec3d ReferenceGradients::at(Vec3d p) const {
  Vec3d g;
  for (int a = 0; a < 3; ++a) {
    Vec3d before = p, after = p;
    before[a] = std::max(p[a] - 1, 0.0);
    after[a] = std::min(p[a] + 1, static_cast<double>(layout_.dims[a] - 1));
    const double difference = values_.at(after) - values_.at(before);
    if (std::isnan(difference)) continue;  // tells nothing of the slope along this axis
    g = g + layout_.axes[static_cast<size_t>(a)] * (difference / (2 * layout_.spacing[a]));
  }
  return g;
}

Vec3d ReferenceGradients::ofLabels(Vec3d p) const {
  const Vec3d low{std::floor(p.x), std::floor(p.y), std::floor(p.z)};
  Vec3d g;
  for (int i = 0; i < 8 * 27; ++i) {
    Vec3d way, voxel = low;
    double weight = 1;
    for (int a = 0, corner = i / 27, rest = i % 27; a < 3; ++a, corner /= 2, rest /= 3) {
      way[a] = rest % 3 - 1;
      voxel[a] += corner % 2 + way[a];
      weight *= corner % 2 != 0 ? p[a] - low[a] : 1 - (p[a] - low[a]);
    }
    if (weight == 0) continue;
    const double label = values_.at(clampedTo(boxOf(layout_.dims), voxel));
    if (std::isnan(label)) continue;
    const double opacity = opacityAt(transfer_, label);
    for (int a = 0; a < 3; ++a) {
      double across = 1;
      for (int b = 0; b < 3; ++b)
        if (b != a) across *= way[b] == 0 ? 0.5 : 0.25;
      const double slope = weight * across * way[a] / 2 * opacity;
      g = g + layout_.axes[static_cast<size_t>(a)] * (slope / layout_.spacing[a]);
    }
  }
  return g;
}

Vec3d ReferenceGradients::overCube(Vec3d p, double value) const {
  Vec3d g;
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3d side{(corner & 1) - 0.5, (corner >> 1 & 1) - 0.5, (corner >> 2) - 0.5};
    double there = values_.at(clampedTo(boxOf(layout_.dims), p + side));
    if (std::isnan(there)) there = value;
    for (int a = 0; a < 3; ++a)
      g = g + layout_.axes[static_cast<size_t>(a)] * (side[a] * there / (2 * layout_.spacing[a]));
  }
  return g;
}

}  // namespace sluice
