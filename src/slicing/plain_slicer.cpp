#include "src/slicing/plain_slicer.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "src/base/values/corners.h"

namespace sluice {
namespace {

struct Point {
  Vec3d position;
  double turn = 0;
};

// Grows with the angle of (x, y) from 0 to 4, without a transcendental function.
double turnOf(double x, double y) {
  const double sum = std::abs(x) + std::abs(y);
  if (!(sum > 0)) return 0;
  const double along = x / sum;
  return y < 0 ? 3 + along : 1 - along;
}

// Two directions in the plane, such that u, v turns counter-clockwise seen from the eye.
std::array<Vec3d, 2> basisOf(Vec3d normal) {
  const Vec3d n = normalized(normal);
  // An axis near the normal would leave a cross product too short to be normalized well.
  const Vec3d aside = std::abs(n.x) < 0.6 ? Vec3d{1, 0, 0} : Vec3d{0, 1, 0};
  const Vec3d u = normalized(cross(n, aside));
  return {u, cross(u, n)};
}

// The points of one slice; returns how many.
size_t cut(const SlicePlanes& planes, const SlicedBox& box, double depth,
           std::array<Point, 6>& points) {
  size_t count = 0;
  for (int axis = 0; axis < 3; ++axis)
    for (int corner = 0; corner < 8; ++corner) {
      if ((corner >> axis & 1) != 0) continue;
      const Vec3d from = cornerOf(box.lo, box.hi, corner),
                  to = cornerOf(box.lo, box.hi, corner | 1 << axis);
      const double d0 = planes.depthOf(from), d1 = planes.depthOf(to);
      // A corner on the slice counts as passed on all of its edges. Edges from a passed corner to
      // one that is not always close a polygon, though vertices of it may coincide.
      if ((d0 <= depth) == (d1 <= depth)) continue;
      Vec3d position = from;
      position[axis] += std::clamp((depth - d0) / (d1 - d0), 0.0, 1.0) * (to[axis] - from[axis]);
      points[count++] = {position, 0};
    }
  return count;
}

void sortAround(const std::array<Vec3d, 2>& basis, std::span<Point> points) {
  Vec3d middle;
  for (const Point& point : points) middle = middle + point.position;
  middle = middle / static_cast<double>(points.size());
  for (Point& point : points) {
    const Vec3d arm = point.position - middle;
    point.turn = turnOf(dot(arm, basis[0]), dot(arm, basis[1]));
  }
  // Six at most: an insertion sort is the fastest.
  for (size_t i = 1; i < points.size(); ++i)
    for (size_t j = i; j > 0 && points[j].turn < points[j - 1].turn; --j)
      std::swap(points[j], points[j - 1]);
}

void append(const SlicedBox& box, int64_t slice, std::span<const Point> points, SliceList& result) {
  result.polygons.push_back(
      {slice, static_cast<uint32_t>(result.vertices.size()), static_cast<uint32_t>(points.size())});
  for (const Point& point : points) {
    const Vec3d texture = point.position * box.texture_scale + box.texture_offset;
    SliceVertex vertex;
    for (int a = 0; a < 3; ++a) {
      vertex.position[static_cast<size_t>(a)] = static_cast<float>(point.position[a]);
      vertex.texture[static_cast<size_t>(a)] = static_cast<float>(texture[a]);
    }
    result.vertices.push_back(vertex);
  }
}

}  // namespace

void slicePlainly(const SlicePlanes& planes, std::span<const SlicedBox> boxes, SliceList& result) {
  const std::array<Vec3d, 2> basis = basisOf(planes.normal);
  // Nothing is carried over from box to box or from slice to slice: this is the measure that the
  // incremental slicer is tested against.
  for (const SlicedBox& box : boxes) {
    double nearest = planes.depthOf(box.lo), farthest = nearest;
    for (int corner = 1; corner < 8; ++corner) {
      const double depth = planes.depthOf(cornerOf(box.lo, box.hi, corner));
      nearest = std::min(nearest, depth);
      farthest = std::max(farthest, depth);
    }
    // Starts one slice before, in case the division rounds up.
    const auto before =
        static_cast<int64_t>(std::ceil((nearest - planes.first) / planes.step - 0.5)) - 1;
    for (int64_t k = std::max(planes.first_slice, before);; ++k) {
      // The depths are compared as cut() compares them, so that a slice that is kept has at least
      // three vertices.
      const double depth = planes.depthOfSlice(k);
      if (depth < nearest) continue;
      if (depth >= farthest) break;
      std::array<Point, 6> points;
      const std::span<Point> found(points.data(), cut(planes, box, depth, points));
      sortAround(basis, found);
      append(box, k, found, result);
    }
  }
}

}  // namespace sluice
