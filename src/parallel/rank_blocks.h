// RankBlocks: those of the blocks needed for a picture that this rank draws; another source of
// visible blocks. Later stages of the frame's chain do not know of it, so nothing of others' blocks
// is planned, read or drawn.
//
// All ranks make the cut through levels of resolution that one process makes. Its blocks are dealt
// in hands that hold whole blocks of the coarsest level in the picture, however few they are. An
// algorithm that loads every block loads every block of this rank's hands. If the ranks lend a
// volume in boxes, each draws the parts of blocks in its own.
#pragma once

#include <cstdint>
#include <functional>
#include <utility>

#include "src/parallel/dealing.h"
#include "src/render/blocks/cut/level_cut.h"
#include "src/render/blocks/visible_blocks.h"

namespace sluice {

class RankBlocks : public BlockChooser {
 public:
  // `pool` must outlive it.
  RankBlocks(const Dealing& dealing, int rank, WorkerPool& pool)
      : first_(dealing), dealing_(dealing), rank_(rank), classified_(pool), cut_(pool) {}

  // From now on takes from the blocks that `chooser` selects, which must outlive its use; null:
  // from the cut that the picture is drawn from, or all visible blocks of the classification.
  void chooseFrom(BlockChooser* chooser) { chooser_ = chooser; }
  // `each`: from now on each picture's blocks are dealt for it, see dealPicture(); otherwise the
  // volume's, once, as for an algorithm that loads every block.
  void dealEachPicture(bool each) { deals_each_ = each; }
  // `changed` is called by choose() whenever the hands are others than before.
  void tellDealings(std::function<void(const Dealing&)> changed) { changed_ = std::move(changed); }
  // The dealing of the blocks that were chosen last.
  const Dealing& dealing() const { return dealing_; }
  VisibleBlocksPtr choose(const BlockQuestion& question) override;
  LevelCut* cutFor(const BlockQuestion& question) override;
  VisibleBlocksPtr chooseOf(const BlockQuestion& question, const VisibleBlocksPtr& all,
                            int coarsest_level) override;

 private:
  struct Key {
    Identity<VisibleBlocks> all;
    int coarsest_level;
    bool loads_every;
    friend bool operator==(const Key&, const Key&) = default;
  };

  // Makes hands that suit a picture of no coarser level.
  void dealFor(const BlockQuestion& question, int coarsest_level);

  const Dealing first_;  // of the volume
  Dealing dealing_;
  std::function<void(const Dealing&)> changed_;
  const int rank_;
  ClassifiedBlocks classified_;
  LevelCut cut_;
  BlockChooser* chooser_ = nullptr;
  bool deals_each_ = false;
  Memo<Key, const VisibleBlocks> memo_;
};

}  // namespace sluice
