// CutOptions: at which levels of resolution a picture is drawn. Plain data.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

namespace sluice {

struct CutOptions {
  double pixel_error = 1;         // pixels that a voxel may be wide along any axis
  std::optional<int> level = {};  // all at this one, whatever the pixel error and the budgets
  // Nobody asked for a cut. The finest level is drawn if coarser ones would show something else:
  // maxima, minima, averages and labels need values that means do not have.
  bool is_default = false;
  // Blocks below which the finest level shows something thinner than two of their voxels are
  // refined, too, wherever the picture shows them.
  bool keeps_thin = false;
  // Limits for the blocks of a picture: stored voxels, and voxels as the volume buffer holds them.
  uint64_t most_stored_bytes = UINT64_MAX, most_held_bytes = UINT64_MAX;
  friend bool operator==(const CutOptions&, const CutOptions&) = default;
};

// The width in pixels up to which voxels are fine enough. It is 2 % above the pixel error, since
// the automatic framing of a volume differs by up to as much with its resolution: a body whose
// voxels at some level are just a pixel wide would be drawn at that level or at the next finer one,
// of eight times the voxels, by chance.
constexpr double widestVoxel(const CutOptions& cut) {
  return 1.02 * cut.pixel_error;
}

// The options of one of so many volumes that a picture shows, with its share of the limits.
constexpr CutOptions shareOf(CutOptions cut, size_t volumes) {
  cut.most_stored_bytes /= volumes;
  cut.most_held_bytes /= volumes;
  return cut;
}

}  // namespace sluice
