#include "src/render/camera/camera.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "src/base/error.h"
#include "src/base/looks/view_limits.h"
#include "src/base/values/corners.h"
#include "src/render/camera/index_space.h"

namespace sluice {
namespace {

struct Orbit {
  Vec3d eye, target, up;
  double half_height;  // at zoom 1, as in View
};

struct Sphere {
  Vec3d center;
  double radius;
};

Sphere sphereAround(const VolumeLayout& layout) {
  const Vec3d outer = toDouble(layout.dims - Vec3i{1, 1, 1});
  // The sphere touches all corners, so that no view of it cuts the volume off.
  Sphere sphere{worldFromIndex(layout, outer * 0.5), 0};
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3d index = cornerOf({}, outer, corner);
    sphere.radius = std::max(sphere.radius, length(worldFromIndex(layout, index) - sphere.center));
  }
  return sphere;
}

Orbit orbitOf(const Camera& camera, const VolumeLayout& layout, PictureSize size) {
  const bool perspective = camera.projection == Projection::kPerspective;
  const double half_angle = 0.5 * camera.field_of_view_deg * kDegree;
  const Sphere sphere = sphereAround(layout);
  // A picture that is higher than wide shows the whole sphere too.
  const double height_factor =
      std::max(1.0, static_cast<double>(size.height) / static_cast<double>(size.width));
  Orbit orbit;
  orbit.half_height = (perspective ? std::tan(half_angle) : sphere.radius) * height_factor;
  if (camera.look_at) {
    orbit.eye = camera.look_at->eye;
    orbit.target = camera.look_at->target;
    orbit.up = camera.up.value_or(frontAxes(camera.view, layout.frame, {}).up);
    return orbit;
  }
  const ViewAxes axes = axesOf(camera, layout.frame);
  // The sphere touches the sides of the picture at this distance.
  double distance = sphere.radius / std::sin(half_angle);
  orbit.target = sphere.center;
  if (camera.framing) {
    orbit.target = camera.framing->target;
    if (perspective) {
      distance = camera.framing->reach;
    } else {
      orbit.half_height = camera.framing->reach;
    }
  }
  orbit.up = axes.up;
  if (camera.framing) {
    // The framing leaves room on two sides: the target moves by shares of half the picture.
    const double half = orbit.half_height / camera.zoom * (perspective ? distance : 1);
    const double aspect = size.aspect();
    orbit.target = orbit.target - axes.right * (camera.framing->right * half * aspect) -
                   axes.up * (camera.framing->up * half);
  }
  orbit.eye = orbit.target + axes.back * distance;
  return orbit;
}

void requireFinite(Vec3d v, const char* what) {
  if (!std::isfinite(v.x) || !std::isfinite(v.y) || !std::isfinite(v.z))
    failRequest("the camera's {} at {}, {}, {}: must be finite", what, v.x, v.y, v.z);
}

// The orbit of a valid camera.
Orbit validOrbit(const Camera& camera, const VolumeLayout& layout, PictureSize size) {
  requireValid(camera, size);
  const Orbit orbit = orbitOf(camera, layout, size);
  requireFinite(orbit.eye, "eye");
  requireFinite(orbit.target, "target");
  requireFinite(orbit.up, "up direction");
  const Vec3d toward = orbit.target - orbit.eye;
  if (!(length(toward) > 0)) failRequest("the camera's eye lies on its target");
  // Parallel to 1e-9: the right direction would be noise.
  if (!(length(cross(toward, orbit.up)) > 1e-9 * length(toward) * length(orbit.up)))
    failRequest("the camera's up direction lies along its view");
  return orbit;
}

}  // namespace

void requireValid(const Camera& camera, const VolumeLayout& layout, PictureSize size) {
  validOrbit(camera, layout, size);
}

void requireValid(const Camera& camera, PictureSize size) {
  if (size.width < 1 || size.height < 1)
    failRequest("a picture of {} x {} pixels: both must be at least 1", size.width, size.height);
  if (!(camera.zoom >= kLeastZoom && camera.zoom <= kMostZoom))
    failRequest("a zoom of {}: must be from {} to {}", camera.zoom, kLeastZoom, kMostZoom);
  if (!(camera.field_of_view_deg >= kLeastFieldOfViewDeg && camera.field_of_view_deg < 180))
    failRequest("a field of view of {} degrees: must be at least {} and below 180",
                camera.field_of_view_deg, kLeastFieldOfViewDeg);
  // Infinite angles would give axes of NaN.
  if (!std::isfinite(camera.azimuth_deg))
    failRequest("an azimuth of {} degrees: must be finite", camera.azimuth_deg);
  if (!std::isfinite(camera.elevation_deg))
    failRequest("an elevation of {} degrees: must be finite", camera.elevation_deg);
  if (!camera.up) return;
  requireFinite(*camera.up, "up direction");
  if (!(length(*camera.up) > 0))
    failRequest("the camera's up direction is 0, 0, 0: must have a length");
}

ViewAxes axesOf(const Camera& camera, WorldFrame frame) {
  const ViewTurn from = turnOf(camera.view, frame);
  return turned(frontAxes(camera.view, frame, camera.up),
                {from.azimuth_deg + camera.azimuth_deg, from.elevation_deg + camera.elevation_deg});
}

View resolve(const Camera& camera, const VolumeLayout& layout, PictureSize size, double step_vox) {
  const Orbit orbit = validOrbit(camera, layout, size);
  if (!(step_vox > 0) || !std::isfinite(step_vox))
    failRequest("a step of {} voxels: must be above 0", step_vox);
  const Vec3d toward = orbit.target - orbit.eye;
  View view;
  view.projection = camera.projection;
  view.size = size;
  view.eye = orbit.eye;
  view.forward = normalized(toward);
  view.right = normalized(cross(toward, orbit.up));
  view.up = cross(view.right, view.forward);
  view.half_height = orbit.half_height / camera.zoom;
  view.step = step_vox * finestSpacing(layout);
  view.first_depth = std::numeric_limits<double>::infinity();
  double last_depth = -view.first_depth;
  const Vec3d outer = toDouble(layout.dims - Vec3i{1, 1, 1});
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3d index = cornerOf({}, outer, corner);
    const double depth = dot(worldFromIndex(layout, index) - view.eye, view.forward);
    view.first_depth = std::min(view.first_depth, depth);
    last_depth = std::max(last_depth, depth);
  }
  // Beyond this limit the devices, which count slices in floats, would silently leave some out.
  constexpr double kMostSlices = 1 << 24;
  const double slices = (last_depth - view.first_depth) / view.step;
  // A hundredth more than needed, for the rounding of the step that the message gives.
  const double step_needed = 1.01 * step_vox * slices / kMostSlices;
  const Vec3d& spacing = layout.spacing;
  // With even voxels the step would do.
  if (!(slices <= kMostSlices) && length(outer) / step_vox <= kMostSlices)
    failRequest(
        "{}: its spacing of {:g} x {:g} x {:g} makes {:.3g} slices along the view, of which at "
        "most "
        "{} can be drawn; correct it with --spacing, or give --step {:.2g} or more",
        layout.calledBy(), spacing.x, spacing.y, spacing.z, slices,
        static_cast<int64_t>(kMostSlices), step_needed);
  if (!(slices <= kMostSlices))
    failRequest(
        "{}: --step {}: {:.3g} slices along the view, of which at most {} can be drawn; give "
        "--step {:.2g} or more",
        layout.calledBy(), step_vox, slices, static_cast<int64_t>(kMostSlices), step_needed);
  return view;
}

}  // namespace sluice
