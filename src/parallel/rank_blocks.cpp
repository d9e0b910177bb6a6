#include "src/parallel/rank_blocks.h"

namespace sluice {

VisibleBlocksPtr RankBlocks::choose(const BlockQuestion& question) {
  BlockChooser* chooser = chooser_;
  if (chooser == nullptr && question.cut) chooser = &cut_;
  if (chooser == nullptr) chooser = &classified_;
  const VisibleBlocksPtr all = chooser->choose(question);
  const PyramidLayout layout = question.step.layout();
  return memo_.of(Identity<VisibleBlocks>(all), [&] {
    VisibleBlocks mine;
    mine.white = all->white;
    mine.cut = all->cut;  // of the whole picture
    const std::vector<int32_t> dealt =
        deals_each_ ? dealPicture(dealing_, layout, *all) : std::vector<int32_t>();
    for (size_t i = 0; i < all->blocks.size(); ++i) {
      const ObjectBlock& block = all->blocks[i];
      const int rank =
          deals_each_ ? dealt[i] : dealing_.rankOf(layout.finestBlocksOf(block.name).lo);
      if (rank != rank_) continue;
      ++(block.kind == BlockClass::kBlack ? mine.black : mine.grey);
      mine.blocks.push_back(block);
    }
    return mine;
  });
}

}  // namespace sluice
