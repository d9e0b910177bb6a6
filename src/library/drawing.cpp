#include "src/library/drawing.h"

#include <fmt/format.h>

#include <utility>

#include "src/library/conversions.h"
#include "src/library/resources.h"
#include "src/library/view_fit.h"

namespace sluice {

Drawing::Drawing(std::shared_ptr<const OpenedVolume> opened, const LookOptions& look,
                 const RendererOptions& options)
    : opened_(std::move(opened)),
      machine_(machineOptions(options)),
      pool_(machine_.threads),
      device_(makeDevice(machine_.device, pool_)) {
  const IndexedVolume& volume = opened_->volume;
  SessionOptions session =
      sessionOptions(volume, true, machine_, Partition::kBlocks, memoryBudget(machine_));
  // Of a series, those of the step that is drawn beside the volume's own.
  if (layout().time_steps > 1) session.beside_bytes *= 2;
  session.page.pages =
      pageCount(machine_, volume.page, volume.layout, *volume.source, session.beside_bytes);
  session_ = std::make_unique<Session>(volume.step(), *device_, pool_, session);
  setLook(look);
}

void Drawing::setLook(const LookOptions& look) {
  const Mode mode = modeOf(look);
  ChosenLook chosen = lookFor(opened_->volume, lookArguments(look, opened_->whole_series), mode);
  session_->setTransferFunction(chosen.transfer);
  look_ = std::move(chosen);
  mode_ = mode;
  ++looks_;
}

std::string Drawing::deviceName() const {
  return fmt::format("{}, {}", device_->backend(), device_->renderer());
}

TimeStep Drawing::stepAt(int64_t time, const IndexPass& pass) {
  const IndexedVolume& volume = opened_->volume;
  if (time == volume.time) return volume.step();
  const auto index = ranges_.of(time, [&] {
    IndexedRanges made = rangesOfStep(volume, time, pass);
    made.ranges.device_range = volume.index->ranges.device_range;
    return made;
  });
  return {volume.source.get(), time, {index, &index->ranges}};
}

std::optional<Framing> Drawing::framingFor(const std::vector<Camera>& cameras, FitChoice choice,
                                           const FrameOptions& options, const TimeStep& step,
                                           const IndexPass& pass) {
  if (fitOf(cameras, choice) == Fit::kVolume) return std::nullopt;
  const bool this_step = !opened_->whole_series;
  const PointsKey key{this_step ? step.time : 0, options.crop, looks_};
  const Points points = points_.of(key, [&] {
    return visiblePoints({opened_->volume, step, look_.transfer, options, this_step}, pass);
  });
  return framingOf(*points, cameras, layout().frame, options.size);
}

Image Drawing::draw(const PictureOptions& picture, ProgressTeller& teller) {
  const ProgressRelay::Call call(*opened_->relay, teller);
  FrameOptions options = frameOptions(picture, layout(), mode_);
  const FitChoice choice = fitChoice(picture.view);
  ProgressMeter progress(teller.watch(Progress::Stage::kIndexing));
  const IndexPass pass{pool_, progress, memoryBudget(machine_), teller.stop()};
  const TimeStep step = stepAt(picture.time, pass);
  if (!options.camera.framing)
    options.camera.framing = framingFor({options.camera}, choice, options, step, pass);
  if (!picture.step_vox && mode_ == Mode::kComposite)
    options.step_vox =
        stepFor(resolve(options.camera, layout(), options.size, options.step_vox), layout());
  options.shades = look_.lit;
  options.lighting.flat_share *= look_.flat_scale;
  options.stop = teller.stop();
  options.watch = teller.watch(Progress::Stage::kDrawing);
  session_->setTimeStep(step);
  session_->setOptions(options);
  Picture drawn = session_->frame().picture;
  return {drawn.width, drawn.height, std::move(drawn.rgba), std::move(drawn.depth)};
}

void Drawing::fit(std::span<PictureOptions> pictures, ProgressTeller& teller) {
  if (pictures.empty()) return;
  const ProgressRelay::Call call(*opened_->relay, teller);
  std::vector<Camera> cameras;
  for (PictureOptions picture : pictures) {
    picture.view.framing.reset();
    cameras.push_back(frameOptions(picture, layout(), mode_).camera);
  }
  const PictureOptions& first = pictures.front();
  const FitChoice choice = fitChoice(first.view);
  ProgressMeter progress(teller.watch(Progress::Stage::kIndexing));
  const IndexPass pass{pool_, progress, memoryBudget(machine_), teller.stop()};
  const std::optional<Framing> framing = framingFor(
      cameras, choice, frameOptions(first, layout(), mode_), stepAt(first.time, pass), pass);
  for (PictureOptions& picture : pictures) {
    if (picture.view.look_at) continue;
    picture.view.fit = first.view.fit;
    picture.view.framing.reset();
    if (framing) picture.view.framing = framingOf(*framing);
  }
}

}  // namespace sluice
