#include "src/parallel/rank_blocks.h"

namespace sluice {

VisibleBlocksPtr RankBlocks::choose(const BlockQuestion& question) {
  BlockChooser& chooser = chooser_ != nullptr ? *chooser_ : classified_;
  const VisibleBlocksPtr all = chooser.choose(question);
  const BlockLayout& layout = question.step.ranges->layout;
  return memo_.of(Identity<VisibleBlocks>(all), [&] {
    VisibleBlocks mine;
    mine.white = all->white;
    const std::vector<int32_t> dealt =
        deals_each_ ? dealPicture(dealing_, layout, *all) : std::vector<int32_t>();
    for (size_t i = 0; i < all->blocks.size(); ++i) {
      const ObjectBlock& block = all->blocks[i];
      const int rank = deals_each_ ? dealt[i] : dealing_.rankOf(layout.indexOf(block.name.block));
      if (rank != rank_) continue;
      ++(block.kind == BlockClass::kBlack ? mine.black : mine.grey);
      mine.blocks.push_back(block);
    }
    return mine;
  });
}

}  // namespace sluice
