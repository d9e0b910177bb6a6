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
  Vec3d origin_, dx_, dy_;  // at the centre of the tile's pixel (0, 0)
  Vec3d slices_;            // a voxel along each axis there
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
void addStretch(const float* thickness, int count, float k, const RaySums& rays);

}  // namespace sluice
