#include "src/visibility/plenoptic/ray_rows.h"

#include <cmath>

#include "src/visibility/plenoptic/part_detail.h"

namespace sluice {
namespace {

// A depth further off than any sample, and within what ceilOf() can round.
constexpr double kFarSlices = 1 << 29;

// The step kept away from 0, so that one may divide by it.
double safe(double step) {
  constexpr double kLeast = 1e-6;
  if (std::abs(step) >= kLeast) return step;
  return step < 0 ? -kLeast : kLeast;
}

// Rounds up without a library call, which would end vector code: the difference is positive, where
// a conversion rounds down.
int32_t ceilOf(double v) {
  return (1 << 30) - static_cast<int32_t>(static_cast<double>(1 << 30) - v);
}

static_assert(kDetail == 4);

using Lanes = SampleBatch::Lanes;

[[gnu::always_inline]] inline void march(const PartValues& parts, int32_t most, Lanes& lanes) {
  const float* __restrict values = parts.extinction;
  const uint32_t* __restrict cubes = parts.cubes;
  const int32_t row = parts.count[0], plane = parts.count[0] * parts.count[1];
  // The last place that is still in the last cube: rounding may have gone further.
  const auto lastOf = [](int32_t count) {
    return std::nextafter(static_cast<float>(count * static_cast<int32_t>(kDetail)), 0.0F);
  };
  const float last_x = lastOf(parts.count[0]), last_y = lastOf(parts.count[1]),
              last_z = lastOf(parts.count[2]);
  // A look at whether any lane goes on costs a sum over all: one every few samples is enough.
  constexpr int32_t kBetweenLooks = 4;
  for (int32_t from = 0; from < most; from += kBetweenLooks) {
    int32_t live = 0;
    for (size_t i = 0; i < TileRays::kSide; ++i) {
      const int32_t k = lanes.first[i] + from;
      live += (lanes.count[i] > k ? 1 : 0) & (lanes.sum[i] < lanes.room[i] ? 1 : 0);
      // Samples that add nothing are remembered, so that the next step need not take them again.
      lanes.clear[i] = lanes.sum[i] == 0 ? std::min(k, lanes.count[i]) : lanes.clear[i];
    }
    if (live == 0) return;
    const int32_t end = std::min(most, from + kBetweenLooks);
    for (int32_t turn = from; turn < end; ++turn)
      for (size_t i = 0; i < TileRays::kSide; ++i) {
        const int32_t k = lanes.first[i] + turn;
        const auto at = static_cast<float>(k);
        // Rounding may put a position outside the block by less than a cube.
        const float px = std::clamp(lanes.x[i] + lanes.dx[i] * at, 0.0F, last_x);
        const float py = std::clamp(lanes.y[i] + lanes.dy[i] * at, 0.0F, last_y);
        const float pz = std::clamp(lanes.z[i] + lanes.dz[i] * at, 0.0F, last_z);
        const auto x = static_cast<int32_t>(px), y = static_cast<int32_t>(py),
                   z = static_cast<int32_t>(pz);
        const int32_t part = (z >> 2) * plane + (y >> 2) * row + (x >> 2);
        // A cube has two bits, which choose one of its part's four levels (part_detail.h).
        const uint32_t layer = cubes[4 * part + (z & 3)];
        const auto bit = static_cast<uint32_t>(2 * ((x & 3) | (y & 3) << 2));
        const float value = values[4 * part + static_cast<int32_t>(layer >> bit & 3U)];
        // Both conditions are numbers, and no branches, so that the loop stays vector code.
        const bool counts = (k < lanes.count[i]) & (lanes.sum[i] < lanes.room[i]);
        lanes.sum[i] += counts ? value : 0.0F;
        lanes.taken[i] += counts ? 1 : 0;
      }
  }
}

using March = void (*)(const PartValues&, int32_t, Lanes&);

void marchPlainly(const PartValues& parts, int32_t most, Lanes& lanes) {
  march(parts, most, lanes);
}

#if defined(__x86_64__) && !defined(__SANITIZE_THREAD__)
[[gnu::target("avx2")]] void marchAvx2(const PartValues& parts, int32_t most, Lanes& lanes) {
  march(parts, most, lanes);
}
[[gnu::target("avx512f,avx512vl,avx512dq,avx512bw")]] void marchAvx512(const PartValues& parts,
                                                                       int32_t most, Lanes& lanes) {
  march(parts, most, lanes);
}
March bestMarch() {
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl") &&
      __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512bw"))
    return marchAvx512;
  return __builtin_cpu_supports("avx2") ? marchAvx2 : marchPlainly;
}
#else
March bestMarch() {
  return marchPlainly;
}
#endif

}  // namespace

void TileRays::set(const RayGrid& rays, bool parallel, double first_slice, int x, int y) {
  parallel_ = parallel;
  const double px = x + 0.5, py = y + 0.5;
  origin_ = rays.origin0 + rays.origin_dx * px + rays.origin_dy * py;
  dx_ = rays.origin_dx;
  dy_ = rays.origin_dy;
  step_ = rays.step0 + rays.step_dx * px + rays.step_dy * py;
  step_dx_ = rays.step_dx;
  step_dy_ = rays.step_dy;
  slices_ = {1 / safe(step_.x), 1 / safe(step_.y), 1 / safe(step_.z)};
  // The first sample in front of the eye is half a slice behind this.
  // A parallel view has no eye: samples lie on both sides of its origin.
  first_ = first_slice > 0 ? first_slice : -kFarSlices;
  if (parallel) return;
  for (int a = 0; a < 3; ++a)
    for (int j = 0; j < TileRays::kSide; ++j)
      for (int i = 0; i < TileRays::kSide; ++i)
        slices_a_voxel_[static_cast<size_t>(a)][pixelAt(i, j)] =
            1 / safe(step_[a] + step_dx_[a] * i + step_dy_[a] * j);
}

TileRays::BoxPlanes TileRays::planesOf(Vec3d lo, Vec3d hi) const {
  BoxPlanes box{};
  for (int a = 0; a < 3; ++a) {
    const auto i = static_cast<size_t>(a);
    box.lo[i] = lo[a] - origin_[a];
    box.hi[i] = hi[a] - origin_[a];
    // In perspective each pixel has planes of its own, which stretches() computes.
    if (!parallel_) continue;
    const double scale = slices_[a];
    box.entry[i] = std::min(box.lo[i] * scale, box.hi[i] * scale);
    box.exit[i] = std::max(box.lo[i] * scale, box.hi[i] * scale);
    box.gx[i] = -dx_[a] * scale;
    box.gy[i] = -dy_[a] * scale;
  }
  return box;
}

void TileRays::stretches(const BoxPlanes& box, int y, int x0, int x1, Slices& entries,
                         Slices& exits) const {
  if (parallel_) {
    const double e0 = box.entry[0] + box.gy[0] * y, l0 = box.exit[0] + box.gy[0] * y;
    const double e1 = box.entry[1] + box.gy[1] * y, l1 = box.exit[1] + box.gy[1] * y;
    const double e2 = box.entry[2] + box.gy[2] * y, l2 = box.exit[2] + box.gy[2] * y;
    for (int x = x0; x < x1; ++x) {
      const double s0 = box.gx[0] * x, s1 = box.gx[1] * x, s2 = box.gx[2] * x;
      entries[static_cast<size_t>(x)] = std::max(std::max(e0 + s0, e1 + s1), e2 + s2);
      exits[static_cast<size_t>(x)] = std::min(std::min(l0 + s0, l1 + s1), l2 + s2);
    }
    return;
  }
  for (int x = x0; x < x1; ++x) {
    const size_t pixel = pixelAt(x, y);
    double entry = first_, exit = kFarSlices;
    for (int a = 0; a < 3; ++a) {
      const auto i = static_cast<size_t>(a);
      const double at = dx_[a] * x + dy_[a] * y;
      const double at_lo = (box.lo[i] - at) * slices_a_voxel_[i][pixel];
      const double at_hi = (box.hi[i] - at) * slices_a_voxel_[i][pixel];
      entry = std::max(entry, std::min(at_lo, at_hi));
      exit = std::min(exit, std::max(at_lo, at_hi));
    }
    entries[static_cast<size_t>(x)] = entry;
    exits[static_cast<size_t>(x)] = exit;
  }
}

void TileRays::positions(Vec3d lo, double scale, int y, int x0, int x1, const Samples& first,
                         Positions& out) const {
  for (int a = 0; a < 3; ++a) {
    const auto i = static_cast<size_t>(a);
    const double from = (origin_[a] + dy_[a] * y - lo[a]) * scale, by = dx_[a] * scale;
    const double step = (step_[a] + step_dy_[a] * y) * scale, step_by = step_dx_[a] * scale;
    for (int x = x0; x < x1; ++x) {
      const double way = step + step_by * x;
      out.step[i][static_cast<size_t>(x)] = static_cast<float>(way);
      out.at[i][static_cast<size_t>(x)] =
          static_cast<float>(from + by * x + way * (first[static_cast<size_t>(x)] + 0.5));
    }
  }
}

void samplesOf(const TileRays::Slices& entry, const TileRays::Slices& exit, int x0, int x1,
               double doubt, TileRays::Samples& first, TileRays::Samples& count) {
  for (auto x = static_cast<size_t>(x0); x < static_cast<size_t>(x1); ++x) {
    // Samples lie at half slices, so that sample k is at k + 1/2.
    const double from = std::clamp(entry[x] + doubt - 0.5, -kFarSlices, kFarSlices);
    const double to = std::clamp(exit[x] - doubt - 0.5, -kFarSlices, kFarSlices);
    first[x] = ceilOf(from);
    count[x] = std::max(0, ceilOf(to) - first[x]);
  }
}

void SampleBatch::finish() {
  static const March kMarch = bestMarch();
  if (rays_ == 0) return;
  int32_t most = 0;
  for (size_t i = 0; i < rays_; ++i) most = std::max(most, lanes_.count[i] - lanes_.first[i]);
  kMarch(parts_, most, lanes_);
  for (size_t i = 0; i < rays_; ++i) {
    results_.added[pixels_[i]] = lanes_.sum[i];
    results_.taken[pixels_[i]] = lanes_.taken[i];
    results_.clear[pixels_[i]] = lanes_.clear[i];
  }
  // Lanes beyond the last ray of the next batch must count as ended.
  lanes_.sum.fill(0);
  lanes_.count.fill(0);
  lanes_.first.fill(0);
  rays_ = 0;
}

}  // namespace sluice
