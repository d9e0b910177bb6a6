// ShownLevels: the visible parts of each level of a time step under one look, whatever the view.
#pragma once

#include <cstdint>
#include <vector>

#include "src/base/threads/worker_pool.h"
#include "src/render/blocks/visible_blocks.h"
#include "src/volume/pyramid.h"

namespace sluice {

// Immutable once made; any thread may read.
class ShownLevels {
 public:
  // Classifies all blocks of every level whose ranges are known, on all threads of `pool`. Throws
  // Error as classify() does.
  ShownLevels(const TimeStep& step, const Look& look, const Box3& crop, WorkerPool& pool);

  const PyramidLayout& pyramid() const { return pyramid_; }
  // Finest cells in object boxes of the finest level.
  int64_t finestCells() const { return finest_cells_; }
  // Whether a block has a part in the picture because of what the finest level shows: something in
  // its region, or, if its level has spreads, as far beyond as interpolation carries it.
  bool showsFinest(int level, Vec3i index) const { return !finestBox(level, index).empty(); }
  // Whether the finest level shows something in the block's region that is thinner than two voxels
  // of the block's level along an axis. Parts that go on in the next block of the finest level
  // count with it; faces of the crop make nothing thin. Requires: level > 0.
  bool hasThinParts(int level, Vec3i index) const;
  // What is drawn of a block of time step `time` at its level: the box of the finest cells in its
  // region where interpolation of the level's voxels gives something visible. A level with spreads
  // shows what the finest level shows; if the ranges of another level are not known, the whole
  // region shows. No cells: nothing.
  ObjectBlock objectOf(int level, Vec3i index, int64_t time) const;

 private:
  void boundFinest(WorkerPool& pool);
  Vec3i extentOf(const ObjectBlock& object) const;
  Box3 finestBox(int level, Vec3i index) const;
  Box3 reachIn(int level, Vec3i index) const;
  Box3 cellsShown(int level, Vec3i index, const Box3& region) const;
  const ObjectBlock* find(int level, int64_t block) const;
  bool hasSpreads(int level) const { return pyramid_.level(level).numbers == 2; }

  const PyramidLayout pyramid_;
  const Box3 crop_;
  std::vector<VisibleBlocks> levels_;  // by each level's own ranges; cells are the level's own
  std::vector<std::vector<uint32_t>> places_;  // of each level's blocks in levels_
  std::vector<bool> is_known_;                 // of a level: it has ranges
  // Of the blocks of each level but the finest: the hull of the finest level's object boxes in
  // their regions, and the same with its reach for levels with spreads.
  std::vector<std::vector<Box3>> finest_boxes_, reaches_;
  // The least extents along each axis of the object boxes in their regions, in finest cells.
  std::vector<std::vector<Vec3i>> least_extents_;
  int64_t finest_cells_ = 0;
};

}  // namespace sluice
