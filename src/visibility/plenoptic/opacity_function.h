// OpacityFunction: how much a block hides, from any side (Gao 2004, section 4).
//
// For each cell of a table of directions the ratio of accumulated opacity to thickness, the least
// over all rays of the cell's directions that cross enough of the block: as an extinction,
// -ln(1 - opacity) / thickness, which is exact for uniform blocks. From it follow
//   OPOF                   for a ray of thickness d: 1 - exp(-ratio d);
//   the paper's linear OPOF  d (1 - exp(-ratio D)) / D with D the greatest thickness, which is
//   less; POF                    for any ray: 1 - exp(-ratio d0), d0 the least thickness that the
//   ratio
//                          is meant for.
// Rays that cut off a corner, which in the limit hide nothing, have the least extinction of all,
// the floor. In addition to the table there are the least extinctions of the block's parts and of
// cubes in them (part_detail.h). They hide even if the block as a whole has a hole, as most blocks
// have that an opaque surface passes through.
//
// Conservative: for any ray, any direction, and any place of the samples at distances of up to one
// voxel, no less is accumulated. Plain values; any thread.
#pragma once

#include <cstdint>
#include <vector>

#include "src/visibility/plenoptic/block_parts.h"
#include "src/visibility/plenoptic/directions.h"
#include "src/visibility/plenoptic/part_detail.h"

namespace sluice {

struct OpacityFunction {
  uint8_t floor = 0;            // packed extinction, as all below
  std::vector<uint8_t> ratios;  // one for each cell of directions; empty: the floor in all
  std::vector<uint8_t> parts;   // one for each part, x fastest; empty: the floor in all
  std::vector<uint8_t> detail;  // the parts' cubes, see part_detail.h; empty: none

  // Hides nothing.
  bool empty() const { return floor == 0 && ratios.empty() && parts.empty(); }
  uint64_t bytes() const { return 1 + ratios.size() + parts.size() + detail.size(); }
  friend bool operator==(const OpacityFunction&, const OpacityFunction&) = default;
};

// Made from the least extinctions of a block's cubes; its parts are partsOfCubes() of their grid.
// `detail_bits`: see detailedParts().
OpacityFunction opacityFunction(const BlockParts& cubes, const DirectionGrid& directions,
                                int detail_bits = kMostDetailBits);

// The ratio holds for rays that run at least so far along the axis of slopesOf() inside the block,
// in cells. `grid` is the grid of parts.
double leastDepthVox(const PartGrid& grid, int axis);

// A member of a family of transfer functions whose opacity is 1 - product of (1 - opacity_i)^k_i
// (equation 4): extinctions add up. Requires: one exponent, not negative, for each function; all of
// the same grid of cubes.
OpacityFunction combined(const std::vector<const OpacityFunction*>& functions,
                         const std::vector<double>& exponents, const PartGrid& cubes);

}  // namespace sluice
