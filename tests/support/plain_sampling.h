// Samples a chunk's texels and the tables as the plain device does, in plain loops.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "src/base/values/vec.h"
#include "src/device/device.h"

namespace sluice {

// Below it lie the stand-in for NaN and whatever is interpolated with it (device_voxel.h).
inline constexpr double kNoNumber = -2e30;

// Trilinear; texel centres at integers, beyond the chunk its outermost texels. The mean in a chunk
// with spreads.
double valueAt(const ChunkTexels& chunk, Vec3d at);
// The spread there, whose square is trilinear; texels that are no number have none. Requires: the
// chunk has spreads.
double spreadAt(const ChunkTexels& chunk, Vec3d at);

// The value with the greatest weight among the eight texels around; of two with the same weight,
// the greater.
double labelAt(const ChunkTexels& chunk, Vec3d at);
// The same among the labels that show, and the part of a whole voxel's opacity that shows, see
// label_shares.h; any label if none shows. Requires: the chunk has shares.
struct ShownLabel {
  double label = 0, part = 0;
};
ShownLabel shownLabelAt(const ChunkTexels& chunk, const LookUp& look_up, Vec3d at);
// The opacity of a sample of `lengths` unit lengths in voxels of `voxel` unit lengths, from that of
// one unit length.
double sharedOpacity(double opacity, double part, double lengths, double voxel);

// The change of the labels' opacity of a unit length from texel to texel along each axis there: the
// slope of Sobel's operator at the eight texels around, trilinear. In a chunk with shares, where
// one label alone shows in the 4 x 4 x 4 texels around, of its opacity times the share that shows.
Vec3d labelSlopesAt(const ChunkTexels& chunk, const LookUp& look_up, Vec3d at);

// Light falls on this where texels stand for many values each, see rough_light.h: the change of the
// means from texel to texel along each axis, what counts of its square, the share of that whose
// light is seen, what counts of the spread, and noise; nothing where one of the 4 x 4 x 4 texels
// around is no number. `texel_voxels`: the side of a cube as large as a texel, in voxels.
struct WideSlopes {
  Vec3d slopes;
  double here = 0, seen = 0, spread = 0, noise = 0;
};
std::optional<WideSlopes> wideSlopesAt(const ChunkTexels& chunk, Vec3d at, double texel_voxels);

// The table's entry of a device value, interpolated between two entries if it interpolates.
std::array<double, 4> lookedUp(const LookUp& look_up, double value, bool interpolates);

// The mean colour and opacity of all values between two, see IntegratedLook: r, g, b, not
// premultiplied, weighted by extinction, and the opacity of a unit length.
class MeanLook {
 public:
  explicit MeanLook(const LookUp& look_up);
  std::array<double, 4> between(double from, double to) const;

 private:
  std::array<double, 4> densityAt(double entry) const;
  std::array<double, 4> sumBelow(double entry) const;

  double scale_ = 0, offset_ = 0;
  // Extinction times red, green, blue and 1 of each entry, of each step from an entry to the next,
  // and the sums of the steps.
  std::vector<std::array<double, 4>> alone_, densities_, sums_;
};

// The table's entry of a mean and a spread, premultiplied, and the share by which it stands for
// them; the rest is the mean's look without spread.
struct ExpectedEntry {
  std::array<double, 4> rgba{};
  double share = 0;
};
ExpectedEntry expectedAt(const ExpectedLook& look, double mean, double spread);

// The factor of the opacity at a gradient of that magnitude and that value; 1 without such a table.
double factorOf(const LookUp& look_up, double magnitude, double value);

}  // namespace sluice
