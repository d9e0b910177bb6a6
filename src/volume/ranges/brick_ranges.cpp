#include "src/volume/ranges/brick_ranges.h"

#include <algorithm>

namespace sluice {
namespace {

// A volume of no more voxels (16 TiB of bytes) may be stored whole: its bricks do not depend on
// which parts a sparse file leaves out.
constexpr double kMostDenseVoxels = 0x1p44;

// Computed in doubles: a sparse volume may have more cells than 63 bits count.
bool fits(Vec3i cells, int64_t side, int64_t most_bricks) {
  double bricks = 1;
  for (int a = 0; a < 3; ++a) bricks *= static_cast<double>(ceilDiv(cells[a], side));
  return bricks <= static_cast<double>(most_bricks);
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

BrickRanges brickGrid(const Box3& cells, int64_t most_bricks) {
  BrickRanges grid;
  if (cells.empty()) return grid;
  grid.cells = cells;
  const Vec3i size = cells.size();
  // The least side that gives few enough bricks, by bisection: a longer side never gives more.
  int64_t too_small = 0, enough = std::max({size.x, size.y, size.z});
  while (enough - too_small > 1) {
    const int64_t side = too_small + (enough - too_small) / 2;
    (fits(size, side, most_bricks) ? enough : too_small) = side;
  }
  grid.side = enough;
  return grid;
}

std::vector<bool> reachesBeyond(const BrickRanges& grid, const BlockLayout& layout,
                                std::span<const int64_t> blocks) {
  const Vec3i bricks = grid.grid(), one{1, 1, 1};
  const auto eachBrick = [&](const Box3& box, const auto& call) {
    for (int64_t z = box.lo.z; z < box.hi.z; ++z)
      for (int64_t y = box.lo.y; y < box.hi.y; ++y)
        for (int64_t x = box.lo.x; x < box.hi.x; ++x)
          call(static_cast<size_t>((z * bricks.y + y) * bricks.x + x), Vec3i{x, y, z});
  };
  // A brick reaches beyond the blocks if it overlaps more blocks than were found in the list.
  std::vector<int64_t> found(static_cast<size_t>(volume(bricks)));
  for (const int64_t block : blocks) {
    const Box3 cells = intersect(layout.ownedCells(layout.indexOf(block)), grid.cells);
    if (cells.empty()) continue;
    const Box3 own{(cells.lo - grid.cells.lo) / grid.side,
                   (cells.hi - one - grid.cells.lo) / grid.side + one};
    eachBrick(own, [&](size_t brick, Vec3i /*index*/) { ++found[brick]; });
  }
  std::vector<bool> reaches(found.size());
  eachBrick({{}, bricks}, [&](size_t brick, Vec3i index) {
    const Box3 cells = grid.cellsOf(index);
    const Vec3i first = cells.lo / layout.cells(), last = (cells.hi - one) / layout.cells();
    // Computed in doubles: a brick of a sparse volume may have more blocks than 63 bits count.
    double all = 1;
    for (int a = 0; a < 3; ++a) all *= static_cast<double>(last[a] - first[a] + 1);
    reaches[brick] = static_cast<double>(found[brick]) < all;
  });
  return reaches;
}

}  // namespace sluice
