// A frame, from the time step to the picture.
#include <functional>
#include <utility>

#include "src/base/error.h"
#include "src/base/threads/clock.h"
#include "src/render/blocks/cut/cut_rules.h"
#include "src/render/frame/pixel_rays.h"
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
  takeLearntRanges();
  const VolumeLayout& volume = step_.source->layout();
  FrameOptions options = options_;
  const auto viewNow = [&] {
    return resolve(options.camera, volume, options.size, options.step_vox);
  };

  const LookPtr look = planner_.look(step_, transfer_, options.mode);
  const std::optional<ReadLimit> limit = readLimit(look);
  if (limit) options.time_limit_s.reset();  // all blocks of the cut come in time
  const bool judges_surfaces = judgesSurfaces(look, options);
  ReadTally judged;
  std::function<bool(const ObjectBlock&)> loses_surface;
  if (judges_surfaces) {
    lost_->ask(step_, look, cropCells(options, volume.dims));
    // With a limit the next picture refines more.
    if (options.cut->keeps_thin && !limit)
      loses_surface = [&](const ObjectBlock& block) {
        options.stop.throwIfStopped();
        return losesSurface(block, judged);
      };
  } else {
    lost_->askNothing();
  }
  const VisibleBlocksPtr visible = planner_.visibleBlocks(step_, look, viewNow(), options,
                                                          limit ? &*limit : nullptr, loses_surface);
  if (judges_surfaces) lost_->expect(visible);
  options.step_vox = stepForCut(*visible, options);
  const std::optional<KeptRay> kept_ray =
      keptRay(*look->look_up, deviceMode(options.mode, step_.ranges->map.scale));
  const int rays = kept_ray && planner_.makesCut(step_, look, options)
                       ? raysASide(step_, *visible, viewNow(), options)
                       : 1;
  // Slices are no farther apart than rays.
  if (rays > 1 && !traitsOf(options.mode).on_planes) options.step_vox /= 2;
  const bool has_surfaces = Planner::drawsSurfaces(step_, *look, options);
  if (has_surfaces)
    options.step_vox =
        Planner::stepForSurfaces(viewNow(), volume, options.step_vox,
                                 step_.layout().level(finestLevelDrawn(*visible)).placement.scale);
  const View view = viewNow();
  const double classify_s = stage.lap();
  visible_ = visible;
  const FramePlanPtr plan = planner_.plan(step_, visible, options);
  const double plan_s = stage.lap();
  const DrawOrderPtr order = planner_.order(plan, eyePosition(view, volume),
                                            arrangementOf(*plan, options, residency_.cache()));
  FrameSetup setup =
      frameSetup(view, volume, *look, step_.ranges->map, options, session_.lit && options.shades);
  setup.has_surfaces = has_surfaces;
  stage.lap();
  if (setup.lit && traitsOf(options.mode).has_colors)
    setup.light = light_.of(
        step_, look,
        lightsFromFinest(*visible, options_, volume) ? MatterFrom::kFinest : MatterFrom::kLevels,
        view, options, pool_);
  const double light_s = stage.lap();
  setup.integrates = Planner::integrates(step_, *look, view, options);

  lessons_.unfinished.reset();  // this frame requests again what it needs of it
  read_afterwards_.reset();     // and of the data that was read ahead for it
  residency_.forgetUnused(*plan);
  Frame frame;
  for (int ray = 0; ray < rays * rays; ++ray) {
    FrameSetup of_ray = setup;
    if (rays > 1) of_ray.rays = raysOfPixel(setup.rays, ray % rays, ray / rays, rays);
    // Growing boxes know nothing of the cells around them.
    const bool looks_around = setup.integrates || has_surfaces;
    const ChosenBoxesPtr boxes = looks_around ? nullptr : boxesOf(look, plan);
    FrameRun run({step_, look, visible, plan, order, boxes, std::move(of_ray), options, asked_at,
                  [this, &afterwards, is_last = ray + 1 == rays * rays] {
                    if (is_last && afterwards) readAfterwards(*afterwards);
                  }},
                 residency_, device_, trace_, frame_number_, lessons_);
    Picture picture = run.draw();
    if (ray == 0)
      frame.picture = std::move(picture);
    else
      keepMost(frame.picture, picture, *kept_ray);
    if (options.count_samples) run.countSamples();
    frame.phases = run.drawPhases();
    if (ray == 0)
      frame.report = run.report();
    else
      addStrip(frame.report, run.report());
    lessons_ = run.lessons();
  }
  frame.report.seconds = watch.seconds();
  frame.report.stages.classify = classify_s;
  frame.report.stages.plan = plan_s;
  frame.report.stages.light = light_s;
  if (setup.light != nullptr) frame.report.light_texels = setup.light->dims;
  frame.report.step_vox = options.step_vox;
  if (rays > 1) frame.report.rays = {rays, *kept_ray};
  frame.blocks = visible;
  if (judges_surfaces) countLost(*look, *visible, view, judged, frame.report);
  noteDrawn(visible, frame.report.seconds - frame.report.stages.draw - classify_s - plan_s,
            frame.report.decoded_bytes, frame.report);
  // Blocks that were read to decide whether they are refined.
  frame.report.decoded_bytes += judged.decoded_bytes;
  frame.report.stages.read += secondsOf(judged.read_ns);
  frame.report.stages.decode += secondsOf(judged.decode_ns);
  return frame;
}

}  // namespace sluice
