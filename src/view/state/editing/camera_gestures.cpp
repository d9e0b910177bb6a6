#include "src/view/state/editing/camera_gestures.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "src/base/error.h"

namespace sluice {
namespace {

constexpr double kDegree = std::numbers::pi / 180;
// The limits are closer than those of the option, so that a wheel cannot lead so far away that the
// way back is not found.
constexpr double kLeastZoomByHand = 1e-3, kMostZoomByHand = 1e5;

Vec3d vec(const std::array<double, 3>& v) {
  return {v[0], v[1], v[2]};
}
std::array<double, 3> asArray(Vec3d v) {
  return {v.x, v.y, v.z};
}

bool isPerspective(const ViewOptions& view) {
  return view.projection == ViewOptions::Projection::kPerspective;
}
double distanceOf(const ViewOptions& view) {
  return length(vec(view.look_at->eye) - vec(view.look_at->target));
}

// `v` turned about the unit direction `axis`, counterclockwise as seen from its end.
Vec3d rotated(Vec3d v, Vec3d axis, double angle) {
  // This is the formula of Rodrigues.
  const double c = std::cos(angle), s = std::sin(angle);
  return v * c + cross(axis, v) * s + axis * (dot(axis, v) * (1 - c));
}

// Half of the pane's height at depth 1 of a perspective view; of a parallel one in world units.
double halfHeight(const ViewOptions& view, Pane pane, const Ground& ground) {
  // The shorter side of the pane spans the field of view.
  const double factor = std::max(1.0, static_cast<double>(pane.height) / pane.width);
  const double whole =
      isPerspective(view) ? std::tan(view.field_of_view_deg * kDegree / 2) : ground.radius;
  return whole * factor / view.zoom;
}

ViewOptions moved(ViewOptions view, Vec3d by) {
  view.look_at->eye = asArray(vec(view.look_at->eye) + by);
  view.look_at->target = asArray(vec(view.look_at->target) + by);
  return view;
}

double turnOf(double pixels, Pane pane) {
  // A drag across the shorter side of the pane turns by half a circle.
  return std::numbers::pi * pixels / std::max(1, std::min(pane.width, pane.height));
}

}  // namespace

Ground groundOf(const VolumeInfo& info) {
  const auto corner = [&](int which) {
    Vec3d world = vec(info.origin);
    for (size_t a = 0; a < 3; ++a)
      if (((which >> a) & 1) != 0)
        world =
            world + vec(info.axes[a]) * (info.spacing[a] * static_cast<double>(info.dims[a] - 1));
    return world;
  };
  Ground ground;
  ground.center = (corner(0) + corner(7)) * 0.5;
  ground.radius = 0;
  for (int which = 0; which < 8; ++which)
    ground.radius = std::max(ground.radius, length(corner(which) - ground.center));
  ground.finest_spacing = *std::min_element(info.spacing.begin(), info.spacing.end());
  // A volume of one voxel still needs a length that movements are measured by.
  if (!(ground.radius > 0)) ground.radius = ground.finest_spacing;
  return ground;
}

PlacedAxes axesOf(const ViewOptions& view) {
  SLUICE_CHECK(view.look_at && view.up);
  const Vec3d back = normalized(vec(view.look_at->eye) - vec(view.look_at->target));
  // `up` need not be across the view: only its part across it counts.
  const Vec3d right = normalized(cross(vec(*view.up), back));
  return {right, cross(back, right), back};
}

double worldPerPixel(const ViewOptions& view, Pane pane, const Ground& ground) {
  const double half = halfHeight(view, pane, ground);
  return 2 * half * (isPerspective(view) ? distanceOf(view) : 1) / pane.height;
}

Vec3d worldAt(const ViewOptions& view, double x, double y, Pane pane, const Ground& ground) {
  const PlacedAxes axes = axesOf(view);
  const double pixel = worldPerPixel(view, pane, ground);
  return vec(view.look_at->target) + axes.right * ((x - pane.width / 2.0) * pixel) -
         axes.up * ((y - pane.height / 2.0) * pixel);
}

std::optional<PanePoint> paneOf(const ViewOptions& view, Vec3d world, Pane pane,
                                const Ground& ground) {
  const PlacedAxes axes = axesOf(view);
  const Vec3d from_eye = world - vec(view.look_at->eye);
  double pixel = 2 * halfHeight(view, pane, ground) / pane.height;
  if (isPerspective(view)) {
    const double depth = -dot(from_eye, axes.back);
    // At the eye's own depth or behind it there is no place on the pane.
    if (!(depth > 1e-9 * ground.radius)) return std::nullopt;
    pixel *= depth;
  }
  return PanePoint{pane.width / 2.0 + dot(from_eye, axes.right) / pixel,
                   pane.height / 2.0 - dot(from_eye, axes.up) / pixel};
}

ViewOptions orbit(const ViewOptions& view, double dx, double dy, Pane pane) {
  const PlacedAxes axes = axesOf(view);
  // The volume follows the pointer, so that the eye goes against it.
  const double across = -turnOf(dx, pane), down = -turnOf(dy, pane);
  // The tilt comes first and the turn about the tilted up axis second, so that a drag never meets a
  // pole.
  const Vec3d tilted = rotated(axes.back, axes.right, down);
  const Vec3d up = rotated(axes.up, axes.right, down);
  ViewOptions next = view;
  next.look_at->eye =
      asArray(vec(view.look_at->target) + rotated(tilted, axes.up, across) * distanceOf(view));
  next.up = asArray(rotated(up, axes.up, across));
  return next;
}

ViewOptions turn(const ViewOptions& view, double degrees) {
  const Vec3d up = axesOf(view).up, target = vec(view.look_at->target);
  ViewOptions next = view;
  next.look_at->eye =
      asArray(target + rotated(vec(view.look_at->eye) - target, up, degrees * kDegree));
  next.up = asArray(up);
  return next;
}

ViewOptions pan(const ViewOptions& view, double dx, double dy, Pane pane, const Ground& ground) {
  const PlacedAxes axes = axesOf(view);
  // The depth of the target is what the pointer holds; points before and behind it move by more and
  // less.
  const double pixel = worldPerPixel(view, pane, ground);
  return moved(view, axes.up * (dy * pixel) - axes.right * (dx * pixel));
}

ViewOptions zoomTo(const ViewOptions& view, double factor, double x, double y, Pane pane,
                   const Ground& ground) {
  const Vec3d under = worldAt(view, x, y, pane, ground);
  const Vec3d target = vec(view.look_at->target);
  ViewOptions next = view;
  if (isPerspective(view)) {
    // The eye stays between a thousandth of a voxel from the target and a distance at which the
    // volume is a dot.
    const double least = 1e-3 * ground.finest_spacing, most = 1e4 * ground.radius;
    const double distance = distanceOf(view);
    factor = distance / std::clamp(distance / factor, least, most);
    next.look_at->eye = asArray(under + (vec(view.look_at->eye) - under) / factor);
    next.look_at->target = asArray(under + (target - under) / factor);
    return next;
  }
  next.zoom = std::clamp(view.zoom * factor, kLeastZoomByHand, kMostZoomByHand);
  // The point under the pointer stays where it is on the pane.
  return moved(next, (under - target) * (1 - view.zoom / next.zoom));
}

ViewOptions roll(const ViewOptions& view, double degrees) {
  const PlacedAxes axes = axesOf(view);
  ViewOptions next = view;
  next.up = asArray(rotated(axes.up, axes.back, degrees * kDegree));
  return next;
}

ViewOptions fly(const ViewOptions& view, double ahead, double right, double up,
                const Ground& ground) {
  const PlacedAxes axes = axesOf(view);
  return moved(view, (axes.right * right + axes.up * up - axes.back * ahead) * ground.radius);
}

ViewOptions lookAround(const ViewOptions& view, double dx, double dy, Pane pane) {
  const PlacedAxes axes = axesOf(view);
  // The pace is half of that of an orbit, since a turn of the eye moves the whole picture.
  const double across = -turnOf(dx, pane) / 2, down = -turnOf(dy, pane) / 2;
  const Vec3d tilted = rotated(axes.back, axes.right, down);
  ViewOptions next = view;
  next.look_at->target =
      asArray(vec(view.look_at->eye) - rotated(tilted, axes.up, across) * distanceOf(view));
  next.up = asArray(rotated(rotated(axes.up, axes.right, down), axes.up, across));
  return next;
}

ViewOptions centerOn(const ViewOptions& view, Vec3d world) {
  // A perspective eye stays as far from it as it was from the target.
  return moved(view, world - vec(view.look_at->target));
}

ViewOptions withProjection(const ViewOptions& view, ViewOptions::Projection projection, Pane pane,
                           const Ground& ground) {
  if (view.projection == projection) return view;
  const double half = worldPerPixel(view, pane, ground) * pane.height / 2;  // world, at the target
  ViewOptions next = view;
  next.projection = projection;
  // The target keeps its size on the pane. The zoom of one projection means nothing in the other,
  // so it becomes a distance, or the reverse.
  next.zoom = 1;
  const double unit = halfHeight(next, pane, ground);
  if (isPerspective(next)) {
    next.look_at->eye = asArray(vec(view.look_at->target) + axesOf(view).back * (half / unit));
  } else {
    next.zoom = std::clamp(unit / half, kLeastZoomByHand, kMostZoomByHand);
  }
  return next;
}

}  // namespace sluice
