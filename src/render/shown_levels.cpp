#include "src/render/shown_levels.h"

#include <algorithm>
#include <memory>

namespace sluice {
namespace {

// Along which axis the block has the fewest texels.
int trimmingAxis(const Vec3i& texels) {
  int axis = 2;
  for (int a = 1; a >= 0; --a)
    if (texels[a] < texels[axis]) axis = a;
  return axis;
}

}  // namespace

ShownLevels::ShownLevels(const TimeStep& step, const Look& look, const Box3& crop, WorkerPool& pool)
    : pyramid_(step.layout()), crop_(crop) {
  const auto add = [&](const std::shared_ptr<const SliceRanges>& ranges, const Box3& cells) {
    is_known_.push_back(ranges != nullptr);
    levels_.push_back(ranges == nullptr ? VisibleBlocks()
                                        : classify(*ranges, look.table, cells, pool));
  };
  add(step.ranges, crop);
  for (const CoarserStep& coarser : step.coarser) {
    const Vec3i dims = pyramid_.level(static_cast<int>(levels_.size())).blocks.dims;
    add(coarser.ranges, boxOf(dims - Vec3i{1, 1, 1}));
  }
  markFinest();
}

void ShownLevels::markFinest() {
  for (int level = 0; level < pyramid_.levels(); ++level) {
    const LevelLayout& at = pyramid_.level(level);
    std::vector<bool>& marks =
        shows_finest_.emplace_back(static_cast<size_t>(at.blocks.blockCount()), false);
    const auto mark = [&](Vec3i finest_cell) {
      const Vec3i index = min(finest_cell / at.width, at.blocks.grid - Vec3i{1, 1, 1});
      marks[static_cast<size_t>(at.blocks.idOf(index))] = true;
    };
    if (level == 0) {
      for (const ObjectBlock& object : levels_[0].blocks) {
        marks[static_cast<size_t>(object.name.block)] = true;
        finest_cells_ += object.cells.count();
      }
      continue;
    }
    const LevelLayout& below = pyramid_.level(level - 1);
    const std::vector<bool>& marked = shows_finest_[static_cast<size_t>(level) - 1];
    for (size_t block = 0; block < marked.size(); ++block)
      if (marked[block]) mark(below.blocks.indexOf(static_cast<int64_t>(block)) * below.width);
  }
}

const ObjectBlock* ShownLevels::find(int level, int64_t block) const {
  const std::vector<ObjectBlock>& blocks = levels_[static_cast<size_t>(level)].blocks;
  const auto found = std::ranges::lower_bound(
      blocks, block, {}, [](const ObjectBlock& object) { return object.name.block; });
  return found == blocks.end() || found->name.block != block ? nullptr : &*found;
}

// The hull of the cells that show, of this block and those beside it: a level's cells are shifted
// against the regions, so that one cell may lie in the regions of two blocks.
Box3 ShownLevels::cellsShown(int level, Vec3i index, const Box3& region) const {
  const LevelLayout& at = pyramid_.level(level);
  const Vec3i last = at.blocks.dims - Vec3i{1, 1, 1}, end = pyramid_.finest().dims - Vec3i{1, 1, 1};
  // Blocks that own cells in the region: beside this one where the shift leads.
  Box3 owners{index, index + Vec3i{1, 1, 1}};
  const Box3 own{index * at.blocks.cells(), (index + Vec3i{1, 1, 1}) * at.blocks.cells()};
  const Box3 covered = at.cellsOver(own);
  for (int a = 0; a < 3; ++a) {
    if (covered.lo[a] > region.lo[a] && owners.lo[a] > 0) --owners.lo[a];
    if (covered.hi[a] < region.hi[a] && owners.hi[a] < at.blocks.grid[a]) ++owners.hi[a];
  }
  Box3 shown;
  for (int64_t z = owners.lo.z; z < owners.hi.z; ++z)
    for (int64_t y = owners.lo.y; y < owners.hi.y; ++y)
      for (int64_t x = owners.lo.x; x < owners.hi.x; ++x) {
        const ObjectBlock* object = find(level, at.blocks.idOf({x, y, z}));
        if (object == nullptr) continue;
        Box3 cells = at.cellsOver(object->cells);
        // Beyond its outermost voxels a level shows their values.
        for (int a = 0; a < 3; ++a) {
          if (object->cells.lo[a] == 0) cells.lo[a] = 0;
          if (object->cells.hi[a] == last[a]) cells.hi[a] = end[a];
        }
        cells = intersect(cells, region);
        shown = unite(shown, cells);
      }
  return shown;
}

ObjectBlock ShownLevels::objectOf(int level, Vec3i index, int64_t time) const {
  ObjectBlock object;
  const LevelLayout& at = pyramid_.level(level);
  const int64_t block = at.blocks.idOf(index);
  object.name = {.time = time, .level = level, .block = block};
  const Box3 region = pyramid_.regionOf(level, index);
  if (level == 0) {
    const ObjectBlock* found = find(0, block);
    if (found != nullptr) object.cells = found->cells;
  } else {
    object.cells =
        is_known_[static_cast<size_t>(level)] ? cellsShown(level, index, region) : region;
  }
  object.cells = intersect(object.cells, crop_);
  if (object.cells.empty()) {
    object.cells = {};
    return object;
  }
  object.kind = object.cells == region ? BlockClass::kBlack : BlockClass::kGrey;
  object.trimming_axis = trimmingAxis(at.voxelsUnder(object.cells).size());
  return object;
}

}  // namespace sluice
