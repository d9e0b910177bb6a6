// ShownLevels: the visible parts of each level of a time step under one look, whatever the view.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "src/base/threads/worker_pool.h"
#include "src/classify/blocks/object_boxes.h"
#include "src/render/blocks/visible_blocks.h"
#include "src/volume/pyramid.h"

namespace sluice {

// Immutable once made; any thread may read.
class ShownLevels {
 public:
  // Classifies all blocks of the finest level, and of levels that do not show as it does and whose
  // ranges are known, on all threads of `pool`. Throws Error as classify() does.
  ShownLevels(const TimeStep& step, const Look& look, const Box3& crop, WorkerPool& pool);

  const PyramidLayout& pyramid() const { return pyramid_; }
  // Finest cells in object boxes of the finest level.
  int64_t finestCells() const { return finest_cells_; }
  // Whether the finest level shows something in the block's region that is thinner than two voxels
  // of the block's level along an axis. Parts that go on in the next block of the finest level
  // count with it; faces of the crop make nothing thin. Requires: level > 0.
  bool hasThinParts(int level, Vec3i index) const;
  // What is drawn of a block of time step `time` at its level: the box of the finest cells in its
  // region where interpolation of the level's voxels gives something visible. A level with spreads,
  // of extremes or of modes shows what the finest level shows; if the ranges of another level are
  // not known, the whole region shows. No cells: nothing.
  ObjectBlock objectOf(int level, Vec3i index, int64_t time) const;
  // The same for a block that has a part in the picture because of what the finest level shows:
  // something in its region, or, if its level shows as the finest one does, as far beyond as
  // interpolation carries it. nullopt: it has none.
  std::optional<ObjectBlock> partOf(int level, Vec3i index, int64_t time) const;

 private:
  static constexpr int64_t kAnyExtent = INT64_MAX;

  // The finest level's object boxes in the region of a block: their hull, and their least extents
  // along each axis. Both are in finest cells.
  struct Below {
    Box3 hull;
    Vec3i least_extent{kAnyExtent, kAnyExtent, kAnyExtent};
  };

  void boundFinest(WorkerPool& pool);
  Below finestOf(Vec3i index) const;  // for a block of the finest level itself
  const Below& belowOf(int level, Vec3i index) const;
  Vec3i extentOf(Vec3i index, const Box3& cells) const;
  Box3 finestBox(int level, Vec3i index) const;
  Box3 reachIn(int level, Vec3i index) const;
  Box3 cellsShown(int level, Vec3i index, const Box3& region) const;
  ObjectBlock objectOf(int level, Vec3i index, int64_t time, const Box3& finest) const;
  // See showsAsFinest(); true of the finest level itself.
  bool isAsFinest(int level) const { return is_as_finest_[static_cast<size_t>(level)]; }

  const PyramidLayout pyramid_;
  const Box3 crop_;
  std::vector<bool> is_as_finest_;  // for each level
  // By each level's own ranges, in the level's own cells; none for a level that shows what the
  // finest one shows, or of which nothing is known.
  std::vector<std::optional<ObjectBoxes>> boxes_;
  std::vector<std::vector<Below>> below_;  // for the blocks of each level but the finest
  int64_t finest_cells_ = 0;
};

}  // namespace sluice
