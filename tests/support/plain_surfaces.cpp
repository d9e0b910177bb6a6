#include "tests/support/plain_surfaces.h"

#include <algorithm>

#include "tests/support/plain_sampling.h"

namespace sluice {
namespace {

// Between the eight corners of a unit cube, in texels.
Vec3d cubeGradient(const FrameSetup& setup, const TexelMap& texels, const ChunkTexels& chunk,
                   Vec3d at, double level) {
  Vec3d gradient;
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3d side{(corner & 1) - 0.5, (corner >> 1 & 1) - 0.5, (corner >> 2) - 0.5};
    double value = valueAt(chunk, at + side);
    if (value < kNoNumber) value = level;
    for (int a = 0; a < 3; ++a) {
      const auto axis = static_cast<size_t>(texels.axes[static_cast<size_t>(a)]);
      gradient = gradient + setup.camera_gradient[axis] * (side[a] * value / 2 * texels.scale[a]);
    }
  }
  return gradient;
}

}  // namespace

std::vector<PlainSurface> surfacesBetween(const FrameSetup& setup, const TexelMap& texels,
                                          const ChunkTexels& chunk,
                                          const std::function<Vec3d(double part)>& place_at) {
  const auto texelOf = [&](double part) {
    Vec3d texel = texels(place_at(part));
    for (int a = 0; a < 3; ++a)
      texel[a] = std::clamp(texel[a], 0.0, static_cast<double>(chunk.storage_vox[a] - 1));
    return texel;
  };
  const auto valueOf = [&](double part) { return valueAt(chunk, texelOf(part)); };
  const double front = valueOf(0), back = valueOf(1);
  std::vector<PlainSurface> met;
  if (std::min(front, back) < kNoNumber) return met;
  std::vector<SurfaceLevel> levels = setup.look_up->surfaces;
  if (back < front) std::ranges::reverse(levels);
  double from = 0;
  for (const SurfaceLevel& level : levels) {
    if ((front >= level.level) == (back >= level.level)) continue;
    double lo = from, hi = 1;
    for (int i = 0; i < 40; ++i) {
      const double middle = (lo + hi) / 2;
      ((valueOf(middle) < level.level) == (front < level.level) ? lo : hi) = middle;
    }
    met.push_back({lo, level, cubeGradient(setup, texels, chunk, texelOf(lo), level.level)});
    from = lo;
  }
  return met;
}

}  // namespace sluice
