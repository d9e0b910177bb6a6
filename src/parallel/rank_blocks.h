// RankBlocks: those of the blocks needed for a picture that this rank draws; another source of
// visible blocks. Later stages of the frame's chain do not know of it, so nothing of others' blocks
// is planned, read or drawn.
#pragma once

#include <cstdint>

#include "src/parallel/dealing.h"
#include "src/render/blocks/level_cut.h"
#include "src/render/blocks/visible_blocks.h"

namespace sluice {

class RankBlocks : public BlockChooser {
 public:
  // `pool` must outlive it.
  RankBlocks(const Dealing& dealing, int rank, WorkerPool& pool)
      : dealing_(dealing), rank_(rank), classified_(pool), cut_(pool) {}

  // From now on takes from the blocks that `chooser` selects, which must outlive its use; null:
  // from the cut that the picture is drawn from, or all visible blocks of the classification.
  void chooseFrom(BlockChooser* chooser) { chooser_ = chooser; }
  // `each`: from now on each picture's blocks are dealt for it, see dealPicture(); otherwise the
  // volume's, once.
  void dealEachPicture(bool each) { deals_each_ = each; }
  VisibleBlocksPtr choose(const BlockQuestion& question) override;

 private:
  const Dealing dealing_;
  const int rank_;
  ClassifiedBlocks classified_;
  LevelCut cut_;
  BlockChooser* chooser_ = nullptr;
  bool deals_each_ = false;
  Memo<Identity<VisibleBlocks>, const VisibleBlocks> memo_;
};

}  // namespace sluice
