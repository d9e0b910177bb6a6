#include "src/render/light/light_sweep.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "src/base/error.h"

namespace sluice {
namespace {

// A plane of texels with a rim of all light around it.
class Plane {
 public:
  // The rim spares the loop the question whether a neighbour exists, and lets light in from the
  // sides.
  Plane(int64_t across, int64_t up)
      : stride_(across + 2), numbers_(static_cast<size_t>((across + 2) * (up + 2)), 1.0F) {}
  float& at(int64_t i, int64_t j) {
    return numbers_[static_cast<size_t>((j + 1) * stride_ + i + 1)];
  }
  const float* row(int64_t j) const {
    return &numbers_[static_cast<size_t>((j + 1) * stride_ + 1)];
  }

 private:
  int64_t stride_;
  std::vector<float> numbers_;
};

// The way from a texel to the last plane: its whole part, -1 or 0, and weights of the four texels.
struct Shift {
  Shift(double right, double up) {
    const double i = std::floor(right), j = std::floor(up);
    // A way of exactly one texel has no part of the one after.
    whole_i = static_cast<int64_t>(std::min(i, 0.0));
    whole_j = static_cast<int64_t>(std::min(j, 0.0));
    const double x = right - static_cast<double>(whole_i), y = up - static_cast<double>(whole_j);
    weights = {static_cast<float>((1 - x) * (1 - y)), static_cast<float>(x * (1 - y)),
               static_cast<float>((1 - x) * y), static_cast<float>(x * y)};
  }
  float of(const Plane& plane, int64_t i, int64_t j) const {
    const float* lower = plane.row(j + whole_j) + i + whole_i;
    const float* upper = plane.row(j + whole_j + 1) + i + whole_i;
    return weights[0] * lower[0] + weights[1] * lower[1] + weights[2] * upper[0] +
           weights[3] * upper[1];
  }

  int64_t whole_i = 0, whole_j = 0;
  std::array<float, 4> weights{};
};

}  // namespace

void addLight(const CoarseExtinction& matter, const Sweep& sweep, float weight, WorkerPool& pool,
              std::vector<float>& sums) {
  const Vec3i texels = matter.grid.texels;
  const Vec3i stride{1, texels.x, texels.x * texels.y};
  SLUICE_CHECK_EQ(static_cast<int64_t>(sums.size()), volume(texels));
  // The sweep goes along the axis on which light moves fastest, so that it shifts by at most a
  // texel from plane to plane.
  int main = 0;
  for (int a = 1; a < 3; ++a)
    if (std::abs(sweep.toward[a]) > std::abs(sweep.toward[main])) main = a;
  const int b = main == 0 ? 1 : 0, c = main == 2 ? 1 : 2;
  const double paces = std::abs(sweep.toward[main]);  // planes that a way of `toward` passes
  const Shift shift(sweep.toward[b] / paces, sweep.toward[c] / paces);
  const double length = sweep.length / paces;
  const auto exponent = static_cast<float>(-length);
  // Shadows of ambient light fade with the way.
  const auto kept = static_cast<float>(sweep.reach > 0 ? std::exp(-length / sweep.reach) : 1);
  const bool from_above = sweep.toward[main] > 0;
  const int64_t across = texels[b], up = texels[c], planes = texels[main];
  Plane in(across, up), out(across, up), last_in(across, up), last_out(across, up);
  constexpr int64_t kRows = 16;  // a thread's share
  for (int64_t n = 0; n < planes; ++n) {
    // The sweep begins at the side of the light and goes plane by plane.
    const int64_t base = (from_above ? planes - 1 - n : n) * stride[main];
    pool.parallelFor((up + kRows - 1) / kRows, [&](int64_t part) {
      for (int64_t j = part * kRows; j < std::min(up, (part + 1) * kRows); ++j)
        for (int64_t i = 0; i < across; ++i) {
          const auto texel = static_cast<size_t>(base + i * stride[b] + j * stride[c]);
          const float arriving = shift.of(last_out, i, j);
          in.at(i, j) = arriving;
          const float through = arriving * std::exp(exponent * matter.per_length[texel]);
          out.at(i, j) = 1 - (1 - through) * kept;
          // The texel gets what arrived at the plane before, so that a surface does not lie in its
          // own shadow.
          sums[texel] += weight * shift.of(last_in, i, j);
        }
    });
    std::swap(in, last_in);
    std::swap(out, last_out);
  }
}

}  // namespace sluice
