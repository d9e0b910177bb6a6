// LeapGrid: which bricks of a chunk show nothing, so that rays leap over them.
//
// A brick is kBrickSide^3 cells of a chunk, from its first texel on. A sample in it lies between
// the least and the greatest of its (kBrickSide + 1)^3 texels. In a chunk with spreads it shows
// values that any mean between the least and the greatest may stand for with the greatest spread.
// If no such value has an opacity, leaving the samples out changes nothing. Rays
// leap over neighbouring bricks at once: each brick has its distance to the nearest one that may
// show something (as in Zuiderveld et al. 1992, with the distance of the greatest axis).
//
// Pure functions.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "src/base/values/shown_values.h"
#include "src/device/chunk_texels.h"
#include "src/device/device.h"
#include "src/device/frame_values.h"

namespace sluice {

inline constexpr int kBrickSide = kTableBrickSide;
// Distances reach no further.
inline constexpr int kMostDistance = 6;

struct LeapGrid {
  Vec3i bricks;
  // Each brick, x fastest, has the least and the greatest value that a sample may show. NaN texels
  // do not count.
  std::vector<std::byte> ranges;
  // 0 if the brick may show something, else bricks to the nearest one that may, 1 for a neighbour;
  // kMostDistance for all greater distances. A few bytes more than bricks, so that four may be read
  // at each.
  std::vector<uint8_t> distances;
  double shown_share = 1;  // share of bricks that may show something
  int64_t margin = 0;      // texels beside a brick that count as its own
};

// Makes the grid without distances. `expected` gives the look of spreads, if the chunk has them;
// null: the second numbers make no other values show, as shares of labels do not.
// `margin`: a sample shows values up to so many texels from it.
LeapGrid leapGrid(const ChunkTexels& chunk, const ExpectedLook* expected = nullptr,
                  int64_t margin = 0);
void setDistances(LeapGrid& grid, DeviceType type, const ShownValues& shown);

}  // namespace sluice
