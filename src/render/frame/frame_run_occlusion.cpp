// The frame's part in occlusion: when maps are made, which chunks are needed.
#include <algorithm>

#include "src/base/error.h"
#include "src/base/threads/clock.h"
#include "src/device/pictures/picture_rows.h"
#include "src/render/frame/frame_run.h"

namespace sluice {

void FrameRun::startOcclusion() {
  if (options_.occlusion == Occlusion::kOff) return;
  if (!traitsOf(options_.mode).hides)
    failRequest(
        "occlusion follows from opacity, which only composite pictures have; leave out "
        "--occlusion");
  const FramePlan& plan = *values_.plan;
  if (plan.hull.empty()) return;
  FrameOcclusion::Work work;
  work.hull = plan.hull;
  work.cells = values_.boxes != nullptr ? values_.boxes->cells() : plan.cells;
  work.updates = updates_.next();
  work.opaque = hidingThreshold(options_);
  occlusion_.emplace(options_.occlusion, values_.setup, values_.order->eye, work);
  shown_.assign(plan.textures.chunks.size(), false);
  // The first phase has no map: it is drawn before the first update.
  if (options_.keep_phases) phases_.emplace_back();
}

bool FrameRun::isHidden(BlockPosition block) const {
  const Box3& cells = textures().blocks[block].cells;
  return cells.empty() || (occlusion_ && occlusion_->hides(cells));
}

ReadAhead::Needs FrameRun::needs() const {
  // kMap only measures: it draws all boxes, and needs all chunks.
  const bool hides = occlusion_ && options_.occlusion != Occlusion::kMap;
  const std::optional<PictureRows> rows = rowsOf(device_);
  if (!hides && !rows) return {};
  const auto now = [this, hides, rows](ChunkPosition position) {
    // A chunk is needed if any of its blocks is, as they are loaded together.
    const Chunk& chunk = textures().chunks[position];
    return std::ranges::any_of(chunk.blocks, [&](BlockPosition block) {
      const Box3 cells = reachOf(textures().blocks[block]);
      if (rows && !overlap(*rows, rowsOf(values_.setup, cells))) return false;
      return !hides || !isHidden(block);
    });
  };
  if (!hides) return {now, {}};
  // Another plan has other chunks, and another kind hides others.
  const bool knows = last_.occlusion == options_.occlusion && last_.plan.lock() == values_.plan;
  if (!knows || last_.shown.empty()) return {now, {}};
  return {now, [this](ChunkPosition position) { return last_.shown[position]; }};
}

void FrameRun::updateOpacityMap() {
  // The map is of what has been drawn so far.
  flushBoxes();
  const Stopwatch watch;
  occlusion_->update(device_.leastOpacity(occlusion_->grid()));
  // Section 6 of Li 2003 suggests that single opaque pixels stop, too. Only the strongest kind
  // does.
  if (options_.occlusion == Occlusion::kClip) device_.stopOpaque();
  if (!phases_.empty()) phases_.push_back({occlusion_->map(), {}});
  report_.occlusion.seconds += watch.seconds();
}

std::vector<FramePhase> FrameRun::drawPhases() {
  std::vector<FramePhase> phases;
  for (Phase& phase : phases_) {
    // Its chunk may have been evicted since: the phase is drawn without it.
    std::erase_if(phase.drawn, [this](const BoxDraw& box) {
      return !residency_.isResident(residency_.nameOf(box.chunk));
    });
    device_.beginFrame(values_.setup, options_.stop);
    device_.draw(phase.drawn);
    phases.push_back({device_.endFrame(), phase.map});
  }
  return phases;
}

}  // namespace sluice
