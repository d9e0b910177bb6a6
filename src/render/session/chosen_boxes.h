// ChosenBoxes: the growing boxes that a frame draws of each block of a plan (visible_boxes.h), kept
// as far as a budget goes. The inputs (plan, look and distance of slices) are constant: other
// inputs have another object. Any thread.
#pragma once

#include <cstdint>
#include <memory>
#include <unordered_map>

#include "src/base/threads/mutex.h"
#include "src/index/box_store.h"
#include "src/render/blocks/look.h"
#include "src/render/blocks/visible_boxes.h"
#include "src/render/frame/frame_plan.h"

namespace sluice {

using VisibleBoxesPtr = std::shared_ptr<const VisibleBoxes>;

class ChosenBoxes {
 public:
  // `store` is of the step's boxes.
  ChosenBoxes(const TimeStep& step, LookPtr look, FramePlanPtr plan, double step_vox,
              std::shared_ptr<BoxStore> store, uint64_t budget_bytes);

  // The boxes of the plan's block at `position`; null unless they are kept.
  VisibleBoxesPtr find(BlockPosition position) const;
  // The same, made if it is not kept; null for a block above the finest level, which draws its
  // object box. Without `may_build`, null if the block's boxes would have to be grown from voxels
  // first. Throws Error from the source, Interrupted.
  VisibleBoxesPtr choose(BlockPosition position, bool may_build,
                         const ReadPurpose& purpose = {}) const;

  // The cells of a whole frame's boxes; object boxes count if no others are kept.
  int64_t cells() const;
  // The first cell of the plan's block at `position`: the origin of its boxes' cells.
  Vec3i firstCell(BlockPosition position) const;

 private:
  const TimeStep step_;
  const LookPtr look_;
  const FramePlanPtr plan_;
  const double step_vox_;
  const std::shared_ptr<BoxStore> store_;
  const uint64_t budget_bytes_;
  mutable Mutex mutex_;
  mutable std::unordered_map<BlockPosition, VisibleBoxesPtr> kept_ SLUICE_GUARDED_BY(mutex_);
  mutable uint64_t kept_bytes_ SLUICE_GUARDED_BY(mutex_) = 0;
};
using ChosenBoxesPtr = std::shared_ptr<const ChosenBoxes>;

}  // namespace sluice
