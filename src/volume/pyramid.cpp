#include "src/volume/pyramid.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "src/base/error.h"

namespace sluice {
namespace {

// Rounding, in voxels, of scales and offsets that files give as decimals.
constexpr double kRounding = 1e-6;
// How far the positions of a block's region may lie beyond its own planes, in voxels of the level;
// the ghost layer holds the texels there.
constexpr double kMostShift = 1;

int64_t floorOf(double at) {
  return static_cast<int64_t>(std::floor(at + kRounding));
}
int64_t ceilOf(double at) {
  return static_cast<int64_t>(std::ceil(at - kRounding));
}

// The finest cells between two places of a level, rounded outwards.
Box3 cellsBetween(const LevelPlacement& placement, Vec3d level_lo, Vec3d level_hi) {
  const Vec3d lo = placement.finestFromLevel(level_lo);
  const Vec3d hi = placement.finestFromLevel(level_hi);
  Box3 cells;
  for (int a = 0; a < 3; ++a) {
    cells.lo[a] = floorOf(lo[a]);
    cells.hi[a] = ceilOf(hi[a]);
  }
  return cells;
}

}  // namespace

Box3 LevelLayout::voxelsUnder(const Box3& cells) const {
  // The finest level, and each level with the same voxels, needs no rounding.
  if (placement == LevelPlacement()) return {cells.lo, cells.hi + Vec3i{1, 1, 1}};
  const Vec3d lo = placement.levelFromFinest(toDouble(cells.lo));
  const Vec3d hi = placement.levelFromFinest(toDouble(cells.hi));
  // Rounded outwards, and inwards by the tolerance, so that a scale given in decimals adds no
  // voxel.
  Box3 voxels;
  for (int a = 0; a < 3; ++a) {
    voxels.lo[a] = floorOf(lo[a]);
    voxels.hi[a] = ceilOf(hi[a]) + 1;
  }
  return voxels;
}

Box3 LevelLayout::cellsOver(const Box3& level_cells) const {
  return cellsBetween(placement, toDouble(level_cells.lo), toDouble(level_cells.hi));
}

Box3 LevelLayout::cellsAround(const Box3& level_voxels) const {
  const Vec3d half{0.5, 0.5, 0.5};
  return cellsBetween(placement, toDouble(level_voxels.lo) - half,
                      toDouble(level_voxels.hi) - half);
}

PyramidLayout::PyramidLayout(const BlockLayout& finest) {
  const int64_t side = finest.cells();
  levels_.push_back({finest, {}, {side, side, side}, 1});
}

std::string PyramidLayout::add(Vec3i dims, const LevelPlacement& placement, int numbers) {
  SLUICE_CHECK(finest().ghost >= 1);
  if (dims.x < 2 || dims.y < 2 || dims.z < 2)
    return fmt::format("{} x {} x {} voxels are fewer than 2 along an axis", dims.x, dims.y,
                       dims.z);
  const LevelLayout& below = levels_.back();
  LevelLayout level{blockLayout(dims, finest().size, finest().ghost), placement, below.width,
                    numbers};
  const Vec3i last_cell = finest().dims - Vec3i{1, 1, 1};
  for (int a = 0; a < 3; ++a) {
    const double factor = placement.scale[a] / below.placement.scale[a];
    // Levels nest if each is a whole multiple of the next finer one along all axes.
    const int64_t times = std::llround(factor);
    if (!(factor > 0) || times < 1)
      return fmt::format("its voxels are finer than the previous level's along {}", "xyz"[a]);
    level.width[a] *= times;
    // The blocks' planes must lie where the regions' faces do, within a voxel of the level. The
    // difference is linear in the block's index, so that the first and the last block tell for all.
    const int64_t side = level.blocks.cells(), end = level.blocks.grid[a] - 1;
    for (const int64_t block : {int64_t{0}, end}) {
      const int64_t lo = block * level.width[a];
      const int64_t hi = block == end ? last_cell[a] : lo + level.width[a];
      const auto shift = [&](int64_t cell, int64_t voxel) {
        return (static_cast<double>(cell) - placement.offset[a]) / placement.scale[a] -
               static_cast<double>(voxel);
      };
      // Beyond its last voxel a level shows that voxel's value, and the padding holds it: levels of
      // floor-divided sizes end up to one and a half of their voxels before the volume does.
      // The outermost layer is for slopes there.
      const double most_above =
          block == end ? std::max(kMostShift, finest().ghost - 1.0) : kMostShift;
      const bool fits = lo < hi && shift(lo, block * side) >= -kMostShift - kRounding &&
                        shift(hi, (block + 1) * side) <= most_above + kRounding;
      if (fits) continue;
      // A voxel lies in the middle of those that it stands for, or at the first of them.
      const double middle = (placement.scale[a] - 1) / 2, offset = placement.offset[a];
      if (offset < std::min(0.0, middle) - kRounding || offset > std::max(0.0, middle) + kRounding)
        return fmt::format(
            "along {} its first voxel lies at {:g} among those of level 0, expected "
            "0 to {:g}",
            "xyz"[a], offset, middle);
      if (std::abs(factor - static_cast<double>(times)) <= kRounding)
        return fmt::format(
            "along {} its {} voxels, {:g} times as wide as those of level 0, end elsewhere than "
            "the {} of level 0",
            "xyz"[a], dims[a], placement.scale[a], finest().dims[a]);
      return fmt::format(
          "along {} its voxels are {:g} times as wide as those of the level before, "
          "expected a whole number",
          "xyz"[a], factor);
    }
  }
  if (level.width == below.width) return "its voxels are no larger than the previous level's";
  levels_.push_back(level);
  return {};
}

Box3 PyramidLayout::regionOf(int number, Vec3i index) const {
  const LevelLayout& at = level(number);
  Box3 region{index * at.width, (index + Vec3i{1, 1, 1}) * at.width};
  const Vec3i last_cell = finest().dims - Vec3i{1, 1, 1};
  for (int a = 0; a < 3; ++a)
    // The last block has the rest: cells of the finest level that make no whole coarse voxel.
    if (index[a] == at.blocks.grid[a] - 1) region.hi[a] = last_cell[a];
  return region;
}

Box3 PyramidLayout::regionOf(const BlockName& name) const {
  return regionOf(name.level, of(name).blocks.indexOf(name.block));
}

Box3 PyramidLayout::storedVoxels(const BlockName& name) const {
  const BlockLayout& blocks = of(name).blocks;
  return blocks.storedVoxels(blocks.indexOf(name.block));
}

Box3 PyramidLayout::finestBlocksOf(const BlockName& name) const {
  const Box3 region = regionOf(name);
  const int64_t side = finest().cells();
  return {region.lo / side, (region.hi + Vec3i{side - 1, side - 1, side - 1}) / side};
}

Box3 PyramidLayout::childrenOf(int number, Vec3i index) const {
  const LevelLayout& at = level(number);
  const LevelLayout& below = level(number - 1);
  const Vec3i times = at.width / below.width;
  Box3 children{index * times, (index + Vec3i{1, 1, 1}) * times};
  for (int a = 0; a < 3; ++a)
    // The last block's children include those that make no whole number of them.
    if (index[a] == at.blocks.grid[a] - 1) children.hi[a] = below.blocks.grid[a];
  return children;
}

int ghostOfLevels(Vec3i dims, int64_t block, std::span<const CoarserLevel> levels) {
  constexpr int kMost = 3;
  const auto nesting = [&](int ghost) {
    PyramidLayout pyramid(blockLayout(dims, block, ghost));
    for (const CoarserLevel& level : levels)
      if (!pyramid.add(level.source->layout().dims, level.placement).empty()) break;
    return pyramid.levels();
  };
  return hasRoom(block, kMost) && nesting(kMost) > nesting(kGhostOfLevels) ? kMost : kGhostOfLevels;
}

int levelsInCommon(const PyramidLayout& a, const PyramidLayout& b) {
  const int most = std::min(a.levels(), b.levels());
  int common = 0;
  for (; common < most; ++common) {
    LevelLayout of_a = a.level(common);
    // Means with and without spreads are cut alike.
    of_a.numbers = b.level(common).numbers;
    if (!(of_a == b.level(common))) break;
  }
  return common;
}

}  // namespace sluice
