// RayRows: the samples of a row of rays in a box, and the extinctions that they accumulate there:
// the inner loops of the visibility estimate, in a form that compilers turn into vector code.
//
// The thickness mask of Gao 2004, section 4: in a parallel view all boxes of one size share a mask
// up to its place. It is computed rather than kept, so that its place need not be rounded to whole
// pixels; this takes three sums, minima and maxima a pixel. Thicknesses are in slices. One thread.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "src/base/values/vec.h"
#include "src/device/frame_values.h"

namespace sluice {

// How far from a box's face, in slices, a sample may be taken for one on the face's other side:
// such a sample counts as reaching both boxes, and hides in neither.
inline constexpr double kSliceDoubt = 2e-3;

// The rays of a tile of at most `kSide` x `kSide` pixels.
class TileRays {
 public:
  static constexpr int kSide = 16;
  static constexpr size_t pixelAt(int x, int y) {
    const int pixel = y * kSide + x;
    return static_cast<size_t>(pixel);
  }

  // The rays of the tile whose first pixel is (x, y), as RayGrid counts pixels. `first_slice`: see
  // EstimateView.
  void set(const RayGrid& rays, bool parallel, double first_slice, int x, int y);

  // The planes of a box, for the rows that are asked next. Requires: set().
  struct BoxPlanes {
    std::array<double, 3> entry, exit, gx, gy;  // parallel: slices at the tile's pixel (0, 0)
    std::array<double, 3> lo, hi;               // perspective: faces
  };
  BoxPlanes planesOf(Vec3d lo, Vec3d hi) const;

  // Values for each pixel of a row.
  using Slices = std::array<double, kSide>;
  using Samples = std::array<int32_t, kSide>;
  // The slices at which rays enter and leave the box; the exit comes first if a ray passes by.
  // Fills [x0, x1).
  void stretches(const BoxPlanes& box, int y, int x0, int x1, Slices& entry, Slices& exit) const;

  // Positions of the row's samples in steps of `scale` cells from `lo`: sample k of pixel x is at
  // at[a][x] + (k - first[x]) step[a][x].
  struct Positions {
    std::array<std::array<float, kSide>, 3> at, step;
  };
  void positions(Vec3d lo, double scale, int y, int x0, int x1, const Samples& first,
                 Positions& out) const;

 private:
  bool parallel_ = true;
  double first_ = 0;
  Vec3d origin_, dx_, dy_;  // at the centre of the tile's pixel (0, 0)
  Vec3d step_, step_dx_, step_dy_;
  Vec3d slices_;  // a voxel along each axis there
  // Perspective: of each pixel.
  std::array<std::array<double, kSide * kSide>, 3> slices_a_voxel_{};
};

// The samples of a stretch: first, and how many. `doubt` slices at both ends are left out; below 0:
// added.
void samplesOf(const TileRays::Slices& entry, const TileRays::Slices& exit, int x0, int x1,
               double doubt, TileRays::Samples& first, TileRays::Samples& count);

// The extinctions of a block's parts and their cubes (part_detail.h), x fastest.
struct PartValues {
  const uint32_t* cubes;         // for each part its PartLevels::cubes
  const float* extinction;       // for each part its levels
  std::array<int32_t, 3> count;  // parts along each axis
};

// Follows rays of some of a tile's pixels through the parts of a block, sixteen rays at a time. It
// adds up their samples one by one from the first, as long as the sum is less than `room`, and
// counts the samples taken. Rays that need not be followed cost nothing, nor do first samples that
// are known to add nothing. The values do not depend on the machine.
class SampleBatch {
 public:
  // A value for each of a tile's pixels.
  struct Results {
    float* added;
    int32_t* taken;  // samples
    int32_t* clear;  // first ones that are known to add nothing
  };
  // Results come at a ray's pixel, by finish() at the latest.
  SampleBatch(const PartValues& parts, const Results& results) : parts_(parts), results_(results) {}
  // The ray of pixel x of a row, with `count` samples, the first `clear` of which add nothing.
  // Requires: clear <= count.
  void add(const TileRays::Positions& positions, size_t x, int32_t count, int32_t clear, float room,
           size_t pixel) {
    const size_t i = rays_++;
    lanes_.x[i] = positions.at[0][x], lanes_.dx[i] = positions.step[0][x];
    lanes_.y[i] = positions.at[1][x], lanes_.dy[i] = positions.step[1][x];
    lanes_.z[i] = positions.at[2][x], lanes_.dz[i] = positions.step[2][x];
    lanes_.room[i] = room;
    lanes_.count[i] = count;
    lanes_.taken[i] = lanes_.first[i] = lanes_.clear[i] = clear;
    pixels_[i] = pixel;
    if (rays_ == TileRays::kSide) finish();
  }
  // Follows the rays that were added and have no results yet.
  void finish();

  struct Lanes {
    using Floats = std::array<float, TileRays::kSide>;
    alignas(64) Floats x{}, y{}, z{}, dx{}, dy{}, dz{}, room{}, sum{};
    // `first`: the sample to begin with.
    alignas(64) TileRays::Samples count{}, first{}, taken{}, clear{};
  };

 private:
  const PartValues parts_;
  const Results results_;
  size_t rays_ = 0;
  std::array<size_t, TileRays::kSide> pixels_{};
  Lanes lanes_;
};

}  // namespace sluice
