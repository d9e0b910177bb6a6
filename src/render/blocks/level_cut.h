// LevelCut: the blocks of a picture from a cut through the levels of resolution, one more way to
// choose them, made before a byte is read.
//
// A part of the volume is drawn at the coarsest level whose voxels are at most so many pixels wide
// there. The cut starts with the coarsest level and is refined level by level, the parts in front
// first, until the pixel error is reached everywhere or the blocks would take more than a budget
// allows. Parts outside the picture stay coarse. A part without anything visible at the finest
// level is left out, as with one level. A level whose voxels have a spread beside their mean shows
// what the finest level shows; another level shows what its own ranges allow.
#pragma once

#include <memory>

#include "src/base/threads/worker_pool.h"
#include "src/render/blocks/visible_blocks.h"
#include "src/render/camera/cut_options.h"

namespace sluice {

class RangeTree;
class ShownLevels;

class LevelCut : public BlockChooser {
 public:
  // `pool` must outlive it.
  explicit LevelCut(WorkerPool& pool) : pool_(pool) {}
  // Requires: the step has several levels and the question has a cut.
  VisibleBlocksPtr choose(const BlockQuestion& question) override;

 private:
  struct ShownKey {
    TimeStep step;
    Identity<Look> look;
    Box3 crop;
    friend bool operator==(const ShownKey&, const ShownKey&) = default;
  };

  WorkerPool& pool_;
  // The step with its finest level listed, if a level follows that one.
  TimeStep listed(const TimeStep& step);

  Memo<TimeStep, const SliceRanges> listed_;
  Memo<TimeStep, const RangeTree> tree_;
  Memo<ShownKey, ShownLevels> shown_;
  std::shared_ptr<const ShownLevels> of_answer_;  // levels that answer_ was chosen from
  VisibleBlocksPtr answer_;                       // the last one
};

}  // namespace sluice
