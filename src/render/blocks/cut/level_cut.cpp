#include "src/render/blocks/cut/level_cut.h"

#include <algorithm>
#include <span>
#include <utility>
#include <vector>

#include "src/base/error.h"
#include "src/render/blocks/cut/cut_maker.h"
#include "src/render/blocks/cut/cut_rules.h"
#include "src/render/blocks/cut/shown_levels.h"

namespace sluice {
namespace {

bool isSame(const VisibleBlocks& a, const VisibleBlocks& b) {
  return std::ranges::equal(a.blocks, b.blocks,
                            [](const ObjectBlock& x, const ObjectBlock& y) {
                              return x.name == y.name && x.cells == y.cells &&
                                     x.level_faces == y.level_faces;
                            }) &&
         a.cut->is_final == b.cut->is_final && a.cut->will_improve == b.cut->will_improve &&
         a.cut->thin_blocks == b.cut->thin_blocks;
}

}  // namespace

TimeStep LevelCut::listed(const TimeStep& step) {
  TimeStep with_listing = step;
  // Only levels that follow the finest one need to know which of its blocks are empty.
  if (!step.ranges->is_listed && followsFinest(step))
    with_listing.ranges =
        listed_.of(step, [&] { return listedRanges(step.ranges, *step.source, step.time); });
  return with_listing;
}

std::shared_ptr<ShownLevels> LevelCut::shownOf(const BlockQuestion& question) {
  SLUICE_CHECK(question.cut.has_value());
  requireLevel(*question.cut, question.step);
  const TimeStep step = listed(question.step);
  return shown_.of({step, question.look, question.crop}, [&] {
    std::shared_ptr<const RangeTree> tree;
    // Without a listing there is no range below any block.
    if (step.ranges->is_listed)
      tree = tree_.of(step, [&] { return RangeTree(*step.ranges, step.layout(), pool_); });
    return std::make_shared<ShownLevels>(step, question.look, question.crop, std::move(tree),
                                         pool_);
  });
}

VisibleBlocksPtr LevelCut::answer(const std::shared_ptr<const ShownLevels>& shown,
                                  VisibleBlocks blocks) {
  // The same plan serves all views that make the same cut.
  if (answer_ != nullptr && of_answer_ == shown && isSame(*answer_, blocks)) return answer_;
  of_answer_ = shown;
  answer_ = std::make_shared<const VisibleBlocks>(std::move(blocks));
  return answer_;
}

std::vector<VisibleBlocksPtr> LevelCut::chooseTogether(std::span<LevelCut* const> cuts,
                                                       std::span<const BlockQuestion> questions) {
  SLUICE_CHECK_EQ(cuts.size(), questions.size());
  std::vector<std::shared_ptr<ShownLevels>> shown;
  for (size_t i = 0; i < cuts.size(); ++i) shown.push_back(cuts[i]->shownOf(questions[i]));
  std::vector<VisibleBlocks> blocks = makeCut(questions, shown);
  std::vector<VisibleBlocksPtr> answers;
  for (size_t i = 0; i < cuts.size(); ++i)
    answers.push_back(cuts[i]->answer(shown[i], std::move(blocks[i])));
  return answers;
}

VisibleBlocksPtr LevelCut::choose(const BlockQuestion& question) {
  LevelCut* const self = this;
  return chooseTogether({&self, 1}, {&question, 1}).front();
}

}  // namespace sluice
