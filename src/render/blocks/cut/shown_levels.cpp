#include "src/render/blocks/cut/shown_levels.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <utility>

#include "src/base/error.h"
#include "src/render/blocks/cut/surface_sides.h"

namespace sluice {
namespace {

// A part that is thinner may lie in one voxel with as much of something else.
constexpr double kThinVoxels = 2;
// Rounding of scales and offsets that files give as decimals, in voxels.
constexpr double kOwnerRounding = 1e-6;

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

// The level's cells that touch a voxel of it which stands for some voxel of these finest cells, and
// `more` cells on each side of them.
Box3 cellsAround(const LevelLayout& level, const Box3& finest, int64_t more) {
  const auto voxelOf = [&](Vec3i voxel, int a) {
    return static_cast<int64_t>(std::lround(level.placement.levelFromFinest(toDouble(voxel))[a]));
  };
  Box3 cells;
  for (int a = 0; a < 3; ++a) {
    cells.lo[a] = voxelOf(finest.lo, a) - 1 - more;
    cells.hi[a] = voxelOf(finest.hi, a) + 1 + more;
  }
  return cells;
}

}  // namespace

bool followsFinest(const TimeStep& step) {
  return std::ranges::any_of(step.coarser, [](const CoarserStep& level) {
    return showsAsFinest(level.values, level.spreads != nullptr);
  });
}

ShownLevels::ShownLevels(const TimeStep& step, LookPtr look, const Box3& crop,
                         std::shared_ptr<const RangeTree> tree, WorkerPool& pool)
    : step_(step),
      look_(std::move(look)),
      pyramid_(step.layout()),
      crop_(crop),
      tree_(std::move(tree)),
      pool_(pool),
      is_as_finest_{true},
      levels_(static_cast<size_t>(pyramid_.levels())) {
  SLUICE_CHECK_EQ(isListed(), step_.ranges->is_listed);
  SLUICE_CHECK(isListed() || !followsFinest(step_));
  for (const CoarserStep& level : step_.coarser)
    is_as_finest_.push_back(showsAsFinest(level.values, level.spreads != nullptr));
  if (isListed()) boxesOf(0);  // throws if too much would show
}

ObjectBoxes* ShownLevels::boxesOf(int level) {
  Level& of = levels_[static_cast<size_t>(level)];
  if (!of.has_boxes) of.boxes = madeBoxes(level);
  of.has_boxes = true;
  return of.boxes.get();
}

std::unique_ptr<ObjectBoxes> ShownLevels::madeBoxes(int level) const {
  if (level == 0)
    return std::make_unique<ObjectBoxes>(listedRanges(step_.ranges, *step_.source, step_.time),
                                         look_->table, crop_);
  if (isAsFinest(level)) return nullptr;
  const CoarserStep& coarser = step_.coarser[static_cast<size_t>(level) - 1];
  const BlockLayout& blocks = pyramid_.level(level).blocks;
  // The level's own ranges may come from an index. Otherwise its source is listed, if the finest
  // level is not.
  std::shared_ptr<const SliceRanges> ranges = coarser.ranges;
  if (ranges == nullptr && !isListed())
    ranges =
        std::make_shared<const SliceRanges>(unknownRanges(*coarser.source, step_.time, blocks));
  if (ranges == nullptr) return nullptr;
  return std::make_unique<ObjectBoxes>(std::move(ranges), look_->table,
                                       boxOf(blocks.dims - Vec3i{1, 1, 1}));
}

double ShownLevels::coarseShare(int64_t shown_finest) {
  // If the picture shows coarser levels alone, the number of cells does not matter.
  if (shown_finest == 0) {
    if (!isListed()) return crop_.empty() ? 0 : 1;
    const int top = pyramid_.levels() - 1;
    bool shows_any = false;
    visitIndices(boxOf(pyramid_.level(top).blocks.grid),
                 [&](Vec3i index) { shows_any = shows_any || !hullOf(top, index).empty(); });
    return shows_any ? 1 : 0;
  }
  if (!finest_cells_ && !isListed()) finest_cells_ = boxesOf(0)->cellCount(pool_);
  if (!finest_cells_) {
    // Blocks of level 2 have many finest blocks below them, enough for a thread. Threads look at
    // different ones, so that they share no state.
    const int level = std::min(2, pyramid_.levels() - 1);
    const BlockLayout& blocks = pyramid_.level(level).blocks;
    std::atomic<int64_t> cells = 0;
    inParts(pool_, blocks.blockCount(), [&](int64_t from, int64_t to) {
      int64_t of_part = 0;
      for (int64_t block = from; block < to; ++block)
        of_part += cellsBelow(level, blocks.indexOf(block));
      cells += of_part;
    });
    finest_cells_ = cells;
  }
  return 1 - static_cast<double>(shown_finest) / static_cast<double>(*finest_cells_);
}

ShownLevels::Shown ShownLevels::shownBelow(int level, Vec3i index) {
  const RangeTree::Node& node = tree_->of(level, pyramid_.level(level).blocks.idOf(index));
  const Shown of_known = boxesOf(0)->shownBetween(node.lo, node.hi);
  if (!node.has_unknown) return of_known;
  // Anything may show in unknown blocks.
  return of_known == Shown::kEverything || node.lo > node.hi ? Shown::kEverything
                                                             : Shown::kSomething;
}

const Box3& ShownLevels::hullOf(int level, Vec3i index) {
  const int64_t block = pyramid_.level(level).blocks.idOf(index);
  const auto [at, is_new] = levels_[static_cast<size_t>(level)].hulls.try_emplace(block);
  Box3& hull = at->second;
  if (!is_new) return hull;
  for (int axis = 0; axis < 3; ++axis)
    // Both faces of each axis bound the hull. What lies between them is never looked at.
    for (const Face face : {Face::kLow, Face::kHigh}) {
      reachFace(level, index, axis, face, hull);
      if (hull.empty()) return hull;  // nothing shows
    }
  return hull;
}

// The part that reaches farthest beyond the hull so far is looked at first, and the search ends
// when no part reaches beyond it. So few blocks of a surface are ever looked at, and the inside of
// a body never is.
void ShownLevels::reachFace(int level, Vec3i index, int axis, Face face, Box3& hull) {
  struct Part {
    int64_t reach = 0;  // how far its region reaches towards the face
    int level = 0;
    Vec3i index;
    // The first to be looked at is the greatest: of equals the finest, which tells most.
    bool operator<(const Part& other) const {
      return reach != other.reach ? reach < other.reach : level > other.level;
    }
  };
  const auto reachOf = [&](const Box3& box) {
    return face == Face::kLow ? -box.lo[axis] : box.hi[axis];
  };
  const auto isBeyond = [&](int64_t reach) { return hull.empty() || reach > reachOf(hull); };
  // Parts whose region may reach beyond the hull, and show in part.
  std::vector<Part> parts;
  const auto add = [&](int of_level, Vec3i at) {
    const Box3 region = cropped(of_level, at);
    const int64_t reach = reachOf(region);
    if (region.empty() || !isBeyond(reach)) return;
    const Shown shown = of_level == 0 ? Shown::kSomething : shownBelow(of_level, at);
    // All of the region shows, so that nothing in it needs a look.
    if (shown == Shown::kEverything) hull = unite(hull, region);
    if (shown != Shown::kSomething) return;
    parts.push_back({reach, of_level, at});
    std::push_heap(parts.begin(), parts.end());
  };
  add(level, index);
  while (!parts.empty() && isBeyond(parts.front().reach)) {
    std::pop_heap(parts.begin(), parts.end());
    const Part part = parts.back();
    parts.pop_back();
    if (part.level == 0)
      hull = unite(hull, boxesOf(0)->of(part.index));
    else
      visitIndices(pyramid_.childrenOf(part.level, part.index),
                   [&](Vec3i child) { add(part.level - 1, child); });
  }
}

int64_t ShownLevels::cellsBelow(int level, Vec3i index) {
  if (level == 0) return boxesOf(0)->of(index).count();
  const Shown shown = shownBelow(level, index);
  if (shown == Shown::kEverything) return cropped(level, index).count();
  int64_t cells = 0;
  if (shown == Shown::kSomething)
    visitIndices(pyramid_.childrenOf(level, index),
                 [&](Vec3i child) { cells += cellsBelow(level - 1, child); });
  return cells;
}

// The extent of an object box with what continues it in the next blocks; kAnyExtent if a face of
// the crop ends it.
Vec3i ShownLevels::extentOf(Vec3i index, const Box3& cells) {
  Vec3i extent = boxesOf(0)->extentWithNeighbors(index);
  // A face of the crop ends nothing in the volume, so that it makes nothing thin.
  const Box3 all = boxOf(pyramid_.finest().dims - Vec3i{1, 1, 1});
  for (int a = 0; a < 3; ++a) {
    const bool is_cut_below = cells.lo[a] == crop_.lo[a] && crop_.lo[a] > all.lo[a];
    const bool is_cut_above = cells.hi[a] == crop_.hi[a] && crop_.hi[a] < all.hi[a];
    if (is_cut_below || is_cut_above) extent[a] = kAnyExtent;
  }
  return extent;
}

// No extent of a finest block in the region of this one, all of which shows, is less: a block has
// at least the next one beside it, unless it is alone or the crop cuts that one.
Vec3i ShownLevels::leastExtentOfWhole(int level, Vec3i index) const {
  const int64_t block = pyramid_.level(level).blocks.idOf(index);
  const Box3 blocks = pyramid_.finestBlocksOf({.level = level, .block = block});
  const Box3 region = pyramid_.regionOf(level, index), shown = intersect(region, crop_);
  const BlockLayout& finest = pyramid_.finest();
  Vec3i least;
  for (int a = 0; a < 3; ++a) {
    // The last finest block has the rest of the volume, which may be less than a whole block.
    const int64_t last = region.hi[a] - (blocks.hi[a] - 1) * finest.cells();
    const bool is_cut = shown.lo[a] != region.lo[a] || shown.hi[a] != region.hi[a];
    const bool is_alone = blocks.size()[a] == 1;
    least[a] = std::min(last, finest.cells()) + (is_cut || is_alone ? 0 : finest.cells());
  }
  return least;
}

bool ShownLevels::hasThinParts(int level, Vec3i index) {
  if (!isListed()) return false;
  const int64_t block = pyramid_.level(level).blocks.idOf(index);
  const auto [at, is_new] = levels_[static_cast<size_t>(level)].thin.try_emplace(block);
  if (!is_new) return at->second;
  if (hasSurfaces())
    at->second = shownBelow(level, index) != Shown::kNothing &&
                 std::ranges::any_of(sides(), [&](const std::unique_ptr<ShownLevels>& side) {
                   return side->hasThinParts(level, index);
                 });
  else
    at->second = hasThinner(level, index, pyramid_.level(level).placement.scale * kThinVoxels);
  return at->second;
}

std::vector<std::unique_ptr<ShownLevels>>& ShownLevels::sides() {
  if (sides_.empty())
    for (const LookPtr& side : looksBesideSurfaces(step_, *look_))
      sides_.push_back(std::make_unique<ShownLevels>(step_, side, crop_, tree_, pool_));
  return sides_;
}

// Whether an object box of the finest level in the region of the block has a lesser extent.
bool ShownLevels::hasThinner(int level, Vec3i index, const Vec3d& least) {
  const auto isThinner = [&](Vec3i extent) {
    for (int a = 0; a < 3; ++a)
      if (static_cast<double>(extent[a]) < least[a]) return true;
    return false;
  };
  if (level == 0) {
    const Box3 cells = boxesOf(0)->of(index);
    return !cells.empty() && isThinner(extentOf(index, cells));
  }
  if (cropped(level, index).empty()) return false;
  const Shown shown = shownBelow(level, index);
  // If everything shows, no box of a finest block is less than this without a look at them.
  if (shown == Shown::kNothing ||
      (shown == Shown::kEverything && !isThinner(leastExtentOfWhole(level, index))))
    return false;
  const Box3 children = pyramid_.childrenOf(level, index);
  for (int64_t z = children.lo.z; z < children.hi.z; ++z)
    for (int64_t y = children.lo.y; y < children.hi.y; ++y)
      for (int64_t x = children.lo.x; x < children.hi.x; ++x)
        if (hasThinner(level - 1, {x, y, z}, least)) return true;
  return false;
}

Box3 ShownLevels::finestBox(int level, Vec3i index) {
  if (level == 0) return hasSurfaces() ? boxesAround(index) : boxesOf(0)->of(index);
  if (!isListed()) return cropped(level, index);
  return isAsFinest(level) || hasSurfaces() ? reachIn(level, index) : hullOf(level, index);
}

// The cells of a finest block within a voxel of its object box or of those beside it.
Box3 ShownLevels::boxesAround(Vec3i index) {
  const Vec3i one{1, 1, 1};
  const Box3 region = cropped(0, index);
  Box3 box;
  // Samples beside a surface show it from the next block, too.
  visitIndices(intersect({index - one, index + one + one}, boxOf(pyramid_.finest().grid)),
               [&](Vec3i block) {
                 const Box3 shown = boxesOf(0)->of(block);
                 if (shown.empty()) return;
                 box = unite(box, intersect({shown.lo - one, shown.hi + one}, region));
               });
  return box;
}

// Returns the box of the finest cells that show something below this block and those beside it,
// with the cells around that interpolate the level's voxels which stand for them.
Box3 ShownLevels::reachIn(int level, Vec3i index) {
  const LevelLayout& at = pyramid_.level(level);
  const Box3 region = pyramid_.regionOf(level, index);
  const auto reachOf = [&](Vec3i block) {
    const Box3& hull = hullOf(level, block);
    const int64_t more = hasSurfaces() ? 1 : 0;
    return hull.empty() ? Box3() : intersect(at.cellsOver(cellsAround(at, hull, more)), region);
  };
  Box3 reach = reachOf(index);
  // Inside a solid body the neighbours add nothing.
  if (reach == region) return reach;
  // Interpolation carries what the neighbours show into this region, by part of a voxel.
  const Vec3i one{1, 1, 1};
  visitIndices(intersect({index - one, index + one + one}, boxOf(at.blocks.grid)),
               [&](Vec3i block) { reach = unite(reach, reachOf(block)); });
  return reach;
}

// The hull of the visible cells of this block and its neighbours: a level's cells are shifted
// against the regions, so that one cell may lie in the regions of two blocks.
Box3 ShownLevels::cellsShown(int level, Vec3i index, const Box3& region) {
  const LevelLayout& at = pyramid_.level(level);
  const Vec3i last = at.blocks.dims - Vec3i{1, 1, 1}, end = pyramid_.finest().dims - Vec3i{1, 1, 1};
  // Blocks that own cells in the region: a neighbour too, if the shift leads there.
  Box3 owners{index, index + Vec3i{1, 1, 1}};
  const Box3 own{index * at.blocks.cells(), (index + Vec3i{1, 1, 1}) * at.blocks.cells()};
  // Not rounded to whole finest cells, of which a part may be the neighbour's.
  const Vec3d lo = at.placement.finestFromLevel(toDouble(own.lo));
  const Vec3d hi = at.placement.finestFromLevel(toDouble(own.hi));
  for (int a = 0; a < 3; ++a) {
    const auto first = static_cast<double>(region.lo[a]), end = static_cast<double>(region.hi[a]);
    if (lo[a] > first + kOwnerRounding && owners.lo[a] > 0) --owners.lo[a];
    if (hi[a] < end - kOwnerRounding && owners.hi[a] < at.blocks.grid[a]) ++owners.hi[a];
  }
  Box3 shown;
  // Samples beside a surface look at the cells around them.
  const Vec3i around = hasSurfaces() ? Vec3i{1, 1, 1} : Vec3i();
  owners = intersect({owners.lo - around, owners.hi + around}, boxOf(at.blocks.grid));
  visitIndices(owners, [&](Vec3i owner) {
    Box3 object = boxesOf(level)->of(owner);
    if (object.empty()) return;
    object = intersect({object.lo - around, object.hi + around}, boxOf(last));
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

std::optional<ObjectBlock> ShownLevels::partOf(int level, Vec3i index, int64_t time) {
  const Box3 finest = finestBox(level, index);
  // Nothing of the finest level reaches here: the block is left out, whatever its own level holds.
  if (finest.empty()) return std::nullopt;
  return objectOf(level, index, time, finest);
}

ObjectBlock ShownLevels::objectOf(int level, Vec3i index, int64_t time) {
  return objectOf(level, index, time, finestBox(level, index));
}

ObjectBlock ShownLevels::objectOf(int level, Vec3i index, int64_t time, const Box3& finest) {
  ObjectBlock object;
  const LevelLayout& at = pyramid_.level(level);
  const int64_t block = at.blocks.idOf(index);
  object.name = {.time = time, .level = level, .block = block};
  const Box3 region = pyramid_.regionOf(level, index);
  if (isAsFinest(level))
    object.cells = finest;
  else  // without ranges of its own, anything may show
    object.cells = boxesOf(level) != nullptr ? cellsShown(level, index, region) : region;
  object.cells = intersect(object.cells, crop_);
  if (object.cells.empty()) {
    object.cells = {};
    return object;
  }
  object.kind = object.cells == region ? BlockClass::kBlack : BlockClass::kGrey;
  object.trimming_axis = shortestAxis(at.voxelsUnder(object.cells).size());
  return object;
}

}  // namespace sluice
