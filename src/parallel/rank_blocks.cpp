#include "src/parallel/rank_blocks.h"

#include "src/render/blocks/cut/cut_rules.h"

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
    // A part of a black block is no whole block any more, so it is trimmed as grey ones are.
    if (part.cells != block.cells) {
      part.kind = BlockClass::kGrey;
      part.trimming_axis = shortestAxis(part.cells.size());
    }
    ++(part.kind == BlockClass::kBlack ? parts.black : parts.grey);
    parts.blocks.push_back(part);
  }
  return parts;
}

// The finest blocks that own a cell of the box.
std::vector<int64_t> blocksWith(const BlockLayout& layout, const Box3& cells) {
  std::vector<int64_t> blocks;
  for (int64_t block = 0; block < layout.blockCount(); ++block)
    if (!intersect(layout.ownedCells(layout.indexOf(block)), cells).empty())
      blocks.push_back(block);
  return blocks;
}

// The finest blocks that this rank was dealt, visible or not.
std::vector<int64_t> blocksOf(int rank, const BlockLayout& layout, const Dealing& dealing) {
  std::vector<int64_t> blocks;
  for (int64_t block = 0; block < layout.blockCount(); ++block)
    if (dealing.rankOf(layout.indexOf(block)) == rank) blocks.push_back(block);
  return blocks;
}

}  // namespace

void RankBlocks::dealFor(const BlockQuestion& question, int coarsest_level) {
  // The volume's own hands, which are the most even ones, hold all levels up to this one.
  const bool fits_first = coarsest_level <= first_.coarsest_level;
  const int before = dealing_.coarsest_level;
  if (fits_first)
    dealing_ = first_;
  else if (before != coarsest_level)
    dealing_ = dealBlocks(question.step.layout(), first_.ranks, coarsest_level);
  if (dealing_.coarsest_level != before && changed_) changed_(dealing_);
}

VisibleBlocksPtr RankBlocks::choose(const BlockQuestion& question) {
  BlockChooser* chooser = chooser_;
  if (chooser == nullptr && question.cut) chooser = &cut_;
  if (chooser == nullptr) chooser = &classified_;
  const VisibleBlocksPtr all = chooser->choose(question);
  return chooseOf(
      question, all,
      all->cut ? coarsestLevelShown(question.step, question.view, *all) : first_.coarsest_level);
}

LevelCut* RankBlocks::cutFor(const BlockQuestion& question) {
  return chooser_ == nullptr && question.cut ? &cut_ : nullptr;
}

VisibleBlocksPtr RankBlocks::chooseOf(const BlockQuestion& question, const VisibleBlocksPtr& all,
                                      int coarsest_level) {
  const PyramidLayout layout = question.step.layout();
  const bool loads_every = loadsEveryBlock(*all, question.algorithm);
  // Lists of every block are only made for volumes that have few enough of them.
  if (loads_every) requireListable(layout.finest(), question.algorithm);
  if (dealing_.lent)
    return memo_.of({Identity<VisibleBlocks>(all), 0, loads_every}, [&] {
      const Box3 cells = dealing_.lent->cellsOf(rank_);
      VisibleBlocks mine = partsWithin(*all, cells);
      if (loads_every) mine.share = BlockShare{blocksWith(layout.finest(), cells), cells};
      return mine;
    });
  dealFor(question, coarsest_level);
  return memo_.of({Identity<VisibleBlocks>(all), dealing_.coarsest_level, loads_every}, [&] {
    VisibleBlocks mine;
    mine.white = all->white;
    mine.cut = all->cut;  // of the whole picture
    mine.thin = all->thin;
    mine.seams = all->seams;
    // Blocks that are not visible have no place in a picture's own hands.
    const bool deals_picture = deals_each_ && !loads_every;
    if (loads_every)
      mine.share =
          BlockShare{blocksOf(rank_, layout.finest(), dealing_), boxOf(layout.finest().dims)};
    const std::vector<int32_t> dealt =
        deals_picture ? dealPicture(dealing_, layout, *all) : std::vector<int32_t>();
    for (size_t i = 0; i < all->blocks.size(); ++i) {
      const ObjectBlock& block = all->blocks[i];
      // All finest blocks in the region of a coarser one lie in one hand, so that the first stands
      // for them.
      const int rank =
          deals_picture ? dealt[i] : dealing_.rankOf(layout.finestBlocksOf(block.name).lo);
      if (rank != rank_) continue;
      ++(block.kind == BlockClass::kBlack ? mine.black : mine.grey);
      mine.blocks.push_back(block);
    }
    return mine;
  });
}

}  // namespace sluice
