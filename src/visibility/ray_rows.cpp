#include "src/visibility/ray_rows.h"

#include <cmath>

namespace sluice {
namespace {

// Away from 0, so that one may divide by it.
double safe(double step) {
  constexpr double kLeast = 1e-6;
  if (std::abs(step) >= kLeast) return step;
  return step < 0 ? -kLeast : kLeast;
}

}  // namespace

void TileRays::set(const RayGrid& rays, bool parallel, double first_slice, int x, int y) {
  parallel_ = parallel;
  const double px = x + 0.5, py = y + 0.5;
  origin_ = rays.origin0 + rays.origin_dx * px + rays.origin_dy * py;
  dx_ = rays.origin_dx;
  dy_ = rays.origin_dy;
  slices_ = {1 / safe(rays.step0.x), 1 / safe(rays.step0.y), 1 / safe(rays.step0.z)};
  // The first sample in front of the eye is half a slice behind this.
  first_ = static_cast<float>(first_slice > 0 ? first_slice : -1e9);
  if (parallel) return;
  for (int a = 0; a < 3; ++a)
    for (int j = 0; j < kSide; ++j)
      for (int i = 0; i < kSide; ++i) {
        const auto pixel = static_cast<size_t>(j * kSide + i);
        const double step = rays.step0[a] + rays.step_dx[a] * (px + i) + rays.step_dy[a] * (py + j);
        at_[static_cast<size_t>(a)][pixel] =
            static_cast<float>(origin_[a] + dx_[a] * i + dy_[a] * j);
        slices_a_voxel_[static_cast<size_t>(a)][pixel] = static_cast<float>(1 / safe(step));
      }
}

TileRays::BoxPlanes TileRays::planesOf(Vec3d lo, Vec3d hi) const {
  BoxPlanes box{};
  for (int a = 0; a < 3; ++a) {
    const auto i = static_cast<size_t>(a);
    box.lo[i] = static_cast<float>(lo[a]);
    box.hi[i] = static_cast<float>(hi[a]);
    if (!parallel_) continue;
    const double scale = slices_[a];
    const double at_lo = (lo[a] - origin_[a]) * scale, at_hi = (hi[a] - origin_[a]) * scale;
    box.entry[i] = static_cast<float>(std::min(at_lo, at_hi));
    box.exit[i] = static_cast<float>(std::max(at_lo, at_hi));
    box.gx[i] = static_cast<float>(-dx_[a] * scale);
    box.gy[i] = static_cast<float>(-dy_[a] * scale);
  }
  return box;
}

void TileRays::thickness(const BoxPlanes& box, int y, int x0, int x1, float* out) const {
  if (parallel_) {
    const auto row = static_cast<float>(y);
    const float e0 = box.entry[0] + box.gy[0] * row, l0 = box.exit[0] + box.gy[0] * row;
    const float e1 = box.entry[1] + box.gy[1] * row, l1 = box.exit[1] + box.gy[1] * row;
    const float e2 = box.entry[2] + box.gy[2] * row, l2 = box.exit[2] + box.gy[2] * row;
    for (int x = x0; x < x1; ++x) {
      const auto at = static_cast<float>(x);
      const float s0 = box.gx[0] * at, s1 = box.gx[1] * at, s2 = box.gx[2] * at;
      const float entry = std::max(std::max(e0 + s0, e1 + s1), e2 + s2);
      const float exit = std::min(std::min(l0 + s0, l1 + s1), l2 + s2);
      out[x - x0] = exit - entry;
    }
    return;
  }
  const size_t row = static_cast<size_t>(y) * kSide;
  for (int x = x0; x < x1; ++x) {
    const size_t pixel = row + static_cast<size_t>(x);
    float entry = first_, exit = 1e9F;
    for (size_t a = 0; a < 3; ++a) {
      const float at_lo = (box.lo[a] - at_[a][pixel]) * slices_a_voxel_[a][pixel];
      const float at_hi = (box.hi[a] - at_[a][pixel]) * slices_a_voxel_[a][pixel];
      entry = std::max(entry, std::min(at_lo, at_hi));
      exit = std::min(exit, std::max(at_lo, at_hi));
    }
    out[x - x0] = exit - entry;
  }
}

void addStretch(const float* __restrict thickness, int count, float k, const RaySums& rays) {
  float* __restrict sums = rays.sum;
  float* __restrict levels = rays.level;
  float* __restrict risings = rays.rising;
  float* __restrict sinces = rays.since;
  // Without branches, for all lanes of a vector at once.
  for (int x = 0; x < count; ++x) {
    const float d = std::max(thickness[x] - kThicknessDoubt, 0.0F);
    const float level = levels[x], rising = risings[x], since = sinces[x];
    const float kept = std::min(k, level);
    // What was rising goes on to rise, or is through.
    const float both = std::max(kept, std::min(k, rising));
    const float run = since + d;
    sums[x] +=
        kept * d + (both - kept) * std::max(run - 1, 0.0F) + (k - both) * std::max(d - 1, 0.0F);
    // Of two that rise the one that was there for longer stays, unless it ends here.
    const float next = run >= 1 ? both : kept;
    const float waits = both > kept ? both : k, waits_since = both > kept ? run : d;
    const float next_rising = run >= 1 ? k : waits, next_since = run >= 1 ? d : waits_since;
    const float now = d >= 1 ? k : next;
    const float now_rising = d >= 1 ? 0 : next_rising, now_since = d >= 1 ? 0 : next_since;
    levels[x] = d > 0 ? now : level;
    risings[x] = d > 0 ? now_rising : rising;
    sinces[x] = d > 0 ? now_since : since;
  }
}

}  // namespace sluice
