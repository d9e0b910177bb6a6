#include "src/render/blocks/shown_levels.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <utility>

namespace sluice {
namespace {

// A part that is thinner may lie in one voxel with as much of something else.
constexpr double kThinVoxels = 2;

// Calls `call` with the first and the end of parts of 0 to `count` on all threads of the pool, each
// part so long that handing it out costs little.
template <class Call>
void inParts(WorkerPool& pool, int64_t count, const Call& call) {
  constexpr int64_t kPart = 512;
  pool.parallelFor((count + kPart - 1) / kPart,
                   [&](int64_t part) { call(part * kPart, std::min(count, (part + 1) * kPart)); });
}

template <class Call>
void visitIndices(const Box3& indices, const Call& call) {
  for (int64_t z = indices.lo.z; z < indices.hi.z; ++z)
    for (int64_t y = indices.lo.y; y < indices.hi.y; ++y)
      for (int64_t x = indices.lo.x; x < indices.hi.x; ++x) call(Vec3i{x, y, z});
}

// The axis along which the block has the fewest texels.
int trimmingAxis(const Vec3i& texels) {
  int axis = 2;
  for (int a = 1; a >= 0; --a)
    if (texels[a] < texels[axis]) axis = a;
  return axis;
}

// The level's cells that touch a voxel of it which stands for some voxel of these finest cells.
Box3 cellsAround(const LevelLayout& level, const Box3& finest) {
  const auto voxelOf = [&](Vec3i voxel, int a) {
    return static_cast<int64_t>(std::lround(level.placement.levelFromFinest(toDouble(voxel))[a]));
  };
  Box3 cells;
  for (int a = 0; a < 3; ++a) {
    cells.lo[a] = voxelOf(finest.lo, a) - 1;
    cells.hi[a] = voxelOf(finest.hi, a) + 1;
  }
  return cells;
}

}  // namespace

ShownLevels::ShownLevels(const TimeStep& step, const Look& look, const Box3& crop, WorkerPool& pool)
    : pyramid_(step.layout()), crop_(crop), is_as_finest_{true} {
  boxes_.emplace_back(std::in_place, *step.ranges, look.table, crop, pool);
  for (const CoarserStep& coarser : step.coarser) {
    const int level = static_cast<int>(boxes_.size());
    std::optional<ObjectBoxes>& boxes = boxes_.emplace_back();
    const Vec3i dims = pyramid_.level(level).blocks.dims;
    is_as_finest_.push_back(showsAsFinest(coarser.values, coarser.spreads != nullptr));
    if (coarser.ranges != nullptr && !isAsFinest(level))
      boxes.emplace(*coarser.ranges, look.table, boxOf(dims - Vec3i{1, 1, 1}), pool);
  }
  boundFinest(pool);
}

void ShownLevels::boundFinest(WorkerPool& pool) {
  std::atomic<int64_t> cells = 0;
  below_.resize(1);
  for (int level = 1; level < pyramid_.levels(); ++level) {
    const BlockLayout& blocks = pyramid_.level(level).blocks;
    std::vector<Below>& all = below_.emplace_back(static_cast<size_t>(blocks.blockCount()));
    inParts(pool, blocks.blockCount(), [&](int64_t from, int64_t to) {
      int64_t cells_of_part = 0;
      for (int64_t block = from; block < to; ++block) {
        Below& below = all[static_cast<size_t>(block)];
        visitIndices(pyramid_.childrenOf(level, blocks.indexOf(block)), [&](Vec3i child) {
          const Below more = level == 1 ? finestOf(child) : belowOf(level - 1, child);
          if (more.hull.empty()) return;
          below.hull = unite(below.hull, more.hull);
          below.least_extent = min(below.least_extent, more.least_extent);
          if (level == 1) cells_of_part += more.hull.count();
        });
      }
      cells += cells_of_part;
    });
  }
  finest_cells_ = cells;
}

ShownLevels::Below ShownLevels::finestOf(Vec3i index) const {
  const Box3 cells = boxes_[0]->of(index);
  return cells.empty() ? Below() : Below{cells, extentOf(index, cells)};
}

// The extent of an object box with what continues it in the next blocks; kAnyExtent if a face of
// the crop ends it.
Vec3i ShownLevels::extentOf(Vec3i index, const Box3& cells) const {
  Vec3i extent = boxes_[0]->extentWithNeighbors(index);
  const Box3 all = boxOf(pyramid_.finest().dims - Vec3i{1, 1, 1});
  for (int a = 0; a < 3; ++a) {
    const bool is_cut_below = cells.lo[a] == crop_.lo[a] && crop_.lo[a] > all.lo[a];
    const bool is_cut_above = cells.hi[a] == crop_.hi[a] && crop_.hi[a] < all.hi[a];
    if (is_cut_below || is_cut_above) extent[a] = kAnyExtent;
  }
  return extent;
}

bool ShownLevels::hasThinParts(int level, Vec3i index) const {
  const Vec3d scale = pyramid_.level(level).placement.scale;
  const Vec3i extent = belowOf(level, index).least_extent;
  for (int a = 0; a < 3; ++a)
    if (static_cast<double>(extent[a]) < kThinVoxels * scale[a]) return true;
  return false;
}

const ShownLevels::Below& ShownLevels::belowOf(int level, Vec3i index) const {
  const int64_t block = pyramid_.level(level).blocks.idOf(index);
  return below_[static_cast<size_t>(level)][static_cast<size_t>(block)];
}

Box3 ShownLevels::finestBox(int level, Vec3i index) const {
  if (level == 0) return boxes_[0]->of(index);
  return isAsFinest(level) ? reachIn(level, index) : belowOf(level, index).hull;
}

// What the finest level shows below this block and those beside it, with the cells around that
// interpolate the level's voxels which stand for it.
Box3 ShownLevels::reachIn(int level, Vec3i index) const {
  const LevelLayout& at = pyramid_.level(level);
  const Box3 region = pyramid_.regionOf(level, index);
  const auto reachOf = [&](Vec3i block) {
    const Box3& hull = belowOf(level, block).hull;
    return hull.empty() ? Box3() : intersect(at.cellsOver(cellsAround(at, hull)), region);
  };
  Box3 reach = reachOf(index);
  // Inside a solid body the neighbours add nothing.
  if (reach == region) return reach;
  const Vec3i one{1, 1, 1};
  visitIndices(intersect({index - one, index + one + one}, boxOf(at.blocks.grid)),
               [&](Vec3i block) { reach = unite(reach, reachOf(block)); });
  return reach;
}

// The hull of the visible cells of this block and its neighbours: a level's cells are shifted
// against the regions, so that one cell may lie in the regions of two blocks.
Box3 ShownLevels::cellsShown(int level, Vec3i index, const Box3& region) const {
  const LevelLayout& at = pyramid_.level(level);
  const Vec3i last = at.blocks.dims - Vec3i{1, 1, 1}, end = pyramid_.finest().dims - Vec3i{1, 1, 1};
  // Blocks that own cells in the region: a neighbour too, if the shift leads there.
  Box3 owners{index, index + Vec3i{1, 1, 1}};
  const Box3 own{index * at.blocks.cells(), (index + Vec3i{1, 1, 1}) * at.blocks.cells()};
  const Box3 covered = at.cellsOver(own);
  for (int a = 0; a < 3; ++a) {
    if (covered.lo[a] > region.lo[a] && owners.lo[a] > 0) --owners.lo[a];
    if (covered.hi[a] < region.hi[a] && owners.hi[a] < at.blocks.grid[a]) ++owners.hi[a];
  }
  Box3 shown;
  visitIndices(owners, [&](Vec3i owner) {
    const Box3 object = boxes_[static_cast<size_t>(level)]->of(owner);
    if (object.empty()) return;
    Box3 cells = at.cellsOver(object);
    // Beyond its outermost voxels a level shows their values.
    for (int a = 0; a < 3; ++a) {
      if (object.lo[a] == 0) cells.lo[a] = 0;
      if (object.hi[a] == last[a]) cells.hi[a] = end[a];
    }
    shown = unite(shown, intersect(cells, region));
  });
  return shown;
}

std::optional<ObjectBlock> ShownLevels::partOf(int level, Vec3i index, int64_t time) const {
  const Box3 finest = finestBox(level, index);
  if (finest.empty()) return std::nullopt;
  return objectOf(level, index, time, finest);
}

ObjectBlock ShownLevels::objectOf(int level, Vec3i index, int64_t time) const {
  return objectOf(level, index, time, finestBox(level, index));
}

ObjectBlock ShownLevels::objectOf(int level, Vec3i index, int64_t time, const Box3& finest) const {
  ObjectBlock object;
  const LevelLayout& at = pyramid_.level(level);
  const int64_t block = at.blocks.idOf(index);
  object.name = {.time = time, .level = level, .block = block};
  const Box3 region = pyramid_.regionOf(level, index);
  if (isAsFinest(level))
    object.cells = finest;
  else
    object.cells = boxes_[static_cast<size_t>(level)] ? cellsShown(level, index, region) : region;
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
