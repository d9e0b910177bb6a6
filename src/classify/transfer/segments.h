// Segments of a transfer function's lists of points: the two points around a value.
//
// Tables need those of many values in a row: eachRun() finds each segment once, and the loops over
// its values can be vectorized. Pure functions.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>
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

// Values that one segment holds: those from `first` to before `end` lie between points a and b.
template <class Point>
struct SegmentRun {
  const Point& a;
  const Point& b;
  size_t first, end;
  // The run's part of a list of numbers, one a value.
  std::span<double> of(std::span<double> all) const { return all.subspan(first, end - first); }
};

// Calls `body` with a SegmentRun for each run of `values` in one segment. Requires: `values` ascend
// or descend, points is not empty.
template <class Point, class Body>
void eachRun(const std::vector<Point>& points, std::span<const double> values, const Body& body) {
  SLUICE_CHECK(!points.empty());
  for (size_t first = 0; first < values.size();) {
    const size_t above = firstAbove(points, values[first]);
    const auto is_in = [&](double value) {
      return (above == points.size() || value < points[above].value) &&
             (above == 0 || points[above - 1].value <= value);
    };
    const auto end = static_cast<size_t>(
        std::partition_point(values.begin() + static_cast<ptrdiff_t>(first), values.end(), is_in) -
        values.begin());
    const Point& a = points[above == 0 ? 0 : above - 1];
    body(SegmentRun<Point>{a, above == points.size() ? a : points[above], first, end});
    first = end;
  }
}

// The ways of a run's values from its first point to its second, as Segment has them.
template <class Point>
void waysOf(const SegmentRun<Point>& run, std::span<const double> values, std::span<double> ways) {
  const bool is_point = &run.a == &run.b;
  // Halves do not overflow.
  const double unit = std::isfinite(run.b.value - run.a.value) ? 1 : 2;
  const double from = run.a.value / unit, distance = is_point ? 1 : run.b.value / unit - from;
  const double* const in = values.data();
  double* const out = ways.data();
  for (size_t i = run.first; i < run.end; ++i) {
    const double way = is_point ? 0 : (in[i] / unit - from) / distance;
    out[i] = way < 0 ? 0 : way > 1 ? 1 : way;
  }
}

// out[i] = std::lerp(a, b, ways[i]) to the last bit, in a loop that can be vectorized. Requires:
// ways 0..1, spans of one length that do not overlap.
inline void lerpRun(double a, double b, std::span<const double> ways, std::span<double> out) {
  const double* const in = ways.data();
  double* const to = out.data();
  if ((a <= 0 && b >= 0) || (a >= 0 && b <= 0)) {
    for (size_t i = 0; i < ways.size(); ++i) to[i] = in[i] * b + (1 - in[i]) * a;
    return;
  }
  // Rounding must not lead beyond the ends.
  const double lo = std::min(a, b), hi = std::max(a, b);
  for (size_t i = 0; i < ways.size(); ++i) {
    double part = a + in[i] * (b - a);
    part = part < lo ? lo : part;
    part = part > hi ? hi : part;
    to[i] = in[i] == 1 ? b : part;
  }
}

inline Vec3d colorIn(const Segment<ColorPoint>& segment) {
  const auto& [a, b, t] = segment;
  return {std::lerp(a.rgb.x, b.rgb.x, t), std::lerp(a.rgb.y, b.rgb.y, t),
          std::lerp(a.rgb.z, b.rgb.z, t)};
}
inline double opacityIn(const Segment<OpacityPoint>& segment) {
  return std::lerp(segment.a.opacity, segment.b.opacity, segment.t);
}

}  // namespace sluice
