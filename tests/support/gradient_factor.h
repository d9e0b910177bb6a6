// The gradient's part of a transfer function at one place, for references: devices interpolate it
// between the rows themselves.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "src/classify/transfer/transfer_function.h"

namespace sluice {

// The share of the opacity that remains at a gradient magnitude: 1 without rows.
inline double gradientFactorAt(const TransferFunction& transfer, double value, double magnitude) {
  const std::vector<GradientRow>& rows = transfer.gradients;
  // Without rows the opacity holds at any magnitude.
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

}  // namespace sluice
