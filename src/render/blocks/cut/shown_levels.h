// ShownLevels: the visible parts of each level of a time step under one look, whatever the view.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <unordered_map>
#include <vector>

#include "src/base/threads/worker_pool.h"
#include "src/classify/blocks/object_boxes.h"
#include "src/render/blocks/cut/range_tree.h"
#include "src/render/blocks/visible_blocks.h"
#include "src/volume/pyramid.h"

namespace sluice {

// Whether a coarser level of the step shows what the finest one does (showsAsFinest()), and nothing
// of its own.
bool followsFinest(const TimeStep& step);

// The blocks that are asked for are classified, and no others: of a million blocks, a picture of
// coarse levels needs the few that bound what shows.
//
// A finest level that nobody has listed (SliceRanges::is_listed) tells nothing about the levels
// above it. It is listed when its own blocks are asked for, as are other levels that nobody
// has read: a picture of coarse levels lists few files.
//
// One thread at a time.
class ShownLevels {
 public:
  // `tree`: of the step's finest ranges; null if they are not listed. `pool` must outlive this, as
  // the step's sources must. Requires: the finest level is listed, or no level follows it. This and
  // the other functions throw Error as classify() does, and from sources that are listed.
  ShownLevels(const TimeStep& step, LookPtr look, const Box3& crop,
              std::shared_ptr<const RangeTree> tree, WorkerPool& pool);

  const PyramidLayout& pyramid() const { return pyramid_; }
  // The share of the finest cells in object boxes of the finest level that a cut shows coarser, if
  // it shows so many of them at the finest level.
  double coarseShare(int64_t shown_finest);
  // Whether the finest level shows something in the block's region that is thinner than two voxels
  // of the block's level along an axis. Parts that go on in the next block of the finest level
  // count with it; faces of the crop make nothing thin. Of a surface it is what lies on either of
  // its sides: a thin sheet or gap, of which the level's means may pass the surface's value
  // nowhere. False if the finest level is not listed. Requires: level > 0.
  bool hasThinParts(int level, Vec3i index);
  // The finest cells of a finest block that show something.
  int64_t finestCells(Vec3i index) { return boxesOf(0)->of(index).count(); }
  // Returns the part of a block of time step `time` that is drawn at its level: the box of the
  // finest cells in its region where interpolation of the level's voxels gives something visible;
  // under a look with surfaces, of all cells of the level within one of its voxels of such a place
  // (see FrameSetup::has_surfaces). A level with spreads, of extremes or of modes shows what the
  // finest level shows; if the ranges of another level are not known, the whole region shows. No
  // cells: nothing.
  ObjectBlock objectOf(int level, Vec3i index, int64_t time);
  // The same for a block that has a part in the picture because of what the finest level shows:
  // something in its region, or, if its level shows as the finest one does, as far beyond as
  // interpolation carries it. nullopt: it has none.
  std::optional<ObjectBlock> partOf(int level, Vec3i index, int64_t time);

 private:
  static constexpr int64_t kAnyExtent = INT64_MAX;
  using Shown = ObjectBoxes::Shown;

  // The object boxes of a level by its own ranges, in its own cells; null if the level follows the
  // finest one, or if nothing is known of it.
  ObjectBoxes* boxesOf(int level);
  std::unique_ptr<ObjectBoxes> madeBoxes(int level) const;
  // How much of the region of a block shows at the finest level, as far as its ranges tell at once.
  Shown shownBelow(int level, Vec3i index);
  // The hull of the finest level's object boxes in the region of a block, in finest cells.
  const Box3& hullOf(int level, Vec3i index);
  // Widens a hull by parts of the block's region, so that it reaches as far along the axis as what
  // the finest level shows there.
  enum class Face { kLow, kHigh };
  void reachFace(int level, Vec3i index, int axis, Face face, Box3& hull);
  int64_t cellsBelow(int level, Vec3i index);
  bool hasThinner(int level, Vec3i index, const Vec3d& least);
  Vec3i leastExtentOfWhole(int level, Vec3i index) const;
  Vec3i extentOf(Vec3i index, const Box3& cells);
  Box3 cropped(int level, Vec3i index) const {
    return intersect(pyramid_.regionOf(level, index), crop_);
  }
  Box3 finestBox(int level, Vec3i index);
  Box3 reachIn(int level, Vec3i index);
  Box3 boxesAround(Vec3i index);
  // The values on each side of each surface, without surfaces; none if the look has no surfaces.
  std::vector<std::unique_ptr<ShownLevels>>& sides();
  Box3 cellsShown(int level, Vec3i index, const Box3& region);
  ObjectBlock objectOf(int level, Vec3i index, int64_t time, const Box3& finest);
  // See showsAsFinest(); true of the finest level itself.
  bool isAsFinest(int level) const { return is_as_finest_[static_cast<size_t>(level)]; }
  bool isListed() const { return tree_ != nullptr; }
  bool hasSurfaces() const { return !look_->table.surfaces().empty(); }

  const TimeStep step_;
  const LookPtr look_;
  const PyramidLayout pyramid_;
  const Box3 crop_;
  const std::shared_ptr<const RangeTree> tree_;
  WorkerPool& pool_;
  std::vector<bool> is_as_finest_;  // for each level
  struct Level {
    bool has_boxes = false;                   // boxes were made, or are none
    std::unique_ptr<ObjectBoxes> boxes;       // see boxesOf()
    std::unordered_map<int64_t, Box3> hulls;  // of the blocks that were asked for
    std::unordered_map<int64_t, bool> thin;
  };
  std::vector<Level> levels_;
  std::optional<int64_t> finest_cells_;              // in all object boxes of the finest level
  std::vector<std::unique_ptr<ShownLevels>> sides_;  // see sides()
};

}  // namespace sluice
