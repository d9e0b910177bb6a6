// RankBlocks: of the blocks that a picture needs those that this rank draws: one more source of
// visible blocks. What follows in a frame's chain does not know of it, so that nothing of others'
// blocks is planned, read or drawn.
#pragma once

#include <cstdint>

#include "src/parallel/dealing.h"
#include "src/render/visible_blocks.h"

namespace sluice {

class RankBlocks : public BlockChooser {
 public:
  // `pool` must outlive it.
  RankBlocks(const Dealing& dealing, int rank, WorkerPool& pool)
      : dealing_(dealing), rank_(rank), classified_(pool) {}

  // From now on takes of what this one chooses, which must outlive its use; null: of all that the
  // classification says is visible.
  void chooseFrom(BlockChooser* chooser) { chooser_ = chooser; }
  // From now on each picture's blocks are dealt for it, see dealPicture(); or all of the volume's
  // once.
  void dealEachPicture(bool each) { deals_each_ = each; }
  VisibleBlocksPtr choose(const BlockQuestion& question) override;

 private:
  const Dealing dealing_;
  const int rank_;
  ClassifiedBlocks classified_;
  BlockChooser* chooser_ = nullptr;
  bool deals_each_ = false;
  Memo<Identity<VisibleBlocks>, const VisibleBlocks> memo_;
};

}  // namespace sluice
