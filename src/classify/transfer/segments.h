// Segments of a transfer function's lists of points: the two points around a value.
//
// SegmentCursor finds those of many values in a row, which is a search for each new segment instead
// of one for each value. Pure functions of the points, which must outlive the cursor.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "src/base/error.h"
#include "src/classify/transfer/transfer_function.h"

namespace sluice {

// The two points around a value and the way from the first to the second, 0..1; `t` is 0 at a
// point, so that points are met exactly, and beyond the ends both are the end.
template <class Point>
struct Segment {
  const Point& a;
  const Point& b;
  double t;
};

// Requires: points ascend by value, `above` is the first whose value is greater.
template <class Point>
Segment<Point> segmentBelow(const std::vector<Point>& points, size_t above, double value) {
  if (above == 0) return {points.front(), points.front(), 0};
  const Point& a = points[above - 1];
  if (above == points.size()) return {a, a, 0};
  const Point& b = points[above];
  const double distance = b.value - a.value;
  // The distance of two finite values may overflow; that of their halves does not.
  const double t = std::isfinite(distance)
                       ? (value - a.value) / distance
                       : (value / 2 - a.value / 2) / (b.value / 2 - a.value / 2);
  return {a, b, std::clamp(t, 0.0, 1.0)};
}

// The first point above the value: the one before it is the last of several at one value, which is
// the side of a step that holds at the step itself.
template <class Point>
size_t firstAbove(const std::vector<Point>& points, double value) {
  const auto above = std::upper_bound(points.begin(), points.end(), value,
                                      [](double v, const Point& point) { return v < point.value; });
  return static_cast<size_t>(above - points.begin());
}

// Requires: points is not empty and ascends by value.
template <class Point>
Segment<Point> segmentAt(const std::vector<Point>& points, double value) {
  SLUICE_CHECK(!points.empty());
  return segmentBelow(points, firstAbove(points, value), value);
}

// segmentAt() for values in any order, quick if most lie in the segment of the one before.
template <class Point>
class SegmentCursor {
 public:
  explicit SegmentCursor(const std::vector<Point>& points) : points_(points) {
    SLUICE_CHECK(!points.empty());
  }
  Segment<Point> at(double value) {
    const bool is_below = above_ == points_.size() || value < points_[above_].value;
    const bool is_above = above_ == 0 || points_[above_ - 1].value <= value;
    if (!is_below || !is_above) above_ = firstAbove(points_, value);
    return segmentBelow(points_, above_, value);
  }

 private:
  const std::vector<Point>& points_;
  size_t above_ = 0;
};

inline Vec3d colorIn(const Segment<ColorPoint>& segment) {
  const auto& [a, b, t] = segment;
  return {std::lerp(a.rgb.x, b.rgb.x, t), std::lerp(a.rgb.y, b.rgb.y, t),
          std::lerp(a.rgb.z, b.rgb.z, t)};
}
inline double opacityIn(const Segment<OpacityPoint>& segment) {
  return std::lerp(segment.a.opacity, segment.b.opacity, segment.t);
}

}  // namespace sluice
