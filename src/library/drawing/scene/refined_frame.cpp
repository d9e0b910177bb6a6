#include "src/library/drawing/scene/refined_frame.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include "src/base/error.h"
#include "src/library/drawing/empty_picture.h"
#include "src/render/blocks/cut/cut_rules.h"

namespace sluice {
namespace {

void willImprove(FrameReport& report, std::vector<LayerFrame>& parts) {
  if (report.cut) report.cut->is_final = false;
  for (LayerFrame& part : parts)
    if (part.report.cut) part.report.cut->is_final = false;
}

// Whether pictures may be drawn from the coarser levels unasked.
bool showAsFinest(const TimeStep& step) {
  return std::ranges::all_of(step.coarser, [](const CoarserStep& level) {
    return showsAsFinest(level.valuesShown(), level.spreads != nullptr);
  });
}

bool endsWithCut(RowEnd asked, bool has_limit) {
  return asked == RowEnd::kCut || has_limit;
}

// A picture without a cut is one of the finest level.
void noteFinest(Frame& frame, LayerFrame& first) {
  if (frame.report.cut || frame.blocks == nullptr) return;
  CutSummary cut;
  const auto& blocks = frame.blocks->blocks;
  CutSummary::Level level{.level = 0, .blocks = static_cast<int64_t>(blocks.size())};
  for (const ObjectBlock& block : blocks) level.cells += block.cells.count();
  if (!blocks.empty()) cut.levels.push_back(level);
  frame.report.cut = cut;
  first.report.cut = cut;
}

}  // namespace

FrameOptions lastOptions(const Scene& scene, FrameOptions options, RowEnd end) {
  const auto asFinest = [](const Layer* layer) { return showAsFinest(layer->volume.step()); };
  if (!endsWithCut(end, options.time_limit_s.has_value()) &&
      !std::ranges::all_of(scene.layers(), asFinest))
    options.cut.reset();
  return options;
}

bool canRefine(const Scene& scene, const FrameOptions& options) {
  return std::ranges::any_of(scene.layers(), [&](const Layer* layer) {
    const FrameOptions own = scene.optionsOf(*layer, options);
    return drawsCut(layer->volume.step(), own.cut, own.mode, layer->look.transfer);
  });
}

RefinedFrame drawRefined(Scene& scene, const FrameOptions& options, bool has_step, RowEnd end,
                         Deadline::TimePoint began, std::optional<Deadline::TimePoint> until,
                         const std::function<void(const BetterPicture&)>& take) {
  const std::vector<Layer*> layers = scene.layers();
  std::vector<LayerFrame> parts, of_last;
  RefinedPainter painter;
  painter.step_of = [&](const std::optional<CutOptions>& cut) {
    if (has_step) return options.step_vox;
    FrameOptions of_cut = options;
    of_cut.cut = cut;
    of_cut.time_limit_s.reset();  // the last picture is the one without a limit
    return scene.chosenStep(scene.openedSteps(), of_cut);
  };
  painter.options_of = [&](size_t place, const FrameOptions& picture) {
    return scene.optionsOf(*layers[place], picture);
  };
  painter.is_one_medium = scene.blends();
  painter.draw = [&] { return scene.frame(&parts); };
  std::vector<RefinedLayer> volumes;
  volumes.reserve(layers.size());
  for (Layer* layer : layers)
    volumes.push_back(
        {*layer->session, layer->volume.step(), layer->look.transfer,
         !endsWithCut(end, until.has_value()) && !showAsFinest(layer->volume.step())});
  Refinement row(volumes, std::move(painter), options, until, scene.pool);
  RefinedFrame refined;
  std::optional<Frame> last;
  for (int number = 0;; ++number) {
    std::optional<Frame> frame = row.next();
    if (!frame) break;
    noteFinest(*frame, parts.front());
    of_last = parts;
    if (last) scene.device->reuse(std::move(last->picture));
    last = std::move(frame);
    scene.noteMemory();
    // A sample shows a part of the voxels, whatever the pixel error.
    if (!row.isBest() ||
        (scene.volume.sample && last->report.cut && last->report.cut->coarse_share > 0))
      willImprove(last->report, of_last);
    refined.options = row.shown();
    const std::chrono::duration<double> since = std::chrono::steady_clock::now() - began;
    refined.pictures.push_back({since.count(), refined.options.step_vox, last->report.cut});
    take({*last, refined.options, number, since.count()});
  }
  SLUICE_CHECK(last.has_value());
  refined.frame.report = last->report;
  refined.frame.layers = std::move(of_last);
  refined.frame.blocks = last->blocks;
  refined.frame.shows_something = !showsNothing(last->picture);
  refined.frame.whole = std::move(last);
  return refined;
}

}  // namespace sluice
