// A frame, from the time step to the picture: Session::frame() at the end is the chain, and the
// functions before it are its links, in their order.
#include <functional>
#include <utility>

#include "src/base/error.h"
#include "src/base/threads/clock.h"
#include "src/render/blocks/cut/cut_rules.h"
#include "src/render/camera/frame_setup.h"
#include "src/render/frame/pixel_rays.h"
#include "src/render/session/session.h"

namespace sluice {
namespace {

// With occlusion, blocks in front come first all over the picture, so that they hide as much as
// they can.
Arrangement arrangementOf(const FramePlan& plan, const FrameOptions& options,
                          const TextureCache& cache) {
  if (options.occlusion == Occlusion::kOff) return Arrangement::kRows;
  // If all chunks of the picture fit the cache, the layers may go across all clusters.
  const bool is_there_at_once = plan.pages <= static_cast<int64_t>(cache.capacityPages());
  return is_there_at_once ? Arrangement::kWhole : Arrangement::kLayers;
}

}  // namespace

VisibleBlocksPtr Session::blocksOf(const LookPtr& look, FrameOptions& options, ReadTally& judged) {
  const std::optional<ReadLimit> limit = readLimit(look);
  if (limit) options.time_limit_s.reset();  // all blocks of the cut come in time
  const bool judges_surfaces = judgesSurfaces(look, options);
  std::function<bool(const ObjectBlock&)> loses_surface;
  if (judges_surfaces) {
    lost_->ask(step_, look, cropCells(options, step_.source->layout().dims));
    // With a limit the next picture refines more.
    if (options.cut->keeps_thin && !limit)
      loses_surface = [&](const ObjectBlock& block) {
        options.stop.throwIfStopped();
        return losesSurface(block, judged);
      };
  } else {
    lost_->askNothing();
  }
  const View view = resolve(options, step_.source->layout());
  BlockQuestion question = Planner::question(step_, look, view, options, limit ? &*limit : nullptr);
  question.loses_surface = std::move(loses_surface);
  VisibleBlocksPtr visible = planner_.visibleBlocks(question);
  if (judges_surfaces) lost_->expect(visible);
  return visible;
}

PixelRays Session::setSampling(const LookPtr& look, const VisibleBlocks& visible,
                               FrameOptions& options) const {
  const VolumeLayout& volume = step_.source->layout();
  options.step_vox = stepForCut(visible, options);
  PixelRays rays;
  // Thin parts of a cut may be narrower than the rays are apart: several pictures with shifted rays
  // are drawn, and each pixel keeps one of its rays.
  const std::optional<KeptRay> kept =
      keptRay(*look->look_up, deviceMode(options.mode, step_.ranges->map.scale));
  if (kept && planner_.makesCut(step_, look, options))
    rays = {raysASide(step_, visible, resolve(options, volume), options), *kept};
  // Slices are no farther apart than rays.
  if (rays.a_side > 1 && !traitsOf(options.mode).on_planes) options.step_vox /= 2;
  if (Planner::drawsSurfaces(step_, *look, options))
    options.step_vox =
        Planner::stepForSurfaces(resolve(options, volume), volume, options.step_vox,
                                 step_.layout().level(finestLevelDrawn(visible)).placement.scale);
  return rays;
}

FrameSetup Session::setupOf(const Look& look, const View& view, const FrameOptions& options) const {
  FrameSetup setup = frameSetup(view, step_.source->layout(), look, step_.ranges->map, options,
                                opened_with_.lit && options.shades);
  setup.has_surfaces = Planner::drawsSurfaces(step_, look, options);
  setup.integrates = Planner::integrates(step_, look, view, options);
  return setup;
}

LightVolumePtr Session::lightFor(const FrameSetup& setup, const LookPtr& look,
                                 const VisibleBlocks& visible, const View& view,
                                 const FrameOptions& options) {
  if (!setup.lit || !traitsOf(options.mode).has_colors) return nullptr;
  // Decided by the options as asked for: with a time limit, which `options` may have lost, the
  // light comes from coarser levels.
  const bool from_finest = lightsFromFinest(visible, options_, step_.source->layout());
  return light_.of(step_, look, from_finest ? MatterFrom::kFinest : MatterFrom::kLevels, view,
                   options, pool_);
}

Frame Session::drawRays(const FrameValues& values, const PixelRays& rays) {
  Frame frame;
  const int count = rays.a_side * rays.a_side;
  for (int ray = 0; ray < count; ++ray) {
    FrameValues of_ray = values;
    if (count > 1)
      shiftView(of_ray.setup, shiftOfRay(ray % rays.a_side, ray / rays.a_side, rays.a_side));
    // The other rays need the same data, so what the next frame needs is read during the last one.
    if (ray + 1 < count) of_ray.when_read = {};
    FrameRun run(std::move(of_ray), residency_, device_, trace_, frame_number_, lessons_);
    Picture picture = run.draw();
    if (values.options.count_samples) run.countSamples();
    frame.phases = run.drawPhases();
    if (ray == 0) {
      frame.picture = std::move(picture);
      frame.report = run.report();
    } else {
      keepMost(frame.picture, picture, rays.kept);
      addStrip(frame.report, run.report());
    }
    lessons_ = run.lessons();
  }
  if (count > 1) frame.report.rays = rays;
  if (values.setup.light != nullptr) frame.report.light_texels = values.setup.light->dims;
  return frame;
}

Frame Session::frame() {
  SLUICE_CHECK(transfer_ != nullptr);
  // Applies to this frame alone, whether it is drawn or throws.
  const std::optional<TimeStep> afterwards = std::exchange(afterwards_, std::nullopt);
  const bool is_first = frame_number_ == opened_with_.trace_from.frame;
  const auto asked_at = std::chrono::steady_clock::now();
  const Stopwatch watch;
  Stopwatch stage;
  StageSeconds stages;
  takeLearntRanges();
  FrameOptions options = options_;

  const LookPtr look = planner_.look(step_, transfer_, options.mode);
  ReadTally judged;
  const VisibleBlocksPtr visible = blocksOf(look, options, judged);
  visible_ = visible;  // a hint for lastVisible(), so that nothing is held for it
  const PixelRays rays = setSampling(look, *visible, options);
  const View view = resolve(options, step_.source->layout());
  stages.classify = stage.lap();
  const FramePlanPtr plan = planner_.plan(step_, visible, options);
  stages.plan = stage.lap();
  const DrawOrderPtr order = planner_.order(plan, eyePosition(view, step_.source->layout()),
                                            arrangementOf(*plan, options, residency_.cache()));
  FrameSetup setup = setupOf(*look, view, options);
  stage.lap();  // the time for the order and the setup counts in no stage
  setup.light = lightFor(setup, look, *visible, view, options);
  stages.light = stage.lap();

  lessons_.unfinished.reset();  // this frame requests again what it needs of it
  read_afterwards_.reset();     // and of the data that was read ahead for it
  residency_.forgetUnused(*plan);
  // Growing boxes know nothing of the cells around them.
  const bool looks_around = setup.integrates || setup.has_surfaces;
  const ChosenBoxesPtr boxes = looks_around ? nullptr : boxesOf(look, plan);
  std::function<void()> when_read;
  if (afterwards) when_read = [&] { readAfterwards(*afterwards); };
  Frame frame = drawRays({step_, look, visible, plan, order, boxes, std::move(setup), options,
                          asked_at, std::move(when_read)},
                         rays);

  FrameReport& report = frame.report;
  frame.blocks = visible;
  report.seconds = watch.seconds();
  report.step_vox = options.step_vox;
  report.stages.classify = stages.classify;
  report.stages.plan = stages.plan;
  report.stages.light = stages.light;
  if (judgesSurfaces(look, options)) countLost(*look, *visible, view, judged, report);
  // The rest of the time was spent on waiting for data: the next limit is judged by it.
  noteDrawn(visible, report.seconds - report.stages.draw - stages.classify - stages.plan,
            report.decoded_bytes, report);
  // Blocks that were read to decide whether they are refined.
  report.decoded_bytes += judged.decoded_bytes;
  report.stages.read += secondsOf(judged.read_ns);
  report.stages.decode += secondsOf(judged.decode_ns);
  // A look that has just changed often changes again: the system clears the memory for it while
  // the picture is looked at.
  if (!is_first) residency_.chunks().makeReady(report.copied_bytes * 3 / 2);
  return frame;
}

}  // namespace sluice
