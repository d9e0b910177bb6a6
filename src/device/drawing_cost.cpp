#include "src/device/drawing_cost.h"

#include <algorithm>
#include <cmath>

namespace sluice {

double slicesAcross(const FrameSetup& setup, const Box3& cells) {
  const RayGrid& rays = setup.rays;
  const Vec3d step = rays.step0 + rays.step_dx * (0.5 * setup.size.width) +
                     rays.step_dy * (0.5 * setup.size.height);
  return 1 + length(toDouble(cells.size())) / length(step);
}

double aboutSamples(const FrameSetup& setup, const Box3& cells) {
  const RayGrid& rays = setup.rays;
  const double most =
      slicesAcross(setup, cells) * static_cast<double>(setup.size.width) * setup.size.height;
  Vec3d dx = rays.origin_dx, dy = rays.origin_dy;
  if (setup.projection == Projection::kPerspective) {
    const Vec3d centre = (toDouble(cells.lo) + toDouble(cells.hi)) * 0.5;
    const auto& row = setup.clip_from_index[2];
    const double depth = row[0] * centre.x + row[1] * centre.y + row[2] * centre.z + row[3];
    // The distance between rays says nothing there.
    if (depth <= 0) return most;
    // Neighbouring rays are apart in proportion to the depth.
    dx = rays.step_dx * (depth / setup.depth_step);
    dy = rays.step_dy * (depth / setup.depth_step);
  }
  // The volume between neighbouring rays and slices has one sample.
  const double of_one = std::abs(dot(cross(dx, dy), rays.step0));
  return std::min(most, static_cast<double>(cells.count()) / of_one);
}

}  // namespace sluice
