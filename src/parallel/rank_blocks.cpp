#include "src/parallel/rank_blocks.h"

#include "src/render/blocks/cut_rules.h"

namespace sluice {
namespace {

// The parts of blocks within a box of cells, of those that have any.
VisibleBlocks partsWithin(const VisibleBlocks& all, const Box3& cells) {
  VisibleBlocks parts;
  parts.white = all.white;
  for (const ObjectBlock& block : all.blocks) {
    ObjectBlock part = block;
    part.cells = intersect(block.cells, cells);
    if (part.cells.empty()) continue;
    if (part.cells != block.cells) {
      part.kind = BlockClass::kGrey;
      part.trimming_axis = shortestAxis(part.cells.size());
    }
    ++(part.kind == BlockClass::kBlack ? parts.black : parts.grey);
    parts.blocks.push_back(part);
  }
  return parts;
}

}  // namespace

void RankBlocks::dealFor(const BlockQuestion& question, const VisibleBlocks& all) {
  const int coarsest =
      all.cut ? coarsestLevelShown(question.step, question.view, all) : first_.coarsest_level;
  // The volume's own hands, which are the most even ones, hold all levels up to this one.
  const bool fits_first = coarsest <= first_.coarsest_level;
  const int before = dealing_.coarsest_level;
  if (fits_first)
    dealing_ = first_;
  else if (before != coarsest)
    dealing_ = dealBlocks(question.step.layout(), first_.ranks, coarsest);
  if (dealing_.coarsest_level != before && changed_) changed_(dealing_);
}

VisibleBlocksPtr RankBlocks::choose(const BlockQuestion& question) {
  BlockChooser* chooser = chooser_;
  if (chooser == nullptr && question.cut) chooser = &cut_;
  if (chooser == nullptr) chooser = &classified_;
  const VisibleBlocksPtr all = chooser->choose(question);
  if (dealing_.lent)
    return memo_.of({Identity<VisibleBlocks>(all), 0},
                    [&] { return partsWithin(*all, dealing_.lent->cellsOf(rank_)); });
  const PyramidLayout layout = question.step.layout();
  dealFor(question, *all);
  return memo_.of({Identity<VisibleBlocks>(all), dealing_.coarsest_level}, [&] {
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
