// ShownLevels: what shows of each level of a time step under one look, whatever the view.
#pragma once

#include <cstdint>
#include <vector>

#include "src/base/worker_pool.h"
#include "src/render/visible_blocks.h"
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
  // Whether the region of a block has an object box of the finest level.
  bool showsFinest(int level, Vec3i index) const {
    const auto block = static_cast<size_t>(pyramid_.level(level).blocks.idOf(index));
    return shows_finest_[static_cast<size_t>(level)][block];
  }
  // What is drawn of a block of time step `time` at its level: the box of the finest cells in its
  // region where interpolation of the level's voxels gives something visible; the whole region if
  // the level's ranges are not known. No cells: nothing.
  ObjectBlock objectOf(int level, Vec3i index, int64_t time) const;

 private:
  void markFinest();
  Box3 cellsShown(int level, Vec3i index, const Box3& region) const;
  const ObjectBlock* find(int level, int64_t block) const;

  const PyramidLayout pyramid_;
  const Box3 crop_;
  std::vector<VisibleBlocks> levels_;  // by each level's own ranges; cells are the level's own
  std::vector<bool> is_known_;         // of a level: it has ranges
  std::vector<std::vector<bool>> shows_finest_;  // of a level's blocks
  int64_t finest_cells_ = 0;
};

}  // namespace sluice
