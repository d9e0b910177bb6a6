#include "src/render/blocks/shown_levels.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <utility>

namespace sluice {
namespace {

constexpr int64_t kAnyExtent = INT64_MAX;
constexpr uint32_t kNoPlace = UINT32_MAX;
// A part that is thinner may lie in one voxel with as much of something else.
constexpr double kThinVoxels = 2;

// Whether boxes that meet at a face across `axis` have a part of it in common.
bool meet(const Box3& a, const Box3& b, int axis) {
  for (int other = 0; other < 3; ++other)
    if (other != axis && (a.lo[other] > b.hi[other] || b.lo[other] > a.hi[other])) return false;
  return true;
}

// Calls `call` for 0 to `count` on all threads of the pool, so many in a row that handing them out
// costs little.
template <class Call>
void inParts(WorkerPool& pool, size_t count, const Call& call) {
  constexpr size_t kPart = 512;
  pool.parallelFor(static_cast<int64_t>((count + kPart - 1) / kPart), [&](int64_t part) {
    const size_t from = static_cast<size_t>(part) * kPart;
    for (size_t i = from; i < std::min(count, from + kPart); ++i) call(i);
  });
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
  for (size_t level = 0; level < levels_.size(); ++level) {
    const auto blocks = pyramid_.level(static_cast<int>(level)).blocks.blockCount();
    std::vector<uint32_t>& places = places_.emplace_back(static_cast<size_t>(blocks), kNoPlace);
    for (size_t i = 0; i < levels_[level].blocks.size(); ++i)
      places[static_cast<size_t>(levels_[level].blocks[i].name.block)] = static_cast<uint32_t>(i);
  }
  boundFinest(pool);
}

void ShownLevels::boundFinest(WorkerPool& pool) {
  const std::vector<ObjectBlock>& objects = levels_[0].blocks;
  std::vector<Vec3i> object_extents(objects.size());
  inParts(pool, objects.size(), [&](size_t i) { object_extents[i] = extentOf(objects[i]); });
  for (const ObjectBlock& object : levels_[0].blocks) finest_cells_ += object.cells.count();
  finest_boxes_.resize(1);
  reaches_.resize(1);
  least_extents_.resize(1);
  for (int level = 1; level < pyramid_.levels(); ++level) {
    const LevelLayout& at = pyramid_.level(level);
    std::vector<Box3> boxes(static_cast<size_t>(at.blocks.blockCount()));
    std::vector<Vec3i> extents(boxes.size(), {kAnyExtent, kAnyExtent, kAnyExtent});
    const auto add = [&](const Box3& cells, Vec3i extent) {
      const Vec3i index = min(cells.lo / at.width, at.blocks.grid - Vec3i{1, 1, 1});
      const auto block = static_cast<size_t>(at.blocks.idOf(index));
      boxes[block] = unite(boxes[block], cells);
      extents[block] = min(extents[block], extent);
    };
    if (level == 1)
      for (size_t i = 0; i < objects.size(); ++i) add(objects[i].cells, object_extents[i]);
    else
      for (size_t i = 0; i < finest_boxes_.back().size(); ++i)
        if (!finest_boxes_.back()[i].empty())
          add(finest_boxes_.back()[i], least_extents_.back()[i]);
    finest_boxes_.push_back(std::move(boxes));
    least_extents_.push_back(std::move(extents));
    std::vector<Box3>& reaches = reaches_.emplace_back();
    if (!hasSpreads(level)) continue;
    reaches.resize(finest_boxes_.back().size());
    inParts(pool, reaches.size(), [&](size_t block) {
      reaches[block] = reachIn(level, at.blocks.indexOf(static_cast<int64_t>(block)));
    });
  }
}

// The extent of an object box with what continues it in the next blocks; kAnyExtent if a face of
// the crop ends it.
Vec3i ShownLevels::extentOf(const ObjectBlock& object) const {
  const BlockLayout& layout = pyramid_.finest();
  const Vec3i index = layout.indexOf(object.name.block);
  const Box3 owned = layout.ownedCells(index);
  Vec3i extent = object.cells.size();
  for (int a = 0; a < 3; ++a)
    for (const bool is_upper : {false, true}) {
      const auto faceOf = [&](const Box3& box) { return is_upper ? box.hi[a] : box.lo[a]; };
      const int64_t face = faceOf(object.cells);
      if (face == faceOf(crop_) && face > 0 && face < layout.dims[a] - 1) {
        extent[a] = kAnyExtent;
        break;
      }
      Vec3i beside = index;
      beside[a] += is_upper ? 1 : -1;
      if (face != faceOf(owned) || beside[a] < 0 || beside[a] >= layout.grid[a]) continue;
      const ObjectBlock* next = find(0, layout.idOf(beside));
      if (next == nullptr || (is_upper ? next->cells.lo[a] : next->cells.hi[a]) != face) continue;
      if (meet(object.cells, next->cells, a)) extent[a] += next->cells.size()[a];
    }
  return extent;
}

bool ShownLevels::hasThinParts(int level, Vec3i index) const {
  const LevelLayout& at = pyramid_.level(level);
  const Vec3i extent =
      least_extents_[static_cast<size_t>(level)][static_cast<size_t>(at.blocks.idOf(index))];
  for (int a = 0; a < 3; ++a)
    if (static_cast<double>(extent[a]) < kThinVoxels * at.placement.scale[a]) return true;
  return false;
}

Box3 ShownLevels::finestBox(int level, Vec3i index) const {
  const int64_t block = pyramid_.level(level).blocks.idOf(index);
  if (level == 0) {
    const ObjectBlock* object = find(0, block);
    return object == nullptr ? Box3() : object->cells;
  }
  return (hasSpreads(level)
              ? reaches_
              : finest_boxes_)[static_cast<size_t>(level)][static_cast<size_t>(block)];
}

// What the finest level shows below this block and those beside it, with the cells around that
// interpolate the level's voxels which stand for it.
Box3 ShownLevels::reachIn(int level, Vec3i index) const {
  const LevelLayout& at = pyramid_.level(level);
  const Box3 region = pyramid_.regionOf(level, index);
  const Box3 around =
      intersect({index - Vec3i{1, 1, 1}, index + Vec3i{2, 2, 2}}, boxOf(at.blocks.grid));
  Box3 reach;
  for (int64_t z = around.lo.z; z < around.hi.z; ++z)
    for (int64_t y = around.lo.y; y < around.hi.y; ++y)
      for (int64_t x = around.lo.x; x < around.hi.x; ++x) {
        const auto block = static_cast<size_t>(at.blocks.idOf({x, y, z}));
        const Box3& box = finest_boxes_[static_cast<size_t>(level)][block];
        if (box.empty()) continue;
        reach = unite(reach, intersect(at.cellsOver(cellsAround(at, box)), region));
      }
  return reach;
}

const ObjectBlock* ShownLevels::find(int level, int64_t block) const {
  const auto at = static_cast<size_t>(level);
  const uint32_t place = places_[at][static_cast<size_t>(block)];
  return place == kNoPlace ? nullptr : &levels_[at].blocks[place];
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
  if (level == 0 || hasSpreads(level))
    object.cells = finestBox(level, index);
  else
    object.cells =
        is_known_[static_cast<size_t>(level)] ? cellsShown(level, index, region) : region;
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
