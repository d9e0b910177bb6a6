#include "tests/support/reference_rays.h"

#include <algorithm>
#include <vector>

#include "tests/support/clipped_points.h"

namespace sluice {
namespace {

// The corners of the box through the outermost of these voxels.
std::vector<Vec3d> cornersOf(const VolumeLayout& layout, const Box3& voxels) {
  std::vector<Vec3d> corners;
  for (int corner = 0; corner < 8; ++corner) {
    Vec3d world = layout.origin;
    for (int a = 0; a < 3; ++a) {
      const int64_t voxel = (corner >> a & 1) != 0 ? voxels.hi[a] - 1 : voxels.lo[a];
      world = world + layout.axes[static_cast<size_t>(a)] *
                          (layout.spacing[a] * static_cast<double>(voxel));
    }
    corners.push_back(world);
  }
  return corners;
}

// The depths of the nearest of these points and of the farthest.
std::array<double, 2> depthsOf(const View& view, const std::vector<Vec3d>& points) {
  std::array<double, 2> depths{std::numeric_limits<double>::infinity(),
                               -std::numeric_limits<double>::infinity()};
  for (const Vec3d& world : points) {
    const double depth = dot(world - view.eye, view.forward);
    depths = {std::min(depths[0], depth), std::max(depths[1], depth)};
  }
  return depths;
}

// The inverse of VolumeLayout's map, which may be oblique.
std::array<Vec3d, 3> rowsOf(const VolumeLayout& layout) {
  const std::array<Vec3d, 3> e = {layout.axes[0] * layout.spacing.x,
                                  layout.axes[1] * layout.spacing.y,
                                  layout.axes[2] * layout.spacing.z};
  const double determinant = dot(e[0], cross(e[1], e[2]));
  return {cross(e[1], e[2]) / determinant, cross(e[2], e[0]) / determinant,
          cross(e[0], e[1]) / determinant};
}

}  // namespace

ReferenceRays::ReferenceRays(const VolumeLayout& layout, const View& view,
                             const ReferenceScene& scene)
    : layout_(layout),
      view_(view),
      scene_(scene),
      rows_(rowsOf(layout)),
      crop_(scene.crop ? intersect(*scene.crop, boxOf(layout.dims)) : boxOf(layout.dims)),
      finest_(std::min({layout.spacing.x, layout.spacing.y, layout.spacing.z})),
      last_depth_(depthsOf(view, cornersOf(layout, boxOf(layout.dims)))[1]) {}

ReferenceRays::Ray ReferenceRays::through(int i, int j) const {
  const double u = 2 * (i + 0.5) / view_.size.width - 1;
  const double v = 1 - 2 * (j + 0.5) / view_.size.height;
  const double aspect = static_cast<double>(view_.size.width) / view_.size.height;
  const Vec3d aside =
      view_.right * (u * aspect * view_.half_height) + view_.up * (v * view_.half_height);
  const bool ortho = view_.projection == Projection::kOrtho;
  const Vec3d start = ortho ? view_.eye + aside : view_.eye;
  const Vec3d direction = ortho ? view_.forward : view_.forward + aside;
  return {start, direction};
}

Vec3d ReferenceRays::indexOf(Vec3d world) const {
  const Vec3d d = world - layout_.origin;
  return {dot(rows_[0], d), dot(rows_[1], d), dot(rows_[2], d)};
}

std::array<double, 2> ReferenceRays::shownDepths() const {
  const std::vector<Vec3d> whole = cornersOf(layout_, crop_);
  const std::vector<Vec3d> left = clippedPoints(whole, scene_.clip_planes);
  auto depths = depthsOf(view_, left.empty() ? whole : left);
  if (!scene_.shown_points.empty()) {
    const auto shown = depthsOf(view_, scene_.shown_points);
    depths = {std::max(depths[0], shown[0]), std::min(depths[1], shown[1])};
  }
  if (view_.projection == Projection::kPerspective) depths[0] = std::max(depths[0], 0.0);
  return depths;
}

// The depth of the first slice, or of the first in front of a perspective eye inside the volume.
double ReferenceRays::nearestDepth() const {
  if (view_.projection == Projection::kOrtho || view_.first_depth > 0)
    return -std::numeric_limits<double>::infinity();
  int64_t k = 0;
  while (view_.first_depth + (static_cast<double>(k) + 0.5) * view_.step <= 0) ++k;
  return view_.first_depth + (static_cast<double>(k) + 0.5) * view_.step;
}

bool ReferenceRays::counts(Vec3d p, Vec3d world, double grown_vox) const {
  for (int a = 0; a < 3; ++a)
    if (!(p[a] >= static_cast<double>(crop_.lo[a]) - grown_vox &&
          p[a] < static_cast<double>(crop_.hi[a] - 1) + grown_vox))
      return false;
  return std::all_of(scene_.clip_planes.begin(), scene_.clip_planes.end(), [&](const auto& plane) {
    return dot(plane.normal, world) <= plane.offset + grown_vox * finest_ * length(plane.normal);
  });
}

}  // namespace sluice
