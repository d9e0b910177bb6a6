#include "src/render/blocks/culled_blocks.h"

#include <utility>

#include "src/base/error.h"
#include "src/base/threads/clock.h"
#include "src/render/camera/frame_setup.h"

namespace sluice {
namespace {

// Nothing is kept where no step follows.
uint64_t keptBytes(const SeriesOpacity& series, const CullingOptions& options) {
  return options.uses_coherence && series.steps > 1 ? options.most_kept_bytes : 0;
}

}  // namespace

uint64_t CulledBlocks::mostBytes(const SeriesOpacity& series, PictureSize size,
                                 const CullingOptions& options, int threads) {
  // Beside their data, functions are objects whose three arrays are allocations of their own.
  constexpr uint64_t kAllocation = 16;
  const uint64_t objects = series.functions.size() * (sizeof(OpacityFunction) + 3 * kAllocation);
  return objects + VisibilityEstimate::mostBytes(series, size, keptBytes(series, options), threads);
}

EstimateView estimateView(const View& view, const VolumeLayout& layout) {
  return estimateView(viewSetup(view, layout, {}), eyePosition(view, layout).index);
}

CulledBlocks::CulledBlocks(SeriesOpacityPtr series, const VolumeLayout& layout,
                           const CullingOptions& options, WorkerPool& pool)
    : series_(std::move(series)),
      layout_(layout),
      options_(options),
      pool_(pool),
      classified_(pool) {
  SLUICE_CHECK(series_->dims == layout_.dims);
  SLUICE_CHECK_EQ(series_->steps, layout_.time_steps);
}

const CullingCounts& CulledBlocks::countsOf(int64_t time) const {
  if (counts_.time == time) return counts_;
  SLUICE_CHECK_EQ(before_.time, time);
  return before_;
}

VisibleBlocksPtr CulledBlocks::choose(const BlockQuestion& question) {
  const VisibleBlocksPtr all = classified_.choose(question);
  const bool same_view = asked_ && asked_->view == question.view && asked_->crop == question.crop;
  // The same answer object keeps the plan that follows from it.
  if (same_view && asked_->classified == Identity<VisibleBlocks>(all)) return answer_;
  SLUICE_CHECK_EQ(question.step.ranges->layout.cells(), series_->block_cells);
  Stopwatch watch;
  // The estimate belongs to the view. Of the step before, it keeps what did not change (Gao 2004).
  if (!same_view || !estimate_) {
    asked_.reset();  // if this question throws, the estimate is not of the view asked for last
    EstimateOptions estimate{
        options_.form, options_.opacity_threshold, {question.crop}, {}, options_.exponent};
    estimate.tile_stride = options_.tile_stride;
    estimate.first_tile = options_.first_tile;
    estimate.most_kept_bytes = keptBytes(*series_, options_);
    estimate.clip_planes = viewSetup(question.view, layout_, options_.clip_planes).clip_planes;
    estimate_.emplace(series_, estimateView(question.view, layout_), estimate);
  }
  estimate_->setStep(question.step.time, pool_, !options_.uses_coherence);
  std::vector<bool> reached(static_cast<size_t>(series_->blockCount()));
  for (size_t block = 0; block < reached.size(); ++block)
    reached[block] = estimate_->reaches(static_cast<int64_t>(block));
  // Ranks estimate different tiles of the picture and put together what they reach.
  if (options_.exchange) options_.exchange(question.step.time, reached);
  auto chosen = std::make_shared<VisibleBlocks>();
  chosen->white = all->white;
  for (const ObjectBlock& block : all->blocks) {
    if (!reached[static_cast<size_t>(block.name.block)]) continue;
    (block.kind == BlockClass::kBlack ? chosen->black : chosen->grey) += 1;
    chosen->blocks.push_back(block);
  }
  // The counts of the step before are still asked for, after the next step was read ahead.
  before_ = counts_;
  counts_ = {question.step.time,
             static_cast<int64_t>(all->blocks.size()),
             static_cast<int64_t>(chosen->blocks.size()),
             estimate_->pixelsChecked(),
             estimate_->allPixels(),
             estimate_->changedBlocks(),
             watch.seconds()};
  asked_ = Asked{all, question.view, question.crop, question.step.time};
  answer_ = std::move(chosen);
  return answer_;
}

}  // namespace sluice
