// RayRows: how far the rays of a row of pixels run inside a box, and what they accumulate there:
// the inner loops of the visibility estimate, in a form that compilers turn into vector code.
//
// The thickness mask of Gao 2004, section 4: for a parallel view that of boxes of one size is the
// same but for its place. So that it need not be rounded to whole pixels, it is not kept but
// computed, which is three sums, minima and maxima a pixel. Thicknesses are in slices. One thread.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>

#include "src/base/vec.h"
#include "src/device/frame_values.h"

namespace sluice {

// What arithmetic in floats may add to a thickness.
inline constexpr float kThicknessDoubt = 0.02F;

// The rays of a tile of at most `kSide` x `kSide` pixels.
class TileRays {
 public:
  static constexpr int kSide = 16;
  using Row = std::array<float, kSide>;

  void set(const RayGrid& rays, bool parallel, double first_slice, int x, int y);

  // Of a box, for rows that are asked next: Requires: set().
  struct BoxPlanes {
    std::array<float, 3> entry, exit, gx, gy;  // parallel: slices at the tile's pixel (0, 0)
    std::array<float, 3> lo, hi;               // perspective: faces
  };
  BoxPlanes planesOf(Vec3d lo, Vec3d hi) const;
  // Thickness of pixels [x0, x1) of a row, within kThicknessDoubt; below 0 where a ray passes by.
  void thickness(const BoxPlanes& box, int y, int x0, int x1, float* out) const;

 private:
  bool parallel_ = true;
  float first_ = 0;
  Vec3d origin_, dx_, dy_, step_;  // at the centre of the tile's pixel (0, 0)
  // Perspective: of each pixel.
  std::array<std::array<float, kSide * kSide>, 3> at_{}, slices_a_voxel_{};
};

// What rays have accumulated: extinction times slices; and of the stretch that they are in, the
// extinction `level` that has lost its slice for the rise to it already, and the one above it,
// `rising`, that has been there for `since` slices, fewer than one, and has added nothing yet.
struct RaySums {
  float* sum;
  float* level;
  float* rising;
  float* since;
};

// A stretch of `thickness` slices of extinction `k`: see visibility_estimate.h. `count` pixels.
inline void addStretch(const float* thickness, int count, float k, const RaySums& rays) {
  for (int x = 0; x < count; ++x) {
    const float d = std::max(thickness[x] - kThicknessDoubt, 0.0F);
    const float level = rays.level[x], rising = rays.rising[x];
    const float kept = std::min(k, level);
    // What was rising goes on to rise, or is through.
    const float both = std::max(kept, std::min(k, rising));
    const float run = rays.since[x] + d;
    const float over = std::max(run - 1, 0.0F), alone = std::max(d - 1, 0.0F);
    rays.sum[x] += kept * d + (both - kept) * over + (k - both) * alone;
    const bool is_through = run >= 1, is_through_alone = d >= 1;
    const float next = is_through_alone ? k : is_through ? both : kept;
    // Of two that rise the one that was there for longer, unless it ends here.
    const bool is_old = !is_through && both > kept;
    const float next_rising = is_through_alone ? 0 : is_old ? both : k;
    const float next_since = is_through_alone ? 0 : is_old ? run : d;
    rays.level[x] = d > 0 ? next : level;
    rays.rising[x] = d > 0 ? next_rising : rising;
    rays.since[x] = d > 0 ? next_since : rays.since[x];
  }
}

}  // namespace sluice
