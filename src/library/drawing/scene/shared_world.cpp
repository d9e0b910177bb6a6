#include "src/library/drawing/scene/shared_world.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <utility>
#include <vector>

#include "io/files/length_unit.h"
#include "src/base/values/corners.h"
#include "src/render/camera/frame_setup.h"
#include "src/render/camera/index_space.h"

namespace sluice {
namespace {

// RAS and LPS differ in the signs of x and y. Nothing is known of other pairs.
bool areTurned(const VolumeLayout& a, const VolumeLayout& b) {
  return (a.frame == WorldFrame::kRas && b.frame == WorldFrame::kLps) ||
         (a.frame == WorldFrame::kLps && b.frame == WorldFrame::kRas);
}

// The outer voxels of the box.
std::array<Vec3d, 8> cornersOf(const Box3& box) {
  const Vec3i outer = box.hi - Vec3i{1, 1, 1};
  std::array<Vec3d, 8> corners;
  for (size_t i = 0; i < corners.size(); ++i)
    corners[i] = toDouble(cornerOf(box.lo, outer, static_cast<int>(i)));
  return corners;
}

// A position in the index space of `from`, in that of `to`.
Vec3d indexIn(const VolumeLayout& to, const VolumeLayout& from, Vec3d index) {
  return indexFromWorld(to, positionOn(to, from, worldFromIndex(from, index)));
}

// The voxels around the cells that a crop shows.
Box3 shownVoxels(const VolumeLayout& layout, const Box3& crop) {
  const Box3 cells = cropCells(crop, layout.dims);
  return cells.empty() ? crop : Box3{cells.lo, cells.hi + Vec3i{1, 1, 1}};
}

// The planes through the outer voxels of the crop.
std::vector<WorldPlane> sidesOf(const VolumeLayout& layout, const Box3& crop) {
  std::vector<WorldPlane> sides;
  for (int a = 0; a < 3; ++a) {
    const auto at = static_cast<size_t>(a);
    const Vec3d normal = normalized(cross(layout.axes[(at + 1) % 3], layout.axes[(at + 2) % 3]));
    const Vec3d outward = dot(normal, layout.axes[at]) > 0 ? normal : -normal;
    const Vec3d lo = worldFromIndex(layout, toDouble(crop.lo)),
                hi = worldFromIndex(layout, toDouble(crop.hi - Vec3i{1, 1, 1}));
    sides.push_back({outward, dot(outward, hi)});
    sides.push_back({-outward, -dot(outward, lo)});
  }
  return sides;
}

}  // namespace

bool isSamePlace(const VolumeLayout& a, const VolumeLayout& b) {
  return a.dims == b.dims && a.spacing == b.spacing && a.origin == b.origin && a.axes == b.axes &&
         a.frame == b.frame && worldScale(a, b) == 1;
}

bool isSameGrid(const VolumeLayout& a, const VolumeLayout& b) {
  if (a.dims != b.dims) return false;
  for (const Vec3d& corner : cornersOf(boxOf(a.dims))) {
    const Vec3d away = indexIn(b, a, corner) - corner;
    constexpr double kRounding = 1e-3;  // headers have single precision
    if (std::max({std::abs(away.x), std::abs(away.y), std::abs(away.z)}) > kRounding) return false;
  }
  return true;
}

double worldScale(const VolumeLayout& from, const VolumeLayout& to) {
  const auto unit = metersOf(from.unit), other = metersOf(to.unit);
  return unit && other ? *unit / *other : 1;
}

Vec3d directionOn(const VolumeLayout& to, const VolumeLayout& from, Vec3d world) {
  return areTurned(from, to) ? Vec3d{-world.x, -world.y, world.z} : world;
}

Vec3d positionOn(const VolumeLayout& to, const VolumeLayout& from, Vec3d world) {
  return directionOn(to, from, world) * worldScale(from, to);
}

Camera cameraOn(const VolumeLayout& to, const VolumeLayout& from, const Camera& camera,
                PictureSize size) {
  const View view = resolve(camera, from, size, 1);
  Camera placed = camera;
  // Resolved already, in the first volume's world.
  placed.framing.reset();
  const Vec3d eye = positionOn(to, from, view.eye);
  // Far enough away for the direction not to be rounded.
  const double ahead = std::max(length(eye), finestSpacing(to));
  placed.look_at = Camera::LookAt{eye, eye + directionOn(to, from, view.forward) * ahead};
  placed.up = directionOn(to, from, view.up);
  placed.zoom = 1;
  const double units = camera.projection == Projection::kOrtho ? worldScale(from, to) : 1;
  placed.zoom = resolve(placed, to, size, 1).half_height / (view.half_height * units);
  return placed;
}

std::optional<Box3> cropOn(const VolumeLayout& to, const VolumeLayout& from,
                           const std::optional<Box3>& crop) {
  // The same numbers, without rounding.
  if (!crop || isSameGrid(to, from)) return crop;
  const double far = std::numeric_limits<double>::infinity();
  // The box around the turned crop: its sides cut exactly, as planes (sidesOf()).
  Vec3d lo{far, far, far}, hi = -lo;
  for (const Vec3d& corner : cornersOf(shownVoxels(from, *crop))) {
    const Vec3d index = indexIn(to, from, corner);
    lo = min(lo, index);
    hi = max(hi, index);
  }
  // Sides that lie on a voxel plane are rounded to either side of it.
  constexpr double kRounding = 1e-6;
  Box3 box;
  for (int a = 0; a < 3; ++a) {
    const auto most = static_cast<double>(to.dims[a]);
    box.lo[a] = static_cast<int64_t>(std::floor(std::clamp(lo[a] + kRounding, 0.0, most)));
    box.hi[a] = static_cast<int64_t>(std::ceil(std::clamp(hi[a] - kRounding, -1.0, most - 1))) + 1;
  }
  // One plane of another grid is no plane of this crop.
  const Vec3i size = box.size();
  return std::min({size.x, size.y, size.z}) < 2 ? Box3{} : box;
}

double stepOn(const VolumeLayout& from, const VolumeLayout& to, double step_vox) {
  return step_vox * finestSpacing(to) / (finestSpacing(from) * worldScale(from, to));
}

FrameOptions frameOn(const VolumeLayout& to, const VolumeLayout& from, const FrameOptions& frame) {
  if (isSamePlace(to, from)) return frame;
  FrameOptions own = frame;
  own.camera = cameraOn(to, from, frame.camera, frame.size);
  // More than four samples a voxel add nothing, unless they are asked for.
  constexpr double kFinestStep = 0.25;
  own.step_vox = std::max(stepOn(to, from, frame.step_vox), std::min(frame.step_vox, kFinestStep));
  std::vector<WorldPlane> planes = frame.clip_planes;
  if (frame.crop)
    for (const WorldPlane& side : sidesOf(from, shownVoxels(from, *frame.crop)))
      planes.push_back(side);
  for (WorldPlane& plane : planes)
    plane = {directionOn(to, from, plane.normal), plane.offset * worldScale(from, to)};
  own.clip_planes = std::move(planes);
  own.crop = cropOn(to, from, frame.crop);
  // A number of a level means something else on another grid.
  if (own.cut) own.cut->level.reset();
  if (colorsByDepth(frame)) {
    const View view = resolve(frame, from);
    const auto [near, far] = shownDepths(view, from, frame);
    const double units = worldScale(from, to);
    own.shown_depths = std::array{near * units, far * units};
  }
  return own;
}

}  // namespace sluice
