// A frame, from the time step to the picture.
#include <utility>

#include "src/base/error.h"
#include "src/base/threads/clock.h"
#include "src/render/session/session.h"

namespace sluice {
namespace {

// With occlusion, blocks in front come first all over the picture, so that they hide as much as
// they can.
Arrangement arrangementOf(const FramePlan& plan, const FrameOptions& options,
                          const TextureCache& cache) {
  if (options.occlusion == Occlusion::kOff) return Arrangement::kRows;
  const bool is_there_at_once = plan.pages <= static_cast<int64_t>(cache.capacityPages());
  return is_there_at_once ? Arrangement::kWhole : Arrangement::kLayers;
}

}  // namespace

Frame Session::frame() {
  SLUICE_CHECK(transfer_ != nullptr);
  // Applies to this frame alone, whether it is drawn or throws.
  const std::optional<TimeStep> afterwards = std::exchange(afterwards_, std::nullopt);
  const auto asked_at = std::chrono::steady_clock::now();
  const Stopwatch watch;
  Stopwatch stage;
  if (auto known = ranges(); known != step_.ranges) {
    step_.ranges = std::move(known);
    expectBlocksOf(step_);
  }
  const VolumeLayout& volume = step_.source->layout();
  FrameOptions options = options_;
  const auto viewNow = [&] {
    return resolve(options.camera, volume, options.size, options.step_vox);
  };

  const LookPtr look = planner_.look(step_, transfer_, options.mode);
  const std::optional<ReadLimit> limit = readLimit(look);
  if (limit) options.time_limit_s.reset();  // all blocks of the cut come in time
  const VisibleBlocksPtr visible =
      planner_.visibleBlocks(step_, look, viewNow(), options, limit ? &*limit : nullptr);
  options.step_vox = stepForCut(*visible, options);
  const View view = viewNow();
  const double classify_s = stage.lap();
  visible_ = visible;
  const FramePlanPtr plan = planner_.plan(step_, visible, options);
  const double plan_s = stage.lap();
  const DrawOrderPtr order = planner_.order(plan, eyePosition(view, volume),
                                            arrangementOf(*plan, options, residency_.cache()));
  const FrameSetup setup =
      frameSetup(view, volume, *look, step_.ranges->map, options, session_.lit && options.shades);

  lessons_.unfinished.reset();  // this frame requests again what it needs of it
  read_afterwards_.reset();     // and of the data that was read ahead for it
  residency_.forgetUnused(*plan);
  FrameRun run({step_, look, visible, plan, order, boxesOf(look, plan), setup, options, asked_at,
                [this, &afterwards] {
                  if (afterwards) readAfterwards(*afterwards);
                }},
               residency_, device_, trace_, frame_number_, lessons_);
  Frame frame;
  frame.picture = run.draw();
  run.report().seconds = watch.seconds();
  run.report().stages.classify = classify_s;
  run.report().stages.plan = plan_s;
  run.report().step_vox = options.step_vox;
  if (options.count_samples) run.countSamples();
  frame.phases = run.drawPhases();
  frame.report = run.report();
  if (frame.report.cut) frame.report.cut->spread = spreads_->of(*visible, step_.ranges->map.scale);
  frame.blocks = visible;
  noteDrawn(visible, frame.report);
  lessons_ = run.lessons();
  ++frame_number_;
  return frame;
}

}  // namespace sluice
