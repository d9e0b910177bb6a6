#include "tests/support/clipped_points.h"

#include <array>
#include <cmath>

namespace sluice {
namespace {

using Polygon = std::vector<Vec3d>;

Polygon cut(const Polygon& polygon, const ReferenceClipPlane& plane) {
  const double margin = 1e-9 * length(plane.normal);
  Polygon kept;
  for (size_t i = 0; i < polygon.size(); ++i) {
    const Vec3d from = polygon[i], to = polygon[(i + 1) % polygon.size()];
    const double before = dot(plane.normal, from) - plane.offset;
    const double after = dot(plane.normal, to) - plane.offset;
    if (before <= margin) kept.push_back(from);
    if ((before < 0 && after > 0) || (before > 0 && after < 0))
      kept.push_back(from + (to - from) * (before / (before - after)));
  }
  return kept;
}

// A square on the plane, larger than the box.
Polygon squareOn(const ReferenceClipPlane& plane, Vec3d middle, double side) {
  const Vec3d normal = plane.normal / length(plane.normal);
  const Vec3d on = middle + normal * (plane.offset / length(plane.normal) - dot(normal, middle));
  const Vec3d other = std::abs(normal.x) < 0.5 ? Vec3d{1, 0, 0} : Vec3d{0, 1, 0};
  const Vec3d u = cross(normal, other) * side, v = cross(normal, u);
  return {on + u + v, on + u - v, on - u - v, on - u + v};
}

}  // namespace

std::vector<Vec3d> clippedPoints(const std::vector<Vec3d>& corners,
                                 const std::vector<ReferenceClipPlane>& planes) {
  const Vec3d middle = (corners[0] + corners[7]) * 0.5;
  const double side = 4 * length(corners[7] - corners[0]);
  std::vector<ReferenceClipPlane> all = planes;
  std::vector<Polygon> polygons;
  for (int a = 0; a < 3; ++a) {
    const size_t along = size_t{1} << a;
    const Vec3d outward = corners[along] - corners[0];
    all.push_back({outward, dot(outward, corners[along])});
    all.push_back({outward * -1.0, -dot(outward, corners[0])});
  }
  std::vector<Vec3d> points;
  for (size_t i = 0; i < all.size(); ++i) {
    Polygon polygon = squareOn(all[i], middle, side);
    for (size_t j = 0; j < all.size(); ++j)
      if (j != i) polygon = cut(polygon, all[j]);
    points.insert(points.end(), polygon.begin(), polygon.end());
  }
  return points;
}

}  // namespace sluice
