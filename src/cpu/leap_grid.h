// LeapGrid: which bricks of a chunk show nothing, so that rays leap over them.
//
// A brick is kBrickSide^3 cells of a chunk, from its first texel on; what a sample in it can be
// lies between the least and the greatest of its (kBrickSide + 1)^3 texels; of texels with spreads,
// between the least and the greatest of the values that those stand for. Where no such value has
// an opacity, leaving its samples out changes nothing. Bricks beside each other are leapt over at
// once: each has its distance to the nearest one that may show something (as in Zuiderveld et al.
// 1992, with the distance of the greatest axis).
//
// Pure functions.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "src/device/chunk_texels.h"
#include "src/device/device.h"
#include "src/device/frame_values.h"

namespace sluice {

inline constexpr int kBrickSide = kTableBrickSide;
// Distances reach no further.
inline constexpr int kMostDistance = 6;

// Which values show something, in O(1) an interval.
class ShownValues {
 public:
  ShownValues() = default;
  explicit ShownValues(const LookUp& look_up);

  // Whether a sample between the two, or just beyond by rounding, may have an opacity.
  bool anyIn(float lo, float hi) const;
  bool operator==(const ShownValues&) const = default;

 private:
  double scale_ = 0, offset_ = 0;
  bool interpolates_ = false;
  std::vector<uint32_t> shown_before_{0};  // entries before this one that show something
};

struct LeapGrid {
  Vec3i bricks;
  // Of each brick, x fastest, as texels: least and greatest. Texels that are no number count not.
  std::vector<std::byte> ranges;
  // 0 where something may show, else bricks to the nearest one such, 1 for a neighbour;
  // kMostDistance and more alike. A few bytes more than bricks, so that four may be read at each.
  std::vector<uint8_t> distances;
  double shown_share = 1;  // of the bricks
};

// Without distances. `expected` is how spreads look, where the chunk has them.
LeapGrid leapGrid(const ChunkTexels& chunk, const ExpectedLook* expected = nullptr);
void setDistances(LeapGrid& grid, DeviceType type, const ShownValues& shown);

}  // namespace sluice
