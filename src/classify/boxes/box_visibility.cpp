#include "src/classify/boxes/box_visibility.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace sluice {
namespace {

// Squares of gradients are summed in single precision: in a volume of values as close as these they
// lose their digits.
constexpr double kLeastSpan = 1e-12;
// Rounding by sampling and summing, as a share of a magnitude and of the values behind it.
constexpr double kRounding = 1e-5;

// How far the axes are from right angles: the most by which a diagonal of their Gram matrix is
// outweighed (Gershgorin), so that |g|^2 lies between 1 - this and 1 + this of the sum of squares.
double skewOf(const VolumeLayout& layout) {
  double skew = 0;
  for (size_t a = 0; a < 3; ++a) {
    double sum = 0;
    for (size_t b = 0; b < 3; ++b)
      if (b != a) sum += std::abs(dot(layout.axes[a], layout.axes[b]));
    skew = std::max(skew, sum);
  }
  return skew;
}

}  // namespace

BoxVisibility::BoxVisibility(const OpacityTable& table, const VolumeLayout& layout)
    : table_(table) {
  // Bricks sum squares along the axes, which is the length of the gradient only if these are at
  // right angles. Slanted axes stretch it by this much at most.
  const double skew = skewOf(layout);
  least_stretch_ = std::sqrt(std::max(0.0, 1 - skew)) * (1 - kRounding);
  most_stretch_ = std::sqrt(1 + skew) * (1 + kRounding);
  const ValueRange all = table.volumeRange();
  knows_gradients_ = all.hi - all.lo > kLeastSpan;
}

bool BoxVisibility::shows(const CellRange& range) const {
  if (table_.magnitudes().empty()) return table_.shown().anyIn(range.lo, range.hi);
  // Next to a voxel that is no number an axis adds nothing to a gradient; its difference is beyond
  // all others here.
  const bool bounded = knows_gradients_ && range.gradient_hi < kLargest;
  if (!bounded)
    return table_.showsAny(range.lo, range.hi, 0, std::numeric_limits<double>::infinity());
  // Samples of equal voxels are equal, and their gradient is 0 exactly.
  if (range.gradient_hi == 0) return table_.showsAny(range.lo, range.hi, 0, 0);
  const double rounding =
      kRounding * std::max(std::abs(double{range.lo}), std::abs(double{range.hi}));
  return table_.showsAny(range.lo, range.hi,
                         std::max(0.0, range.gradient_lo * least_stretch_ - rounding),
                         range.gradient_hi * most_stretch_ + rounding);
}

}  // namespace sluice
