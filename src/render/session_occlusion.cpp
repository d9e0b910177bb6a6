// What a session does of occlusion: when maps are made, which chunks are needed.
#include <algorithm>

#include "src/base/clock.h"
#include "src/base/error.h"
#include "src/render/session.h"

namespace sluice {

void Session::startOcclusion(const FrameSetup& setup, const EyePosition& eye) {
  occlusion_.reset();
  phases_.clear();
  if (frame_options_.occlusion == Occlusion::kOff) return;
  if (frame_options_.mode != Mode::kComposite)
    fail(
        "occlusion follows from opacity, which only composite pictures have; leave out "
        "--occlusion");
  FrameOcclusion::Work work;
  work.updates = update_count_.next();
  work.opaque = hidingThreshold(frame_options_);
  for (size_t i = 0; i < plan_->blocks.size(); ++i) {
    const Box3& cells = plan_->blocks[i].cells;
    if (cells.empty()) continue;
    work.hull = work.hull.empty() ? cells : unite(work.hull, cells);
    const auto drawn = drawn_boxes_.find(static_cast<int64_t>(i));
    work.cells += drawn == drawn_boxes_.end() ? cells.count() : drawn->second->cells();
  }
  if (work.hull.empty()) return;
  occlusion_.emplace(frame_options_.occlusion, setup, eye, work);
  shown_.assign(plan_->chunks.size(), false);
  if (frame_options_.keep_phases) phases_.emplace_back();
}

void Session::updateOpacityMap(FrameReport& report) {
  flushBoxes(report);
  const Stopwatch watch;
  occlusion_->update(device_.leastOpacity(occlusion_->grid()));
  if (frame_options_.occlusion == Occlusion::kClip) device_.stopOpaque();
  if (!phases_.empty()) phases_.push_back({occlusion_->map(), {}});
  report.occlusion.seconds += watch.seconds();
}

void Session::finishOcclusion(FrameReport& report) {
  if (!occlusion_) return;
  const double seconds = report.occlusion.seconds;
  report.occlusion = occlusion_->report();
  report.occlusion.seconds = seconds;
  report.occlusion.chunks_hidden = std::count(shown_.begin(), shown_.end(), false);
  update_count_.finished({occlusion_->hiddenShare(), report.occlusion.updates});
  last_shown_ = shown_;
}

std::vector<FramePhase> Session::drawPhases(const FrameSetup& setup) {
  std::vector<FramePhase> phases;
  for (const Phase& phase : phases_) {
    device_.beginFrame(setup);
    for (const PendingBoxes& drawn : phase.drawn) {
      const uint64_t name = names_[static_cast<size_t>(drawn.chunk)];
      if (cache_.contains(name)) device_.draw(name, drawn.boxes);
    }
    phases.push_back({device_.endFrame(), phase.map});
  }
  return phases;
}

ReadAhead::Needs Session::chunkNeeds() {
  if (!occlusion_ || frame_options_.occlusion == Occlusion::kMap) return {};
  const auto now = [this](int64_t chunk) {
    return !isHidden(plan_->chunks[static_cast<size_t>(chunk)]);
  };
  const auto soon = [this](int64_t chunk) {
    return last_shown_.empty() || last_shown_[static_cast<size_t>(chunk)];
  };
  return {now, soon};
}

bool Session::isHidden(const Chunk& chunk) const {
  return std::all_of(chunk.blocks.begin(), chunk.blocks.end(), [this](int64_t position) {
    const Box3& cells = plan_->blocks[static_cast<size_t>(position)].cells;
    return cells.empty() || occlusion_->hides(cells);
  });
}

}  // namespace sluice
