// The surfaces of a slice as the plain device blends them: those of a box and of the boxes that
// join it.
#include <algorithm>
#include <cmath>
#include <vector>

#include "tests/support/plain_device.h"
#include "tests/support/plain_lighting.h"
#include "tests/support/plain_rays.h"
#include "tests/support/plain_surfaces.h"

namespace sluice {

// The share of a surface of this opacity at an index position.
static double shareAt(const LevelFade& fade, Vec3d at, double opacity) {
  double share = 1;
  for (size_t i = 0; i < fade.slope.size() && opacity < 1; ++i) {
    const int axis = static_cast<int>(i) % 3;
    share *= std::clamp(fade.start[i] + fade.slope[i] * at[axis], 0.0, 1.0);
  }
  return share;
}

// The surfaces that the ray meets from half a slice before slice k to half a slice behind it, and
// between them the parts of the sample there.
void PlainDevice::blendSurfaces(const PlainRay& ray, const BoxDraw& box, const ChunkTexels& chunk,
                                double k, const Sample& sample, Pixel& pixel) const {
  const auto partOf = [](Sample of, double part) {
    of.opacity = 1 - std::pow(1 - of.opacity, part);
    return of;
  };
  struct Met {
    double part = 0;
    Sample color;
  };
  std::vector<Met> all;
  const auto addFrom = [&](const BoxDraw& from, const ChunkTexels& texels) {
    for (const PlainSurface& surface : surfacesBetween(
             setup_, from.texels, texels, [&](double part) { return ray.at(k - 0.5 + part); })) {
      if (from.beside && !from.fade && surface.level.opacity < 1) continue;
      const Vec3d at = ray.at(k - 0.5 + surface.part);
      const Vec3d rgb = setup_.lit
                            ? litPlainly(setup_, at, surface.level.rgb, {surface.gradient}, 0)
                            : surface.level.rgb;
      const double share = from.fade ? shareAt(*from.fade, at, surface.level.opacity) : 1;
      all.push_back({surface.part,
                     {rgb, 1 - std::pow(1 - surface.level.opacity, share),
                      setup_.first_depth + (k + ray.jitter + surface.part) * setup_.depth_step}});
    }
  };
  addFrom(box, chunk);
  for (const BoxDraw& joined : joined_) {
    const auto [from, to] = slicesIn(ray, joined.cells, setup_);
    const auto slice = static_cast<int64_t>(k);
    if (slice >= from && slice < to) addFrom(joined, *resident_.at(joined.chunk));
  }
  std::ranges::stable_sort(all, {}, &Met::part);
  double from = 0;
  for (const Met& met : all) {
    blend(partOf(sample, met.part - from), pixel);
    from = met.part;
    blend(met.color, pixel);
  }
  blend(partOf(sample, 1 - from), pixel);
}

}  // namespace sluice
