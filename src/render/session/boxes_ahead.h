// BoxesAhead: the growing boxes of a frame's blocks, chosen ahead of the draw in the order of the
// visit, so that drawing itself reads no voxel: if a block's boxes have to be grown first, the
// readers do that while blocks in front are drawn.
//
// Boxes that are still to come when it is destroyed are not made. One thread calls; the workers
// choose.
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <vector>

#include "src/base/threads/worker_pool.h"
#include "src/render/frame/draw_order.h"
#include "src/render/session/chosen_boxes.h"

namespace sluice {

class BoxesAhead {
 public:
  // Serves the blocks of `order`'s visits. `pool` and `order` must outlive it.
  BoxesAhead(ChosenBoxesPtr boxes, const DrawOrder& order, WorkerPool& pool, bool may_build,
             const ReadPurpose& purpose = {});
  ~BoxesAhead();
  BoxesAhead(const BoxesAhead&) = delete;
  BoxesAhead& operator=(const BoxesAhead&) = delete;

  // Whether a block of the plan need not be drawn; never changes from true to false.
  using IsHidden = std::function<bool(BlockPosition position)>;
  // Begins the next portions.
  void begin(const IsHidden& is_hidden);
  // The boxes of the plan's block at `position`; null if they may not be grown now. Blocks come in
  // order; hidden ones may be left out. Begins the next portions.
  VisibleBoxesPtr take(BlockPosition position, const IsHidden& is_hidden);

 private:
  struct Portion;
  using PortionPtr = std::shared_ptr<Portion>;

  const ChosenBoxesPtr boxes_;
  WorkerPool& pool_;
  const bool may_build_;
  const ReadPurpose purpose_;
  std::vector<BlockPosition> blocks_;  // blocks of the whole order
  size_t at_ = 0, next_ = 0;           // in blocks_: the one taken now; the one begun next
  std::deque<PortionPtr> begun_;       // portions that end behind at_
};

}  // namespace sluice
