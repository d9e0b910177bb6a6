// Growing boxes (Li 2003, section 3.1): a block's cells partitioned into boxes of similar cells, so
// that whatever the transfer function, the boxes that show something hold little that does not.
//
// Nothing here knows a transfer function: a partition is made once a block and a new function only
// flips boxes between visible and skipped, by their closed intervals of values and gradient
// magnitudes. Boxes are half-open, disjoint and cover every cell of the block; they are unions of
// bricks (brick_grid.h), so their faces lie between bricks. Pure functions, any thread.
//
// As in the paper, a box grows from a seed while its accumulated cost stays below a limit, and its
// contents make it uniform, gradient or other. We differ where that alone is too loose:
// - The cost of a box is the number of cells that it is expected to draw in vain. A brick counts by
//   how much wider the box's interval is than its own, in full once it is cost_range wider. Uniform
//   regions and evenly mixed regions both grow large; a surface stays thin.
// - The mean cost per cell is bounded too. Otherwise a small box, for which the limit exceeds its
//   cells, would absorb anything.
// - Flat bricks count in a box that has gradients, which keeps the paper's gradient boxes apart
// from
//   the uniform ones without cutting up a surface if both are visible anyway.
// - A brick of one value counts in full in a box of more than one. Such bricks are the background,
//   and a low threshold is meant to show faint values next to it, however near they are.
// - A box grows by the slab that costs least per cell, on the axis along which it is shortest among
//   equals, rather than axis after axis.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "src/base/sources/volume_source.h"
#include "src/classify/boxes/brick_grid.h"

namespace sluice {

enum class BoxType : uint8_t {
  kUniform,   // values within GrowingParameters::uniform_range, no gradient to speak of
  kGradient,  // some gradient magnitude is not zero
  kOther,     // the rest: too small for a uniform box, or too wide in values
};
// "uniform", "gradient", "other".
const char* name(BoxType type);

// Cells relative to the block's first owned cell.
struct GrownBox {
  std::array<uint16_t, 3> lo{}, hi{};
  CellRange range;  // over all cells of the box
  BoxType type = BoxType::kOther;

  Box3 local() const { return {{lo[0], lo[1], lo[2]}, {hi[0], hi[1], hi[2]}}; }
  friend bool operator==(const GrownBox&, const GrownBox&) = default;
};

// Limits and costs, in device values and cells. The numbers that are not the paper's were chosen by
// measuring bonsai, engine, walnut, tooth and two heads at 13 thresholds.
struct GrowingParameters {
  float uniform_range = 32;  // the paper's 32 of 256
  float cost_range = 64;     // so much wider than a brick, a box draws it in vain
  float gradient_floor =
      8;                   // a voxel; magnitudes up to it count as zero: noise has some everywhere
  float flat_cost = 0.5F;  // cost of a cell of a flat brick in a box with gradients
  float cost_limit_cells = 1024;
  float mean_cost_limit = 0.75F;
  int64_t least_uniform_cells = 512;
};
// The parameters for bytes, scaled from 256 values to the volume's range for other types.
GrowingParameters growingParameters(DeviceType type, ValueRange device_range);

// The type of a box of so many cells whose values and gradients have this range.
BoxType typeOf(const CellRange& range, int64_t cells, const GrowingParameters& parameters);
// The cells of a box of bricks that are drawn in vain, as told above. `range`: the box's.
double costOf(const BrickGrid& grid, const Box3& bricks, const CellRange& range,
              const GrowingParameters& parameters);
// Whether a box of so many cells may cost this much.
inline bool isWithinLimits(double cost, int64_t cells, const GrowingParameters& parameters) {
  return cost <= parameters.cost_limit_cells &&
         cost <= parameters.mean_cost_limit * static_cast<double>(cells);
}
// Requires: bricks inside the grid, not empty.
GrownBox boxOfBricks(const BrickGrid& grid, const Box3& bricks,
                     const GrowingParameters& parameters);

// The boxes in the order of their first bricks, x fastest. Requires: fewer than 2^16 cells along
// each axis.
std::vector<GrownBox> growBoxes(const BrickGrid& grid, const GrowingParameters& parameters);

}  // namespace sluice
