#include "src/render/camera.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "src/base/error.h"
#include "src/render/index_space.h"

namespace sluice {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

struct Orbit {
  Vec3d eye, target, up;
  double radius;  // of the sphere around the outer voxel centres
};

Orbit orbitOf(const Camera& camera, const VolumeLayout& layout) {
  const Vec3d outer = toDouble(layout.dims - Vec3i{1, 1, 1});
  const Vec3d center = worldFromIndex(layout, outer * 0.5);
  double radius = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3d index{(corner & 1) != 0 ? outer.x : 0, (corner & 2) != 0 ? outer.y : 0,
                      (corner & 4) != 0 ? outer.z : 0};
    radius = std::max(radius, length(worldFromIndex(layout, index) - center));
  }
  const double azimuth = camera.azimuth_deg * kDegree, elevation = camera.elevation_deg * kDegree;
  // From the target to the eye; along +z at first.
  const Vec3d back{std::sin(azimuth) * std::cos(elevation), std::sin(elevation),
                   std::cos(azimuth) * std::cos(elevation)};
  const Vec3d up{-std::sin(azimuth) * std::sin(elevation), std::cos(elevation),
                 -std::cos(azimuth) * std::sin(elevation)};
  const double distance = radius / std::sin(0.5 * camera.field_of_view_deg * kDegree);
  return {center + back * distance, center, up, radius};
}

void requireFinite(Vec3d v, const char* what) {
  if (!std::isfinite(v.x) || !std::isfinite(v.y) || !std::isfinite(v.z))
    fail("the camera's {} at {}, {}, {}: must be finite", what, v.x, v.y, v.z);
}

}  // namespace

View resolve(const Camera& camera, const VolumeLayout& layout, PictureSize size, double step_vox) {
  if (size.width < 1 || size.height < 1)
    fail("a picture of {} x {} pixels: both must be at least 1", size.width, size.height);
  if (!(step_vox > 0) || !std::isfinite(step_vox))
    fail("a step of {} voxels: must be above 0", step_vox);
  if (!(camera.zoom > 0) || !std::isfinite(camera.zoom))
    fail("a zoom of {}: must be above 0", camera.zoom);
  if (!(camera.field_of_view_deg > 0 && camera.field_of_view_deg < 180))
    fail("a field of view of {} degrees: must be above 0 and below 180", camera.field_of_view_deg);
  if (!std::isfinite(camera.azimuth_deg))
    fail("an azimuth of {} degrees: must be finite", camera.azimuth_deg);
  if (!std::isfinite(camera.elevation_deg))
    fail("an elevation of {} degrees: must be finite", camera.elevation_deg);
  Orbit orbit = orbitOf(camera, layout);
  if (camera.look_at) {
    orbit.eye = camera.look_at->eye;
    orbit.target = camera.look_at->target;
    orbit.up = camera.look_at->up;
  }
  requireFinite(orbit.eye, "eye");
  requireFinite(orbit.target, "target");
  requireFinite(orbit.up, "up direction");
  const Vec3d toward = orbit.target - orbit.eye;
  if (!(length(toward) > 0)) fail("the camera's eye lies on its target");
  const Vec3d side = cross(toward, orbit.up);
  if (!(length(side) > 1e-9 * length(toward) * length(orbit.up)))
    fail("the camera's up direction lies along its view");

  View view;
  view.projection = camera.projection;
  view.size = size;
  view.eye = orbit.eye;
  view.forward = normalized(toward);
  view.right = normalized(side);
  view.up = cross(view.right, view.forward);
  view.half_height = camera.projection == Projection::kPerspective
                         ? std::tan(0.5 * camera.field_of_view_deg * kDegree) / camera.zoom
                         : orbit.radius / camera.zoom;
  // A picture that is higher than wide shows the whole sphere too.
  if (size.width < size.height) view.half_height *= static_cast<double>(size.height) / size.width;
  view.step = step_vox * finestSpacing(layout);
  view.first_depth = std::numeric_limits<double>::infinity();
  const Vec3d outer = toDouble(layout.dims - Vec3i{1, 1, 1});
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3d index{(corner & 1) != 0 ? outer.x : 0, (corner & 2) != 0 ? outer.y : 0,
                      (corner & 4) != 0 ? outer.z : 0};
    view.first_depth =
        std::min(view.first_depth, dot(worldFromIndex(layout, index) - view.eye, view.forward));
  }
  return view;
}

}  // namespace sluice
