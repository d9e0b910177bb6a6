#include "src/library/drawing/empty_picture.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "src/device/pictures/screen_picture.h"
#include "src/library/drawing/view_fit.h"
#include "src/library/opening/step_ranges.h"
#include "src/render/camera/camera_framing.h"

namespace sluice {
namespace {

bool hasNoOpacity(const TransferFunction& transfer) {
  return std::all_of(transfer.opacities.begin(), transfer.opacities.end(),
                     [](const OpacityPoint& point) { return point.opacity == 0; }) &&
         std::ranges::all_of(transfer.surfaces,
                             [](const IsoSurface& surface) { return surface.opacity == 0; });
}

// Whether all points lie beyond one and the same side of the picture, or behind the eye.
bool isBesidePicture(const std::vector<Vec3d>& points, const View& view) {
  const double aspect = view.size.aspect();
  const bool perspective = view.projection == Projection::kPerspective;
  bool left = true, right = true, above = true, below = true, behind = perspective;
  for (const Vec3d& point : points) {
    const Vec3d p = point - view.eye;
    // The picture's edges open with the depth in perspective, and are parallel in an orthographic
    // view.
    const double depth = perspective ? dot(p, view.forward) : 1;
    const double x = dot(p, view.right), y = dot(p, view.up);
    const double half_height = view.half_height * depth;
    left = left && x < -half_height * aspect;
    right = right && x > half_height * aspect;
    above = above && y > half_height;
    below = below && y < -half_height;
    behind = behind && depth <= 0;
  }
  return left || right || above || below || behind;
}

bool isClipped(const std::vector<Vec3d>& points, const WorldPlane& plane) {
  return std::all_of(points.begin(), points.end(),
                     [&](const Vec3d& point) { return dot(plane.normal, point) > plane.offset; });
}

// The range of the values: "0 to 255".
std::string valuesOf(const SliceRanges& ranges) {
  const double a = ranges.map.valueOf(ranges.device_range.lo);
  const double b = ranges.map.valueOf(ranges.device_range.hi);
  return fmt::format("{:.6g} to {:.6g}", std::min(a, b), std::max(a, b));
}

}  // namespace

bool showsNothing(const Picture& picture) {
  for (size_t i = 3; i < picture.rgba.size(); i += 4)
    if (picture.rgba[i] >= kLeastOpacity) return false;
  return !picture.rgba.empty();
}

std::string whyEmpty(const DrawnPicture& drawn, const IndexPass& pass) {
  const FrameOptions& options = drawn.options;
  const VolumeLayout& layout = drawn.volume.source->layout();
  const Vec3i dims = layout.dims;
  const Box3 all = boxOf(dims - Vec3i{1, 1, 1}), crop = cropCells(options, dims);
  // The order is from the causes that take no reading to those that need the step's values, and
  // from the general to the particular: the first one that applies is what the user has to change.
  if (drawn.missing_share > 0) return "nothing of it was read within the time limit";
  if (crop.empty())
    return fmt::format("the crop box lies outside of the volume's {} x {} x {} voxels", dims.x,
                       dims.y, dims.z);
  if (hasNoOpacity(drawn.transfer)) return "the transfer function has opacity 0 everywhere";
  // The values of the step are needed from here on; they may be read from its index.
  const StepValues values = valuesOfStep(drawn.volume, drawn.time, pass);
  if (!values.index->ranges.mayHoldNumbers()) return "no voxel is a finite number";
  const auto cellsIn = [&](const Box3& box) {
    return shownCells(drawn.volume, values, drawn.transfer, box);
  };
  if (cellsIn(all).empty())
    return fmt::format("the transfer function gives all values of the volume, {}, opacity 0",
                       valuesOf(values.index->ranges));
  const std::vector<Box3> cells = cellsIn(crop);
  if (cells.empty()) return "the transfer function gives all values inside the crop box opacity 0";
  VisibleHull hull(layout);
  hull.add(cells);
  const std::vector<Vec3d> points = hull.points();
  if (isBesidePicture(points, resolve(options, layout)))
    return "the camera looks past the visible part of the volume";
  for (const WorldPlane& plane : options.clip_planes) {
    if (!isClipped(points, plane)) continue;
    // Planes of a volume over another one are not those that its user gave.
    if (drawn.volume.channel.is_over)
      return "a clip plane or the crop box takes away all that is visible";
    return fmt::format("the clip plane {},{},{},{} takes away all that is visible", plane.normal.x,
                       plane.normal.y, plane.normal.z, plane.offset);
  }
  if (!drawn.transfer.gradients.empty() && traitsOf(options.mode).has_colors)
    return "the opacities by gradient hide everything that the opacities by value show";
  return "the visible part is too transparent or too small to change a pixel";
}

}  // namespace sluice
