#include "src/library/drawing/drawing.h"

#include <fmt/format.h>

#include <algorithm>
#include <unordered_map>
#include <utility>

#include "src/base/error.h"
#include "src/base/files/byte_stream.h"
#include "src/base/values/digest.h"
#include "src/classify/transfer/transfer_file.h"
#include "src/library/conversions.h"
#include "src/library/drawing/exr_contents.h"
#include "src/library/drawing/picture_plan.h"
#include "src/library/drawing/probing.h"
#include "src/library/drawing/strip_file.h"
#include "src/library/drawing/view_fit.h"
#include "src/library/in_situ.h"
#include "src/library/opening/step_ranges.h"
#include "src/parallel/agreement.h"
#include "src/render/blocks/cut_rules.h"
#include "src/render/camera/index_space.h"

namespace sluice {

namespace {

// The frames that a scene's session is opened for.
FrameOptions sessionFrame(const OpenedVolume* opened, const LookOptions& look,
                          const RendererOptions& options) {
  FrameOptions frame;
  frame.mode = modeOf(look);
  frame.size = {std::max(0, options.rows_width), std::max(0, options.rows_height)};
  if (opened->in_situ != nullptr) frame.crop = opened->in_situ->ownVoxels();
  return frame;
}

Scene sceneOf(const std::shared_ptr<const OpenedVolume>& opened, const LookOptions& look,
              const RendererOptions& options) {
  const MachineOptions machine = machineOptions(options);
  std::vector<std::shared_ptr<const IndexedVolume>> more;
  for (const IndexedVolume& volume : opened->more) more.emplace_back(opened, &volume);
  // A rank that has all of the volume draws it alone.
  const InSitu* in_situ = opened->in_situ.get();
  if (in_situ != nullptr && in_situ->team().ranks() == 1) in_situ = nullptr;
  return {{.pool = std::make_shared<WorkerPool>(machine.threads),
           .volume = {opened, &opened->volume},
           .more = std::move(more),
           .machine = machine,
           .team = in_situ == nullptr ? nullptr : &in_situ->team(),
           .lent = in_situ == nullptr ? nullptr : in_situ->boxes,
           .may_be_lit = true},
          lookArguments(look, opened->whole_series),
          sessionFrame(opened.get(), look, options)};
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
      scene_(sceneOf(opened_, look, options)),
      mode_(modeOf(look)),
      session_frame_(sessionFrame(opened_.get(), look, options)) {
  if (options.screen != nullptr) screen_ = dynamic_cast<DrawsForScreens*>(scene_.device.get());
}

void Drawing::setLook(const LookOptions& look) {
  const Mode mode = modeOf(look);
  scene_.setLook(lookArguments(look, opened_->whole_series), mode);
  mode_ = mode;
  ++looks_;
}

std::string Drawing::deviceName() const {
  return fmt::format("{}, {}", scene_.device->backend(), scene_.device->renderer());
}

std::vector<TimeStep> Drawing::stepsAt(int64_t time, const IndexPass& pass) {
  requireStep(time, layout());
  return *steps_[static_cast<size_t>(time % 2)].of(time, [&] {
    std::vector<TimeStep> steps;
    for (const Layer* layer : scene_.layers())
      steps.push_back(stepOfSeries(layer->volume, time, pass));
    return steps;
  });
}

std::optional<Framing> Drawing::framingFor(const std::vector<Camera>& cameras, FitChoice choice,
                                           const FrameOptions& options, const TimeStep& step,
                                           const IndexPass& pass) {
  if (fitOf(cameras, choice) == Fit::kVolume) return std::nullopt;
  const bool this_step = !opened_->whole_series;
  const PointsKey key{this_step ? step.time : 0, options.crop, looks_};
  const Points points = points_.of(key, [&] {
    const std::vector<TimeStep> steps = stepsAt(step.time, pass);
    std::vector<FittedVolume> volumes;
    for (size_t i = 0; i < steps.size(); ++i) {
      const Layer& layer = *scene_.layers()[i];
      volumes.push_back({layer.volume, steps[i], layer.look.transfer});
    }
    if (opened_->in_situ == nullptr)
      return visiblePoints({std::move(volumes), options, this_step}, pass);
    FrameOptions own = options;
    own.crop =
        intersect(options.crop.value_or(boxOf(layout().dims)), opened_->in_situ->ownVoxels());
    return pointsOfRanks(cropCells(own, layout().dims).empty()
                             ? std::vector<Vec3d>()
                             : visiblePoints({std::move(volumes), own, this_step}, pass));
  });
  return framingOf(*points, cameras, layout().frame, options.size);
}

void Drawing::refuseInSitu(const char* call) const {
  if (opened_->in_situ != nullptr)
    fail("{}: {} is not for a volume of which each rank has a part; ranks draw() together",
         opened_->volume.name, call);
}

std::vector<Vec3d> Drawing::pointsOfRanks(std::vector<Vec3d> own) const {
  ByteWriter mine;
  mine.list(own);
  std::vector<Vec3d> all, more;
  for (const Message& message : opened_->in_situ->team().gatherAll(mine.bytes)) {
    ByteReader from(message);
    SLUICE_CHECK(from.list(more));
    all.insert(all.end(), more.begin(), more.end());
  }
  return all;
}

void Drawing::expectSameRequest(const PictureOptions& picture) const {
  expectAgreement(opened_->in_situ->team(),
                  {{"the look", scene_.lookText()},
                   {"the number of looks set", std::to_string(looks_)},
                   {"the size", fmt::format("{}x{}", picture.width, picture.height)}},
                  "draw the same picture on every rank");
}

void Drawing::expectSamePicture(const FrameOptions& options, const View& view) const {
  const InSitu& in_situ = *opened_->in_situ;
  Digest place;
  for (const Vec3d& vector : {view.eye, view.right, view.up, view.forward})
    for (int a = 0; a < 3; ++a) place.add(static_cast<float>(vector[a]));
  place.add(static_cast<float>(view.half_height));
  const Box3 crop = options.crop.value_or(boxOf(layout().dims));
  for (int a = 0; a < 3; ++a) {
    place.add(crop.lo[a]);
    place.add(crop.hi[a]);
  }
  expectAgreement(in_situ.team(),
                  {{"the look", scene_.lookOf(options)}, {"the view", "", place.value()}},
                  "draw the same picture on every rank");
  const TransferFunction& transfer = scene_.look.transfer;
  const bool looks_around = options.shades || scene_.integrates(options) ||
                            !transfer.gradients.empty() || !transfer.surfaces.empty();
  if (looks_around && !in_situ.can_look_around)
    fail(
        "{}: lit pictures, surfaces and --quality need one layer of ghosts below and two above on "
        "each rank; lend them, or set LookOptions::light to kOff",
        opened_->volume.name);
}

FrameOptions Drawing::framed(const PictureOptions& picture, const TimeStep& step,
                             const IndexPass& pass) {
  FrameOptions options = frameOptions(picture, layout(), mode_);
  // Ranks know the values of a brick that they share in parts, so that the visible part of all is
  // found to a brick: they fit the volume unless they are asked for more.
  const bool fits = opened_->in_situ == nullptr || picture.view.fit.has_value();
  if (!options.camera.framing && fits)
    options.camera.framing =
        framingFor({options.camera}, fitChoice(picture.view), options, step, pass);
  return options;
}

FrameOptions Drawing::looked(const PictureOptions& picture, const TimeStep& step,
                             const IndexPass& pass) {
  FrameOptions options = framed(picture, step, pass);
  if (options.cut) options.cut->most_held_bytes = cutBytes(scene_.memory_bytes, PictureRow::kMore);
  if (!picture.step_vox) {
    options.step_vox = scene_.chosenStep(step, options);
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
  if (opened_->in_situ != nullptr) expectSameRequest(picture);
  FrameOptions options = looked(picture, steps.front(), pass);
  if (opened_->in_situ != nullptr)
    expectSamePicture(options, resolve(options.camera, layout(), options.size, options.step_vox));
  if (opened_->in_situ != nullptr && opened_->in_situ->team().ranks() > 1 &&
      options.lighting.looksAround())
    fail(
        "lighting.shadows and lighting.occlusion need the whole volume, of which a rank has a "
        "part");
  options.stop = teller.stop();
  options.watch = teller.watch(Progress::Stage::kDrawing);
  // Light that looks around has a share of the memory from the first such picture on.
  if (options.lighting.looksAround() && !session_frame_.lighting.looksAround()) {
    session_frame_.lighting = options.lighting;
    scene_.openSession(session_frame_, 0);
  }
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
  frameOptions(picture, layout(), mode_);  // throws before anything is read
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
  frameOptions(picture, layout(), mode_);  // throws before anything is read
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
  frameOptions(in_file, layout(), mode_);  // throws before anything is read
  const ReadyFrame frame = ready(in_file, reading.pass, teller);
  const std::string look = scene_.lookOf(frame.options);
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
  if (screen_ == nullptr || !traitsOf(mode_).has_colors || picture.with_depth ||
      !scene_.more.empty())
    return std::nullopt;
  screen_->keepNext(background);
  try {
    std::optional<ScreenPicture> kept;
    const Image sizes = drawWhole(picture, &kept, teller);
    return ScreenImage{kept->texture, kept->width,         kept->height,      kept->drawn,
                       kept->seen,    sizes.missing_share, sizes.will_improve};
  } catch (...) {
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
    picture.view.framing.reset();
    cameras.push_back(frameOptions(picture, layout(), mode_).camera);
  }
  const PictureOptions& first = pictures.front();
  const FitChoice choice = fitChoice(first.view);
  const std::optional<Framing> framing =
      framingFor(cameras, choice, frameOptions(first, layout(), mode_),
                 stepAt(first.time, reading.pass), reading.pass);
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
    fail("{}: an image of {} x {} pixels with {} values, expected {} x {}", path, image.width,
         image.height, image.rgba.size(), picture.width, picture.height);
  const ProgressFunction nobody;
  ProgressTeller teller(nobody, {});
  const Reading reading(*this, teller);
  const FrameOptions options = looked(picture, stepAt(picture.time, reading.pass), reading.pass);
  const std::string look = scene_.lookOf(options);
  const Picture drawn{image.width, image.height, image.rgba, image.depth};
  sluice::writeExr(path,
                   exrContents(drawn, background, false,
                               {options, *opened_->volume.source, scene_.look.transfer, look}),
                   ExrPrecision::kFloat);
}

ShownLook Drawing::shownLook() const {
  ShownLook shown;
  for (const ColorPoint& point : scene_.look.transfer.colors)
    shown.colors.push_back({point.value, {point.rgb.x, point.rgb.y, point.rgb.z}});
  for (const OpacityPoint& point : scene_.look.transfer.opacities)
    shown.opacities.push_back({point.value, point.opacity});
  shown.lit = scene_.look.lit;
  shown.labels = scene_.look.transfer.labels;
  shown.options = scene_.lookText();
  shown.transfer = writeTransferFunction(scene_.look.transfer);
  shown.warnings = scene_.look.warnings;
  return shown;
}

RenderReport Drawing::report(bool maps) const {
  const auto level = [](const CacheCounters& c) {
    return LevelReport{.requests = c.requests,
                       .hits = c.hits,
                       .misses = c.misses,
                       .loads = c.loads,
                       .evictions = c.evictions,
                       .current_bytes = c.current_bytes,
                       .peak_bytes = c.peak_bytes,
                       .budget_bytes = c.budget_bytes};
  };
  const TextureCache& cache = scene_.session->textureCache();
  const LevelCounters counters = scene_.levelCounters();
  RenderReport report;
  report.seconds = report_.seconds;
  report.draw_seconds = report_.stages.draw;
  report.missing_share = report_.missing_share;
  report.step_vox = report_.step_vox;
  report.why_empty = why_empty_;
  report.empty_channels = empty_channels_;
  report.white = report_.white;
  report.grey = report_.grey;
  report.black = report_.black;
  if (report_.cut) {
    report.coarse_share = report_.cut->coarse_share;
    report.is_refined = report_.cut->is_final;
    report.will_improve = report_.cut->will_improve;
    for (const CutSummary::Level& shown : report_.cut->levels) report.levels.push_back(shown.level);
  }
  report.pages_loaded = report_.pages_loaded;
  report.read_bytes = scene_.storedBytesRead();
  report.volume_buffer = level(counters.volume_buffer);
  report.texture_buffer = level(counters.texture_buffer);
  report.texture_cache = level(counters.texture_cache);
  report.pages = counters.pages;
  report.page_bytes = static_cast<uint64_t>(scene_.session->page().pageBytes());
  if (!maps) return report;
  // The first channel's chunks, numbered in the order of their first pages.
  std::unordered_map<ChunkId, uint32_t> numbers;
  for (const ChunkId chunk : cache.pageMap())
    report.page_chunks.push_back(
        chunk == TextureCache::kNoChunk
            ? 0
            : numbers.try_emplace(chunk, static_cast<uint32_t>(numbers.size() + 1)).first->second);
  const Vec3i grid = opened_->volume.layout.grid;
  report.block_grid = {grid.x, grid.y, grid.z};
  report.block_classes = blockClasses();
  return report;
}

std::vector<uint8_t> Drawing::blockClasses() const {
  const int64_t blocks = opened_->volume.layout.blockCount();
  const VisibleBlocksPtr visible = scene_.session->lastVisible();
  if (visible == nullptr || blocks > RenderReport::kMostMappedBlocks) return {};
  std::vector<uint8_t> classes(static_cast<size_t>(blocks), 0);
  const BlockLayout& finest = opened_->volume.layout;
  const PyramidLayout pyramid = opened_->volume.step().layout();
  for (const ObjectBlock& block : visible->blocks) {
    const uint8_t kind = block.kind == BlockClass::kBlack ? 2 : 1;
    const Box3 covered = pyramid.finestBlocksOf(block.name);
    for (int64_t z = covered.lo.z; z < covered.hi.z; ++z)
      for (int64_t y = covered.lo.y; y < covered.hi.y; ++y)
        for (int64_t x = covered.lo.x; x < covered.hi.x; ++x)
          classes[static_cast<size_t>(finest.idOf({x, y, z}))] = kind;
  }
  return classes;
}

PicturePlan Drawing::plan(const PictureOptions& picture, ProgressTeller& teller) {
  refuseInSitu("plan()");
  const Reading reading(*this, teller);
  if (!scene_.more.empty())
    fail("{}: a plan is of one channel, not {}; open the volume with one", scene_.volume.name,
         scene_.layers().size());
  const TimeStep step = stepAt(picture.time, reading.pass);
  return planOf(scene_, step, looked(picture, step, reading.pass));
}

std::optional<VoxelProbe> Drawing::probe(const PictureOptions& picture, double right, double down,
                                         ProgressTeller& teller) {
  refuseInSitu("probe()");
  const Reading reading(*this, teller);
  const TimeStep step = stepAt(picture.time, reading.pass);
  const FrameOptions options = framed(picture, step, reading.pass);
  const View view = resolve(options.camera, layout(), options.size, 1);
  return probeAlong({options, view, scene_.look.transfer, right, down}, *scene_.session, step,
                    teller.stop());
}

SliceValues Drawing::slice(const SliceOptions& slice, ProgressTeller& teller) {
  refuseInSitu("slice()");
  const Reading reading(*this, teller);
  return sliceOf(slice, *scene_.session, stepAt(slice.time, reading.pass), teller.stop());
}

void Drawing::recordTo(const std::string& path) {
  scene_.recordTo(path);
}

Drawing::~Drawing() {
  try {
    scene_.keepLearntRanges();
    recordTo({});
  } catch (const std::exception&) {  // NOLINT: nobody is there to be told
  }
}

}  // namespace sluice
