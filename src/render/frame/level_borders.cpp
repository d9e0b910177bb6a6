#include "src/render/frame/level_borders.h"

#include <algorithm>
#include <cmath>

namespace sluice {
namespace {

// Rounding of scales and offsets that files give as decimals, in voxels.
constexpr double kRounding = 1e-6;

// The cells beside a face that has a border; empty: it has none.
Box3 cellsBeside(const PyramidLayout& pyramid, const TextureBlock& block, int axis, bool is_upper,
                 const Box3& shown) {
  // Bits 0 to 2 are the lower faces along x, y and z, bits 3 to 5 the upper ones.
  if ((block.level_faces >> (is_upper ? 3 + axis : axis) & 1U) == 0) return {};
  const Box3 region = pyramid.regionOf(block.name);
  const LevelPlacement& placement = pyramid.of(block.name).placement;
  const Box3 texels = intersect(pyramid.storedVoxels(block.name), block.voxels);
  const auto most = static_cast<int64_t>(std::ceil(placement.scale[axis] - kRounding));
  Box3 cells = block.cells;
  if (is_upper) {
    // An object box that ends before the face has no surface there.
    if (block.cells.hi[axis] != region.hi[axis]) return {};
    const double last = placement.finestFromLevel(toDouble(texels.hi - Vec3i{1, 1, 1}))[axis];
    // A cell needs texels on both of its sides: cells end at the last one.
    const auto end = static_cast<int64_t>(std::floor(last + kRounding));
    cells.lo[axis] = region.hi[axis];
    cells.hi[axis] = std::min(end, region.hi[axis] + most);
  } else {
    if (block.cells.lo[axis] != region.lo[axis]) return {};
    const double first = placement.finestFromLevel(toDouble(texels.lo))[axis];
    const auto begin = static_cast<int64_t>(std::ceil(first - kRounding));
    cells.hi[axis] = region.lo[axis];
    cells.lo[axis] = std::max(begin, region.lo[axis] - most);
  }
  return intersect(cells, shown);
}

}  // namespace

LevelBorders levelBorders(const PyramidLayout& pyramid, const TextureBlock& block,
                          const BoxDraw& box, const LevelFades& fades, const Box3& shown,
                          const EyePosition& eye) {
  LevelBorders borders;
  const std::vector<Box3> in_finer = fades.cellsInFiner(block.name);
  for (int axis = 0; axis < 3; ++axis)
    for (const bool is_upper : {false, true}) {
      const Box3 cells = cellsBeside(pyramid, block, axis, is_upper, shown);
      if (cells.empty() || fades.hasSeamAt(block.name, is_upper ? 3 + axis : axis)) continue;
      BoxDraw beside = box;
      beside.beside = box.cells;
      const int64_t plane = is_upper ? box.cells.hi[axis] : box.cells.lo[axis];
      const bool is_before = passesLowerFirst(eye, axis, plane) != is_upper;
      for (const SeamPart& part : partsAtSeams(cells, in_finer, eye)) {
        if (!part.seams.empty()) continue;
        beside.cells = part.cells;
        (is_before ? borders.before : borders.behind).push_back(beside);
      }
    }
  return borders;
}

Box3 cellsWithBorders(const PyramidLayout& pyramid, const TextureBlock& block, const Box3& shown) {
  Box3 cells = block.cells;
  for (int axis = 0; axis < 3; ++axis)
    for (const bool is_upper : {false, true})
      cells = unite(cells, cellsBeside(pyramid, block, axis, is_upper, shown));
  return cells;
}

}  // namespace sluice
