#include "src/classify/transfer/transfer_function.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "src/base/error.h"
#include "src/classify/transfer/segments.h"

namespace sluice {
namespace {

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
    // Equal values are a step, so that they may follow each other.
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
  // NaN has no place among the points: it shows nothing, in any colour.
  if (std::isnan(value)) return transfer.colors.front().rgb;
  return colorIn(segmentAt(transfer.colors, value));
}

double opacityAt(const TransferFunction& transfer, double value) {
  if (std::isnan(value)) return 0;
  return opacityIn(segmentAt(transfer.opacities, value));
}

double gradientFactorAt(const GradientRow& row, double value) {
  if (std::isnan(value)) return 0;
  return opacityIn(segmentAt(row.factors, value));
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
