#include "src/render/camera/camera_framing.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "src/base/error.h"
#include "src/render/camera/index_space.h"

namespace sluice {
namespace {

constexpr int kDirections = 256;
// The margin left free on either side, as a share of half the picture.
constexpr double kMargin = 0.06;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Evenly over the sphere: a spiral whose turns are the golden angle apart.
Vec3d direction(int i) {
  const double golden_angle = std::numbers::pi * (3 - std::sqrt(5.0));
  const double z = 1 - (2 * i + 1.0) / kDirections;
  const double radius = std::sqrt(1 - z * z), angle = golden_angle * i;
  return {radius * std::cos(angle), radius * std::sin(angle), z};
}

// A camera as far as fitting goes: its axes, and how wide and high its picture is relative to
// `reach`.
struct Lens {
  ViewAxes axes;
  bool perspective = false;
  // Extents of the part of the picture that the volume may fill.
  double tan_x = 1, tan_y = 1;  // ortho: width and height of the picture in units of its height

  // The position in the camera's axes.
  Vec3d seen(Vec3d world) const {
    return {dot(world, axes.right), dot(world, axes.up), dot(world, axes.back)};
  }
};

Lens lensOf(const Camera& camera, WorldFrame frame, PictureSize size, Room room) {
  Lens lens{axesOf(camera, frame)};
  lens.tan_x = size.aspect();
  lens.perspective = camera.projection == Projection::kPerspective;
  if (lens.perspective) {
    // The field of view applies to the shorter side, as in resolve().
    lens.tan_y = std::tan(camera.field_of_view_deg * std::numbers::pi / 360) *
                 std::max(1.0, static_cast<double>(size.height) / size.width);
    lens.tan_x *= lens.tan_y;
  }
  lens.tan_x *= (1 - room.right) * (1 - kMargin);
  lens.tan_y *= (1 - room.bottom) * (1 - kMargin);
  return lens;
}

struct Extent {
  Vec3d lo{kInfinity, kInfinity, kInfinity}, hi{-kInfinity, -kInfinity, -kInfinity};
  void add(Vec3d p) {
    lo = min(lo, p);
    hi = max(hi, p);
  }
  Vec3d middle() const { return (lo + hi) * 0.5; }
};

Vec3d middleOf(std::span<const Vec3d> points, const Lens& lens) {
  Extent extent;
  for (const Vec3d& point : points) extent.add(lens.seen(point));
  const Vec3d middle = extent.middle();
  return lens.axes.right * middle.x + lens.axes.up * middle.y + lens.axes.back * middle.z;
}

// The least Framing::reach that shows all points around the target.
double reachAround(std::span<const Vec3d> points, const Lens& lens, Vec3d target) {
  double reach = 0;
  for (const Vec3d& point : points) {
    const Vec3d p = lens.seen(point - target);
    // In perspective a point in front of the target needs its own depth, too.
    const double side = std::max(std::abs(p.x) / lens.tan_x, std::abs(p.y) / lens.tan_y);
    reach = std::max(reach, lens.perspective ? p.z + side : side);
  }
  return reach;
}

// How far to move along an axis of the picture so that the outermost points on either side lie as
// far from the middle: (a - s) / depth_a = -(b - s) / depth_b.
double offMiddle(const std::vector<Vec3d>& seen, int axis, double reach) {
  Vec3d first = seen.front(), last = seen.front();
  // A point at the eye has no depth: the bound keeps the quotient finite.
  const auto depth = [reach](Vec3d p) { return std::max(reach - p.z, 1e-9 * reach); };
  for (const Vec3d& p : seen) {
    if (p[axis] / depth(p) < first[axis] / depth(first)) first = p;
    if (p[axis] / depth(p) > last[axis] / depth(last)) last = p;
  }
  return (first[axis] * depth(last) + last[axis] * depth(first)) / (depth(first) + depth(last));
}

// In perspective, near points spread wider: moves the target until both sides are as free.
Vec3d centred(std::span<const Vec3d> points, const Lens& lens, Vec3d target) {
  constexpr int kRounds = 12;
  // Each round changes which points are outermost, so that it is repeated.
  for (int round = 0; lens.perspective && round < kRounds; ++round) {
    const double reach = reachAround(points, lens, target);
    std::vector<Vec3d> seen;
    for (const Vec3d& point : points) seen.push_back(lens.seen(point - target));
    target = target + lens.axes.right * offMiddle(seen, 0, reach) +
             lens.axes.up * offMiddle(seen, 1, reach);
  }
  return target;
}

}  // namespace

VisibleHull::VisibleHull(const VolumeLayout& layout) : layout_(layout) {
  for (int i = 0; i < kDirections; ++i) {
    const Vec3d world = direction(i);
    Vec3d along;
    for (int a = 0; a < 3; ++a)
      along[a] = dot(layout.axes[static_cast<size_t>(a)], world) * layout.spacing[a];
    farthest_.push_back({along, -kInfinity, {}});
  }
}

void VisibleHull::add(std::span<const Box3> boxes) {
  for (const Box3& cells : boxes)
    if (!cells.empty()) add(cells);
}

void VisibleHull::add(const Box3& cells) {
  any_ = true;
  // Cell i lies between voxels i and i + 1.
  const Vec3d lo = toDouble(cells.lo), hi = toDouble(cells.hi);
  for (Farthest& farthest : farthest_) {
    Vec3d corner;
    for (int a = 0; a < 3; ++a) corner[a] = farthest.along[a] > 0 ? hi[a] : lo[a];
    // The first of two corners that are equally far is kept, so that shared corners are listed
    // once.
    const double far = dot(corner, farthest.along);
    if (far <= farthest.far) continue;
    farthest.far = far;
    farthest.corner = corner;
  }
}

std::vector<Vec3d> VisibleHull::points() const {
  std::vector<Vec3d> points;
  if (!any_) return points;
  for (const Farthest& farthest : farthest_) {
    const Vec3d point = worldFromIndex(layout_, farthest.corner);
    if (std::find(points.begin(), points.end(), point) == points.end()) points.push_back(point);
  }
  return points;
}

std::optional<Framing> framingOf(std::span<const Vec3d> points, std::span<const Camera> cameras,
                                 WorldFrame frame, PictureSize size, Room room) {
  SLUICE_CHECK(room.right < 1 && room.bottom < 1);
  std::vector<Lens> lenses;
  std::optional<Lens> first;
  for (const Camera& camera : cameras) {
    // A camera that looks at a point frames itself.
    requireValid(camera, size);
    if (camera.look_at) continue;
    lenses.push_back(lensOf(camera, frame, size, room));
    if (!first) first = lenses.front();
    // Several cameras are framed about the up axis, wherever the first of them stands.
    if (lenses.size() == 2) first->axes = frontAxes(camera.view, frame, camera.up);
  }
  if (points.empty() || !first) return std::nullopt;
  Framing framing{middleOf(points, *first)};
  // Centring depends on the camera, and several cameras share one target.
  if (lenses.size() == 1) framing.target = centred(points, *first, framing.target);
  framing.right = -room.right;
  framing.up = room.bottom;
  framing.reach = 0;
  for (const Lens& lens : lenses)
    framing.reach = std::max(framing.reach, reachAround(points, lens, framing.target));
  // A single point has no extent to be framed.
  return framing.reach > 0 ? std::optional(framing) : std::nullopt;
}

}  // namespace sluice
