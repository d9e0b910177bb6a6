#include "src/classify/transfer/transfer_function.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "src/base/error.h"

namespace sluice {
namespace {

// The two points around a value and the way from the first to the second, 0..1; `t` is 0 at a
// point, so that points are met exactly, and beyond the ends both are the end.
template <class Point>
struct Segment {
  const Point& a;
  const Point& b;
  double t;
};

template <class Point>
Segment<Point> segmentAt(const std::vector<Point>& points, double value) {
  SLUICE_CHECK(!points.empty());
  // The first point above the value: the one before it is the last of several at one value, which
  // is the side of a step that holds at the step itself.
  const auto above = std::upper_bound(points.begin(), points.end(), value,
                                      [](double v, const Point& point) { return v < point.value; });
  if (above == points.begin()) return {points.front(), points.front(), 0};
  const Point& a = *(above - 1);
  if (above == points.end()) return {a, a, 0};
  const Point& b = *above;
  const double distance = b.value - a.value;
  // The distance of two finite values may overflow; that of their halves does not.
  const double t = std::isfinite(distance)
                       ? (value - a.value) / distance
                       : (value / 2 - a.value / 2) / (b.value / 2 - a.value / 2);
  return {a, b, std::clamp(t, 0.0, 1.0)};
}

bool inUnit(double x) {
  return x >= 0 && x <= 1;  // false for NaN
}

// `list` names the list in messages.
template <class Point>
void validateValues(const std::vector<Point>& points, const std::string& list,
                    const std::string& where) {
  if (points.empty()) {
    fail("{}: expected at least one point in {}, found none", where, list);
  }
  for (size_t i = 0; i < points.size(); ++i) {
    if (!std::isfinite(points[i].value)) {
      fail("{}: expected a finite value in {}[{}], found {}", where, list, i, points[i].value);
    }
    if (i > 0 && points[i].value < points[i - 1].value) {
      fail("{}: expected {} to ascend by value, found {} after {} at [{}]", where, list,
           points[i].value, points[i - 1].value, i);
    }
  }
}

void validateOpacities(const std::vector<OpacityPoint>& points, const std::string& list,
                       const std::string& where) {
  validateValues(points, list, where);
  for (size_t i = 0; i < points.size(); ++i) {
    if (!inUnit(points[i].opacity)) {
      fail("{}: expected an opacity in 0..1 in {}[{}], found {}", where, list, i,
           points[i].opacity);
    }
  }
}

void validateGradients(const std::vector<GradientRow>& rows, const std::string& where) {
  if (rows.size() > kMostGradientRows) {
    fail("{}: expected at most {} gradient magnitudes, found {}", where, kMostGradientRows,
         rows.size());
  }
  for (size_t i = 0; i < rows.size(); ++i) {
    const double magnitude = rows[i].magnitude;
    if (!std::isfinite(magnitude) || magnitude < 0) {
      fail("{}: expected a magnitude of 0 or more in gradients[{}], found {}", where, i, magnitude);
    }
    if (i > 0 && magnitude <= rows[i - 1].magnitude) {
      fail("{}: expected gradients to ascend by magnitude, found {} after {} at [{}]", where,
           magnitude, rows[i - 1].magnitude, i);
    }
    validateOpacities(rows[i].factors, fmt::format("gradients[{}]", i), where);
  }
}

}  // namespace

Vec3d colorAt(const TransferFunction& transfer, double value) {
  SLUICE_CHECK(!transfer.colors.empty());
  if (std::isnan(value)) return transfer.colors.front().rgb;
  const auto [a, b, t] = segmentAt(transfer.colors, value);
  return {std::lerp(a.rgb.x, b.rgb.x, t), std::lerp(a.rgb.y, b.rgb.y, t),
          std::lerp(a.rgb.z, b.rgb.z, t)};
}

double opacityAt(const TransferFunction& transfer, double value) {
  if (std::isnan(value)) return 0;
  const auto [a, b, t] = segmentAt(transfer.opacities, value);
  return std::lerp(a.opacity, b.opacity, t);
}

double gradientFactorAt(const GradientRow& row, double value) {
  if (std::isnan(value)) return 0;
  const auto [a, b, t] = segmentAt(row.factors, value);
  return std::lerp(a.opacity, b.opacity, t);
}

double gradientFactorAt(const TransferFunction& transfer, double value, double magnitude) {
  const std::vector<GradientRow>& rows = transfer.gradients;
  if (rows.empty()) return 1;
  const auto above =
      std::upper_bound(rows.begin(), rows.end(), magnitude,
                       [](double m, const GradientRow& row) { return m < row.magnitude; });
  if (above == rows.begin()) return gradientFactorAt(rows.front(), value);
  if (above == rows.end()) return gradientFactorAt(rows.back(), value);
  const GradientRow& below = *(above - 1);
  const double t = (magnitude - below.magnitude) / (above->magnitude - below.magnitude);
  return std::lerp(gradientFactorAt(below, value), gradientFactorAt(*above, value), t);
}

void validate(const TransferFunction& transfer, const std::string& where) {
  validateValues(transfer.colors, "colors", where);
  for (size_t i = 0; i < transfer.colors.size(); ++i) {
    const Vec3d& rgb = transfer.colors[i].rgb;
    if (!inUnit(rgb.x) || !inUnit(rgb.y) || !inUnit(rgb.z)) {
      fail("{}: expected red, green and blue in 0..1 in colors[{}], found {}, {}, {}", where, i,
           rgb.x, rgb.y, rgb.z);
    }
  }
  validateOpacities(transfer.opacities, "opacities", where);
  validateGradients(transfer.gradients, where);
}

}  // namespace sluice
