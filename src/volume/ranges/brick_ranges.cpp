#include "src/volume/ranges/brick_ranges.h"

#include <algorithm>

namespace sluice {
namespace {

// A volume of no more voxels (16 TiB of bytes) may be stored whole: its bricks do not depend on
// which parts a sparse file leaves out.
constexpr double kMostDenseVoxels = 0x1p44;

// Computed in doubles: a sparse volume may have more cells than 63 bits count.
bool fits(Vec3i cells, int64_t side) {
  double bricks = 1;
  for (int a = 0; a < 3; ++a) bricks *= static_cast<double>(ceilDiv(cells[a], side));
  return bricks <= static_cast<double>(kMostRangeBricks);
}

}  // namespace

Box3 brickCells(Vec3i dims, const std::optional<Occupancy>& occupancy) {
  const Box3 all = boxOf(dims - Vec3i{1, 1, 1});
  const double voxels_in_all =
      static_cast<double>(dims.x) * static_cast<double>(dims.y) * static_cast<double>(dims.z);
  if (!occupancy || voxels_in_all <= kMostDenseVoxels) return all;
  Box3 voxels;
  for (const Box3& box : occupancy->boxes) voxels = unite(voxels, box);
  if (voxels.empty()) return {};
  return intersect({voxels.lo - Vec3i{1, 1, 1}, voxels.hi}, all);
}

BrickRanges brickGrid(const Box3& cells) {
  BrickRanges grid;
  if (cells.empty()) return grid;
  grid.cells = cells;
  const Vec3i size = cells.size();
  int64_t too_small = 0, enough = std::max({size.x, size.y, size.z});
  while (enough - too_small > 1) {
    const int64_t side = too_small + (enough - too_small) / 2;
    (fits(size, side) ? enough : too_small) = side;
  }
  grid.side = enough;
  return grid;
}

}  // namespace sluice
