#include "tests/support/reference_surfaces.h"

#include <algorithm>
#include <cmath>

namespace sluice {
namespace {

// Values this share of the range apart are one, for numbers of double and of single precision.
constexpr double kSame = 1e-9, kSameInSingle = 1.0 / (1 << 14);

}  // namespace

ReferenceHits surfaceHits(const std::vector<IsoSurface>& surfaces, double range,
                          const std::function<double(double part)>& value_at) {
  const double front = value_at(0), back = value_at(1);
  ReferenceHits result;
  if (std::isnan(front) || std::isnan(back)) return result;
  std::vector<const IsoSurface*> order;
  for (const IsoSurface& surface : surfaces) order.push_back(&surface);
  std::sort(order.begin(), order.end(), [&](const IsoSurface* a, const IsoSurface* b) {
    return back > front ? a->value < b->value : a->value > b->value;
  });
  double from = 0;
  for (const IsoSurface* surface : order) {
    const double level = surface->value - kSame * range;
    if (std::min(std::abs(front - level), std::abs(back - level)) < kSameInSingle * range)
      result.doubt = std::max(result.doubt, surface->opacity);
    if ((front >= level) == (back >= level)) continue;
    double lo = from, hi = 1;
    for (int i = 0; i < 50; ++i) {
      const double middle = (lo + hi) / 2;
      ((value_at(middle) >= level) == (front >= level) ? lo : hi) = middle;
    }
    result.hits.push_back({lo, surface});
    from = lo;
  }
  return result;
}

}  // namespace sluice
