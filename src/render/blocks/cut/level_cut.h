// LevelCut: the blocks of a picture from a cut through the levels of resolution, one more way to
// choose them, made before a byte is read.
//
// A part of the volume is drawn at the coarsest level whose voxels are at most so many pixels wide
// there. The cut starts with the coarsest level and is refined level by level, the parts in front
// first, until the pixel error is reached everywhere or the blocks would take more than a budget
// allows. Parts outside the picture stay coarse. A part without anything visible at the finest
// level is left out, as with one level. A level whose voxels have a spread beside their mean shows
// what the finest level shows; another level shows what its own ranges allow.
//
// Volumes on one grid that are drawn as one medium are of one cut, so that their blocks are the
// same parts of the volume: a part is refined where any of them shows something there, and only if
// all of them have the room.
//
// LevelCut keeps the last answer, and what it was chosen from; cut_maker.h makes a cut.
//
// The folder: cut_rules.h decides whether a picture is a cut, and of which levels. shown_levels.h
// has the parts of each level that show something, from the ranges below each block (range_tree.h).
// level_faces.h finds where blocks of different levels meet.
#pragma once

#include <memory>
#include <span>
#include <vector>

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
  LevelCut* cutFor(const BlockQuestion& /*question*/) override { return this; }
  // The answers to a question each, of one cut through the levels that the steps have in common
  // (levelsInCommon()). Requires: these include the level that the cuts name, and the questions'
  // views and cuts are the same but for the limits of bytes.
  static std::vector<VisibleBlocksPtr> chooseTogether(std::span<LevelCut* const> cuts,
                                                      std::span<const BlockQuestion> questions);

 private:
  struct ShownKey {
    TimeStep step;
    Identity<Look> look;
    Box3 crop;
    friend bool operator==(const ShownKey&, const ShownKey&) = default;
  };

  // The step's levels under the question's look.
  std::shared_ptr<ShownLevels> shownOf(const BlockQuestion& question);
  // These blocks, or the last answer if that is the same.
  VisibleBlocksPtr answer(const std::shared_ptr<const ShownLevels>& shown, VisibleBlocks blocks);

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
