#include "src/parallel/rank_blocks.h"

namespace sluice {

VisibleBlocksPtr RankBlocks::choose(const BlockQuestion& question) {
  BlockChooser& chooser = chooser_ != nullptr ? *chooser_ : classified_;
  const VisibleBlocksPtr all = chooser.choose(question);
  const BlockLayout& layout = question.step.ranges->layout;
  return memo_.of(Identity<VisibleBlocks>(all), [&] {
    VisibleBlocks mine;
    mine.white = all->white;
    for (const ObjectBlock& block : all->blocks) {
      if (dealing_.rankOf(layout.indexOf(block.block)) != rank_) continue;
      ++(block.kind == BlockClass::kBlack ? mine.black : mine.grey);
      mine.blocks.push_back(block);
    }
    return mine;
  });
}

}  // namespace sluice
