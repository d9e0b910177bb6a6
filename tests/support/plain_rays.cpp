#include "tests/support/plain_rays.h"

#include <algorithm>
#include <cmath>

#include "src/device/pictures/blue_noise.h"

namespace sluice {
namespace {

// The product of a row of clip space and a position.
double along(const std::array<double, 4>& row, Vec3d p) {
  return row[0] * p.x + row[1] * p.y + row[2] * p.z + row[3];
}

double safe(double step) {
  return std::abs(step) < 1e-12 ? 1e-12 : step;
}

// The distances t at which the ray, origin + t * step, enters and leaves what is shown, see
// FrameSetup; if it misses, the first is the greater.
std::array<double, 2> wayThroughShown(const PlainRay& ray, const FrameSetup& setup) {
  double enter = setup.first_slice > 0 ? static_cast<double>(setup.first_slice) + 0.5 : -1e15;
  double leave = 1e15;
  for (int a = 0; a < 3; ++a) {
    const double lo = static_cast<double>(setup.shown.lo[a]) - kPlaneEdge;
    const double hi = static_cast<double>(setup.shown.hi[a]) + kPlaneEdge;
    const double at_lo = (lo - ray.origin[a]) / safe(ray.step[a]);
    const double at_hi = (hi - ray.origin[a]) / safe(ray.step[a]);
    enter = std::max(enter, std::min(at_lo, at_hi));
    leave = std::min(leave, std::max(at_lo, at_hi));
  }
  for (const ClipPlane& plane : setup.clip_planes) {
    const double s = dot(plane.normal, ray.step);
    const double t = (plane.offset - dot(plane.normal, ray.origin)) / safe(s);
    if (s < 0)
      enter = std::max(enter, t);
    else
      leave = std::min(leave, t);
  }
  return {enter, leave};
}

}  // namespace

int clampedInt(double v) {
  return static_cast<int>(std::clamp(v, -1e9, 1e9));
}

PlainRay plainRayOf(const FrameSetup& setup, int x, int y) {
  const RayGrid& rays = setup.rays;
  const double px = x + 0.5, py = y + 0.5;
  PlainRay ray{rays.origin0 + rays.origin_dx * px + rays.origin_dy * py,
               rays.step0 + rays.step_dx * px + rays.step_dy * py};
  ray.jitter = setup.jitter * double{blueNoise()[static_cast<size_t>(
                                  y % kBlueNoiseSide * kBlueNoiseSide + x % kBlueNoiseSide)]};
  ray.origin = ray.origin + ray.step * ray.jitter;
  if (setup.projection == Projection::kPerspective)
    ray.length = length(Vec3d{(2 * px / setup.size.width - 1) * setup.tan_half_x,
                              (2 * py / setup.size.height - 1) * setup.tan_half_y, 1});
  return ray;
}

std::array<int64_t, 2> slicesIn(const PlainRay& ray, const Box3& cells, const FrameSetup& setup) {
  double from = static_cast<double>(setup.first_slice), to = 1e15;
  for (int a = 0; a < 3; ++a) {
    const double s = safe(ray.step[a]);
    // The first slice at or past a face seen from before it: the boxes on both sides compute the
    // same.
    const auto sliceAt = [&](int64_t face) {
      const double t = (static_cast<double>(face) - ray.origin[a]) / s - 0.5;
      return s > 0 ? std::ceil(t) : std::floor(t) + 1;
    };
    const double lo = sliceAt(cells.lo[a]), hi = sliceAt(cells.hi[a]);
    from = std::max(from, std::min(lo, hi));
    to = std::min(to, std::max(lo, hi));
  }
  for (const ClipPlane& plane : setup.clip_planes) {
    const double s = dot(plane.normal, ray.step);
    const double t = (plane.offset - dot(plane.normal, ray.origin)) / safe(s) - 0.5;
    if (s < 0)
      from = std::max(from, std::ceil(t));
    else
      to = std::min(to, std::floor(t) + 1);
  }
  if (!(from < to)) return {0, 0};
  return {static_cast<int64_t>(from), static_cast<int64_t>(to)};
}

void eachSample(const PlainRay& ray, const BoxDraw& box, const FrameSetup& setup,
                const std::function<bool(Vec3d position, double slice)>& visit) {
  const Box3& cells = box.cells;
  if (!traitsOf(setup.mode).on_planes) {
    const auto [from, to] = slicesIn(ray, cells, setup);
    for (int64_t k = from; k < to; ++k)
      if (const auto slice = static_cast<double>(k); !visit(ray.at(slice), slice)) return;
    return;
  }
  int main = 0;
  for (int a = 1; a < 3; ++a)
    if (std::abs(ray.step[a]) > (1 + kAxisTie) * std::abs(ray.step[main])) main = a;
  const auto [enter, leave] = wayThroughShown(ray, setup);
  if (enter > leave) return;
  // Places on the main axis: whole numbers are those that are sampled between the two ends.
  size_t texel_axis = 0;
  while (box.texels.axes[texel_axis] != main) ++texel_axis;
  const double scale = box.texels.scale[static_cast<int>(texel_axis)];
  const double offset = box.texels.offset[static_cast<int>(texel_axis)];
  const double parts = setup.planes_a_voxel, margin = endMargin(setup.planes_a_voxel);
  const auto placeOf = [&](double t) {
    return ((ray.origin[main] + ray.step[main] * t) * scale + offset) * parts;
  };
  const double lowest = std::min(placeOf(enter), placeOf(leave));
  const double highest = std::max(placeOf(enter), placeOf(leave));
  const auto from = static_cast<int64_t>(std::floor(lowest + margin));
  const auto to = static_cast<int64_t>(std::ceil(highest - margin));
  for (int64_t i = from; i <= to; ++i) {
    const double place = std::clamp(static_cast<double>(i), lowest, highest) / parts;
    const double t = ((place - offset) / scale - ray.origin[main]) / ray.step[main];
    Vec3d p = ray.origin + ray.step * t;
    bool counts = true;
    for (int a = 0; a < 3; ++a) {
      constexpr double kEdge = kPlaneEdge + 1e-9;  // the ends lie on it
      const auto lo = static_cast<double>(cells.lo[a]), hi = static_cast<double>(cells.hi[a]);
      counts = counts && p[a] >= lo - kEdge && p[a] <= hi + kEdge;
      p[a] = std::clamp(p[a], lo, hi);
    }
    if (counts && !visit(p, t - 0.5)) return;
  }
}

void eachPixelOf(const Box3& cells, const FrameSetup& setup,
                 const std::function<void(int x, int y)>& visit) {
  const auto [width, height] = setup.size;
  double x0 = 1e9, y0 = 1e9, x1 = -1e9, y1 = -1e9;
  for (int corner = 0; corner < 8; ++corner) {
    Vec3d p;
    for (int a = 0; a < 3; ++a)
      p[a] = static_cast<double>((corner >> a & 1) != 0 ? cells.hi[a] : cells.lo[a]);
    const double w = along(setup.clip_from_index[2], p);
    if (w <= 0) {  // next to the eye: may project anywhere
      x0 = y0 = -1e9;
      x1 = y1 = 1e9;
      break;
    }
    const double x = (along(setup.clip_from_index[0], p) / w + 1) / 2 * width;
    const double y = (along(setup.clip_from_index[1], p) / w + 1) / 2 * height;
    x0 = std::min(x0, x), x1 = std::max(x1, x);
    y0 = std::min(y0, y), y1 = std::max(y1, y);
  }
  for (int y = std::max(0, clampedInt(y0) - 2); y < std::min(height, clampedInt(y1) + 3); ++y)
    for (int x = std::max(0, clampedInt(x0) - 2); x < std::min(width, clampedInt(x1) + 3); ++x)
      visit(x, y);
}

}  // namespace sluice
