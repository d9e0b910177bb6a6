#include "src/library/drawing/drawing.h"

#include <algorithm>
#include <utility>

#include "src/base/error.h"
#include "src/library/conversions.h"
#include "src/library/drawing/cost/picture_plan.h"
#include "src/library/drawing/files/exr_contents.h"
#include "src/library/drawing/files/strip_file.h"
#include "src/library/drawing/probing.h"
#include "src/library/drawing/scene/opened_scene.h"
#include "src/library/drawing/scene/picture_facts.h"
#include "src/library/drawing/view_fit.h"
#include "src/library/in_situ.h"
#include "src/library/opening/step_ranges.h"
#include "src/options/option_rules.h"
#include "src/render/blocks/cut/cut_rules.h"
#include "src/render/camera/index_space.h"

namespace sluice {

namespace {

void requireNoConflict(const ViewState& asked) {
  if (const auto conflict = conflictIn(asked)) failRequest("{}", *conflict);
}

// The look, which takes no values that have no effect. Throws Error.
const LookOptions& checked(const LookOptions& look) {
  ViewState asked;
  asked.look = look;
  requireNoConflict(asked);
  return look;
}

}  // namespace

// A call that may read: its progress goes to the caller's teller.
struct Drawing::Reading {
  Reading(const Drawing& drawing, ProgressTeller& teller)
      : call(*drawing.opened_->relay, teller),
        progress(teller.watch(Progress::Stage::kIndexing)),
        pass{drawing.scene_.pool, progress, drawing.scene_.memory_bytes, teller.stop()} {}
  const ProgressRelay::Call call;
  ProgressMeter progress;
  const IndexPass pass;
};

Drawing::Drawing(std::shared_ptr<const OpenedVolume> opened, const LookOptions& look,
                 const RendererOptions& options)
    : opened_(std::move(opened)),
      asked_look_(checked(look)),
      scene_(sceneOf(opened_, look, options)),
      mode_(modeOf(look)),
      session_frame_(sessionFrame(opened_.get(), look, options)),
      session_combine_(scene_.combine),
      pipeline_(options.pipeline) {
  if (options.screen != nullptr) screen_ = dynamic_cast<DrawsForScreens*>(scene_.device.get());
}

void Drawing::setLook(const LookOptions& look) {
  const Mode mode = modeOf(checked(look));
  FrameOptions frame = session_frame_;
  frame.mode = mode;
  frame.lighting = {};  // of an earlier picture
  scene_.setLook(lookArguments(look, opened_->whole_series), frame);
  asked_look_ = look;
  mode_ = mode;
  ++looks_;
}

std::vector<TimeStep> Drawing::stepsAt(int64_t time, const IndexPass& pass) {
  requireStep(time, layout());
  // The step that is drawn and the one after it differ in parity, so reading ahead does not push
  // out the step that is shown.
  return *steps_[static_cast<size_t>(time % 2)].of(time, [&] {
    std::vector<TimeStep> steps;
    for (const Layer* layer : scene_.layers())
      steps.push_back(stepOfSeries(layer->volume, time, pass));
    return steps;
  });
}

Drawing::Points Drawing::shownPoints(const FrameOptions& options, const TimeStep& step,
                                     const IndexPass& pass) {
  const bool this_step = !opened_->whole_series;
  // The visible part of a whole series is the same for all of its steps, so they share one entry.
  const PointsKey key{this_step ? step.time : 0, options.crop, looks_};
  return points_.of(key, [&] {
    const std::vector<TimeStep> steps = stepsAt(step.time, pass);
    std::vector<FittedVolume> volumes;
    for (size_t i = 0; i < steps.size(); ++i) {
      const Layer& layer = *scene_.layers()[i];
      volumes.push_back({layer.volume, steps[i], layer.look.transfer});
    }
    if (opened_->in_situ == nullptr)
      return visiblePoints({std::move(volumes), options, this_step}, pass);
    const Vec3i dims = layout().dims;
    const Box3 cells =
        intersect(cropCells(options, dims), cropCells(opened_->in_situ->ownVoxels(), dims));
    FrameOptions own = options;
    own.crop = cropTo(cells, options.crop, dims);
    // Every rank takes part in the exchange, even if the crop leaves it nothing: the others wait
    // for it.
    return pointsOfRanks(cells.empty() ? std::vector<Vec3d>()
                                       : visiblePoints({std::move(volumes), own, this_step}, pass));
  });
}

std::optional<Framing> Drawing::framingFor(const std::vector<Camera>& cameras, FitChoice choice,
                                           const FrameOptions& options, const TimeStep& step,
                                           const IndexPass& pass) {
  if (fitOf(cameras, choice) == Fit::kVolume) return std::nullopt;
  return framingOf(*shownPoints(options, step, pass), cameras, layout().frame, options.size);
}

FrameOptions Drawing::asked(const PictureOptions& picture) const {
  requireNoConflict({picture, asked_look_, {}, {}, {}});
  FrameOptions options = frameOptions(picture, layout(), mode_);
  setPipeline(pipeline_, options);
  requirePictureSize(options.size, scene_.device->limits());
  return options;
}

FrameOptions Drawing::framed(const PictureOptions& picture, const TimeStep& step,
                             const IndexPass& pass) {
  FrameOptions options = asked(picture);
  // Ranks know the values of a brick that they share in parts, so that the visible part of all is
  // found to a brick: they fit the volume unless they are asked for more.
  const bool fits = opened_->in_situ == nullptr || picture.view.fit.has_value();
  if (fits && colorsByDepth(options)) options.shown_points = shownPoints(options, step, pass);
  if (!options.camera.framing && fits)
    options.camera.framing =
        framingFor({options.camera}, fitChoice(picture.view), options, step, pass);
  return options;
}

FrameOptions Drawing::looked(const PictureOptions& picture, const TimeStep& step,
                             const IndexPass& pass) {
  FrameOptions options = framed(picture, step, pass);
  scene_.setCombining(options);
  // A cut may hold no more than the memory has room for.
  if (options.cut) options.cut->most_held_bytes = cutBytes(scene_.memory_bytes, PictureRow::kMore);
  if (!picture.step_vox) {
    options.step_vox = scene_.chosenStep(stepsAt(step.time, pass), options);
    options.step_follows_cut =
        traitsOf(mode_).has_colors && drawsCut(step, options.cut, mode_, scene_.look.transfer);
  }
  options.shades = scene_.look.lit;
  options.lighting.flat_share *= scene_.look.flat_scale;
  return options;
}

Drawing::ReadyFrame Drawing::ready(const PictureOptions& picture, const IndexPass& pass,
                                   ProgressTeller& teller) {
  const std::vector<TimeStep> steps = stepsAt(picture.time, pass);
  // Before the options are made: that may gather points over the ranks, and a rank with another
  // request would leave the others waiting.
  if (opened_->in_situ != nullptr) expectSameRequest(picture);
  FrameOptions options = looked(picture, steps.front(), pass);
  if (opened_->in_situ != nullptr) expectSamePicture(picture, options, resolve(options, layout()));
  if (opened_->in_situ != nullptr && opened_->in_situ->team().ranks() > 1 &&
      options.lighting.looksAround())
    failRequest(
        "lighting.shadows and lighting.occlusion need the whole volume, of which a rank has a "
        "part");
  options.stop = teller.stop();
  options.watch = teller.watch(Progress::Stage::kDrawing);
  openSessionFor(options);
  scene_.setTimeStep(steps);
  scene_.setOptions(options);
  if (picture.next_time && *picture.next_time != picture.time)
    scene_.expectAfterwards(stepsAt(*picture.next_time, pass));
  return {std::move(options), picture.time};
}

SceneFrame Drawing::drawFrame(const ReadyFrame& frame, const std::vector<PictureRows>& strips,
                              const std::function<void(const Picture& rows)>& take,
                              ProgressTeller& teller) {
  // The progress of the picture, of which each strip is a part.
  FrameOptions watched = frame.options;
  uint64_t done = 0;
  const ProgressWatch watch = teller.watch(Progress::Stage::kDrawing);
  watched.watch = [&](uint64_t of_strip, uint64_t total) {
    // Strips count as equal parts, so the whole advances without steps back.
    watch(done * total + of_strip, strips.size() * total);
  };
  scene_.setOptions(watched);
  return scene_.draw(strips, [&](const Picture& rows) {
    ++done;
    take(rows);
  });
}

void Drawing::keepReport(const ReadyFrame& frame, const SceneFrame& drawn, const IndexPass& pass) {
  report_ = drawn.report;
  if (opened_->in_situ != nullptr) return;  // an empty part is no empty picture
  why_empty_ = scene_.whyNothing(drawn, frame.time, frame.options, pass);
  empty_channels_ = scene_.emptyLayers(drawn, frame.time, frame.options, pass);
}

Image Drawing::draw(const PictureOptions& picture, ProgressTeller& teller) {
  if (opened_->in_situ == nullptr) return drawWhole(picture, nullptr, teller);
  return together(opened_->in_situ->team(), [&] { return drawWhole(picture, nullptr, teller); });
}

Image Drawing::drawWhole(const PictureOptions& picture, std::optional<ScreenPicture>* kept,
                         ProgressTeller& teller) {
  const Reading reading(*this, teller);
  asked(picture);  // throws before anything is read
  const ReadyFrame of = ready(picture, reading.pass, teller);
  SceneFrame frame = drawFrame(
      of, {{0, of.options.size.height}}, [](const Picture& /*whole*/) {}, teller);
  if (kept != nullptr) {
    *kept = screen_->takeKept();
    SLUICE_CHECK(kept->has_value());
    frame.shows_something = (*kept)->shows_something;
  }
  keepReport(of, frame, reading.pass);
  Picture& whole = frame.whole->picture;
  return {.width = whole.width,
          .height = whole.height,
          .rgba = std::move(whole.rgba),
          .depth = std::move(whole.depth),
          .missing_share = frame.report.missing_share,
          .will_improve = frame.report.cut && frame.report.cut->will_improve};
}

void Drawing::drawRows(const PictureOptions& picture,
                       const std::function<void(const Image& rows)>& take, ProgressTeller& teller) {
  refuseInSitu("drawRows()");
  const Reading reading(*this, teller);
  asked(picture);  // throws before anything is read
  const auto takeFew = [&](const Picture& rows, int /*above*/) {
    take({.width = rows.width, .height = rows.height, .rgba = rows.rgba, .depth = rows.depth});
  };
  const ReadyFrame frame = ready(picture, reading.pass, teller);
  const auto takeStrip = [&](const Picture& strip) { eachFewRows(strip, teller.stop(), takeFew); };
  keepReport(frame, drawFrame(frame, scene_.stripsOf(frame.options), takeStrip, teller),
             reading.pass);
}

void Drawing::drawToFile(const std::string& path, const PictureOptions& picture,
                         const std::optional<std::array<float, 3>>& background,
                         ProgressTeller& teller) {
  refuseInSitu("drawToFile()");
  const Reading reading(*this, teller);
  PictureOptions in_file = picture;
  in_file.with_depth = traitsOf(mode_).has_colors && pictureKind(path) == PictureKind::kExr;
  asked(in_file);  // throws before anything is read
  const ReadyFrame frame = ready(in_file, reading.pass, teller);
  const std::string look = scene_.lookOf(frame.options, picture);
  StripFile file(path, {background, false, {}},
                 {frame.options, *opened_->volume.source, scene_.look.transfer, look},
                 teller.stop());
  const auto takeStrip = [&](const Picture& strip) { file.add(strip); };
  keepReport(frame, drawFrame(frame, scene_.stripsOf(frame.options), takeStrip, teller),
             reading.pass);
  file.commit();
}

std::optional<ScreenImage> Drawing::drawOnScreen(const PictureOptions& picture,
                                                 const std::array<float, 3>& background,
                                                 ProgressTeller& teller) {
  refuseInSitu("drawOnScreen()");
  // The device keeps a picture only in composite mode, without depth and of one channel
  // (screen_picture.h).
  if (screen_ == nullptr || !traitsOf(mode_).has_colors || picture.with_depth ||
      !scene_.more.empty())
    return std::nullopt;
  screen_->keepNext(background);
  try {
    std::optional<ScreenPicture> kept;
    const Image sizes = drawWhole(picture, &kept, teller);
    return ScreenImage{kept->texture, kept->width,     kept->height,        kept->drawn,
                       kept->seen,    kept->is_let_go, sizes.missing_share, sizes.will_improve};
  } catch (...) {
    // The wish holds until it is met: without this, the next draw() would get a picture without
    // pixels.
    screen_->keepNext(std::nullopt);
    screen_->takeKept();
    throw;
  }
}

void Drawing::fit(std::span<PictureOptions> pictures, ProgressTeller& teller) {
  if (pictures.empty()) return;
  refuseInSitu("fit()");
  const Reading reading(*this, teller);
  std::vector<Camera> cameras;
  for (PictureOptions picture : pictures) {
    // A framing from an earlier fit would otherwise decide the new one.
    picture.view.framing.reset();
    cameras.push_back(asked(picture).camera);
  }
  const PictureOptions& first = pictures.front();
  const FitChoice choice = fitChoice(first.view);
  const std::optional<Framing> framing =
      framingFor(cameras, choice, asked(first), stepAt(first.time, reading.pass), reading.pass);
  for (PictureOptions& picture : pictures) {
    if (picture.view.look_at) continue;
    picture.view.fit = first.view.fit;
    picture.view.framing.reset();
    if (framing) picture.view.framing = framingOf(*framing);
  }
}

ViewOptions Drawing::placed(const PictureOptions& picture, ProgressTeller& teller) {
  refuseInSitu("placed()");
  const Reading reading(*this, teller);
  Camera camera = framed(picture, stepAt(picture.time, reading.pass), reading.pass).camera;
  const PictureSize size{picture.width, picture.height};
  const View view = resolve(camera, layout(), size, 1);
  const auto asArray = [](Vec3d v) { return std::array<double, 3>{v.x, v.y, v.z}; };
  // Turns about the middle of the visible part, or of the volume, at its depth.
  Vec3d about = worldFromIndex(layout(), toDouble(layout().dims - Vec3i{1, 1, 1}) * 0.5);
  if (camera.framing) about = camera.framing->target;
  if (camera.look_at) about = camera.look_at->target;
  // The target may lie behind the eye, or in it.
  const double depth = std::max(dot(about - view.eye, view.forward), finestSpacing(layout()));
  ViewOptions placed = picture.view;
  placed.look_at = ViewOptions::LookAt{asArray(view.eye), asArray(view.eye + view.forward * depth)};
  placed.up = asArray(view.up);
  placed.framing.reset();
  placed.fit.reset();
  camera = cameraOf(placed);
  camera.zoom = 1;
  placed.zoom = resolve(camera, layout(), size, 1).half_height / view.half_height;
  return placed;
}

void Drawing::writeExr(const std::string& path, const Image& image, const PictureOptions& picture,
                       const std::optional<std::array<float, 3>>& background) {
  const auto pixels = static_cast<size_t>(image.width) * static_cast<size_t>(image.height);
  if (image.width != picture.width || image.height != picture.height ||
      image.rgba.size() != pixels * 4)
    failRequest("{}: an image of {} x {} pixels with {} values, expected {} x {}", path,
                image.width, image.height, image.rgba.size(), picture.width, picture.height);
  const ProgressFunction nobody;
  ProgressTeller teller(nobody, {});
  const Reading reading(*this, teller);
  const FrameOptions options = looked(picture, stepAt(picture.time, reading.pass), reading.pass);
  const std::string look = scene_.lookOf(options, picture);
  const Picture drawn{image.width, image.height, image.rgba, image.depth};
  sluice::writeExr(path,
                   exrContents(drawn, background, false,
                               {options, *opened_->volume.source, scene_.look.transfer, look}),
                   ExrPrecision::kFloat);
}

PicturePlan Drawing::plan(const PictureOptions& picture, ProgressTeller& teller) {
  refuseInSitu("plan()");
  const Reading reading(*this, teller);
  const std::vector<TimeStep> steps = stepsAt(picture.time, reading.pass);
  return planOf(scene_, steps, looked(picture, steps.front(), reading.pass));
}

PictureSampling Drawing::sampling(const PictureOptions& picture, ProgressTeller& teller) {
  refuseInSitu("sampling()");
  const Reading reading(*this, teller);
  const TimeStep step = stepAt(picture.time, reading.pass);
  const FrameOptions options = looked(picture, step, reading.pass);
  return {options.step_vox, drawsCut(step, options.cut, mode_, scene_.look.transfer)};
}

std::vector<std::string> Drawing::idleOptions(const std::set<std::string>& given,
                                              const PictureOptions& picture, bool is_planned) {
  refuseInSitu("idleOptions()");
  const ProgressFunction nobody;
  ProgressTeller teller(nobody, {});
  const Reading reading(*this, teller);
  const TimeStep step = stepAt(picture.time, reading.pass);
  PictureFacts facts = pictureFacts(scene_, looked(picture, step, reading.pass));
  facts.is_drawn = !is_planned;
  return sluice::idleOptions(given, facts);
}

std::optional<VoxelProbe> Drawing::probe(const PictureOptions& picture, double right, double down,
                                         ProgressTeller& teller) {
  refuseInSitu("probe()");
  const Reading reading(*this, teller);
  const TimeStep step = stepAt(picture.time, reading.pass);
  const FrameOptions options = framed(picture, step, reading.pass);
  const View view = resolve(options.camera, layout(), options.size, 1);
  return probeAlong({options, view, scene_.look.transfer, right, down}, session(), step,
                    teller.stop());
}

SliceValues Drawing::slice(const SliceOptions& slice, ProgressTeller& teller) {
  refuseInSitu("slice()");
  const Reading reading(*this, teller);
  return sliceOf(slice, session(), stepAt(slice.time, reading.pass), teller.stop());
}

}  // namespace sluice
