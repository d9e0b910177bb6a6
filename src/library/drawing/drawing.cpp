#include "src/library/drawing/drawing.h"

#include <fmt/format.h>

#include <algorithm>
#include <unordered_map>
#include <utility>

#include "src/base/error.h"
#include "src/classify/transfer/transfer_file.h"
#include "src/library/conversions.h"
#include "src/library/drawing/drawn_strips.h"
#include "src/library/drawing/empty_picture.h"
#include "src/library/drawing/exr_contents.h"
#include "src/library/drawing/probing.h"
#include "src/library/drawing/resources.h"
#include "src/library/drawing/strip_file.h"
#include "src/library/drawing/view_fit.h"
#include "src/render/blocks/level_cut.h"
#include "src/render/camera/index_space.h"

namespace sluice {

Drawing::Drawing(std::shared_ptr<const OpenedVolume> opened, const LookOptions& look,
                 const RendererOptions& options)
    : opened_(std::move(opened)),
      machine_(machineOptions(options)),
      pool_(machine_.threads),
      device_(makeDevice(machine_.device, pool_)) {
  const IndexedVolume& volume = opened_->volume;
  const uint64_t memory_bytes = memoryBudget(machine_);
  SessionOptions session = sessionOptions(volume, true, machine_, Partition::kBlocks, memory_bytes);
  // A series holds the ranges of the drawn step in addition to the volume's own.
  if (layout().time_steps > 1) session.beside_bytes *= 2;
  FrameOptions frame;
  frame.mode = modeOf(look);
  const ChosenLook first = lookFor(volume, lookArguments(look, opened_->whole_series), frame.mode);
  session.beside_bytes += planBytes(volume, first.transfer, frame, pool_);
  if (options.rows_width > 0 && options.rows_height > 0) {
    frame.size = {options.rows_width, options.rows_height};
    const BesideShare share = besideShare(volume, machine_, Partition::kBlocks,
                                          pictureDemand(machine_, frame), session.beside_bytes);
    strip_bytes_ = share.picture_bytes;
    session.beside_bytes = share.beside_bytes;
  }
  session.page.pages = pageCount(machine_, volume, session.beside_bytes);
  session_ = std::make_unique<Session>(volume.step(), *device_, pool_, session);
  if (options.screen != nullptr) screen_ = dynamic_cast<DrawsForScreens*>(device_.get());
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
  requireStep(time, layout());
  const IndexedVolume& volume = opened_->volume;
  if (time == volume.time) return volume.step();
  return *steps_[static_cast<size_t>(time % 2)].of(
      time, [&] { return stepOfSeries(volume, time, pass); });
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

FrameOptions Drawing::framed(const PictureOptions& picture, const TimeStep& step,
                             const IndexPass& pass) {
  FrameOptions options = frameOptions(picture, layout(), mode_);
  if (!options.camera.framing)
    options.camera.framing =
        framingFor({options.camera}, fitChoice(picture.view), options, step, pass);
  return options;
}

FrameOptions Drawing::looked(const PictureOptions& picture, const TimeStep& step,
                             const IndexPass& pass) {
  FrameOptions options = framed(picture, step, pass);
  if (options.cut)
    options.cut->most_held_bytes = cutBytes(memoryBudget(machine_), PictureRow::kMore);
  if (!picture.step_vox && mode_ == Mode::kComposite) {
    const View view = resolve(options.camera, layout(), options.size, options.step_vox);
    const bool is_cut = drawsCut(step, options.cut, mode_, look_.transfer.labels);
    options.step_vox = stepFor(view, step, is_cut ? finestLevelShown(step, view, *options.cut) : 0);
    options.step_follows_cut = is_cut;
  }
  options.shades = look_.lit;
  options.lighting.flat_share *= look_.flat_scale;
  return options;
}

Drawing::ReadyFrame Drawing::ready(const PictureOptions& picture, const IndexPass& pass,
                                   ProgressTeller& teller) {
  const TimeStep step = stepAt(picture.time, pass);
  FrameOptions options = looked(picture, step, pass);
  options.stop = teller.stop();
  options.watch = teller.watch(Progress::Stage::kDrawing);
  session_->setTimeStep(step);
  session_->setOptions(options);
  if (picture.next_time && *picture.next_time != picture.time)
    session_->expectAfterwards(stepAt(*picture.next_time, pass));
  return {std::move(options), step.time};
}

void Drawing::keepReport(const ReadyFrame& frame, const FrameReport& report, bool shows_something,
                         const IndexPass& pass) {
  report_ = report;
  why_empty_.clear();
  if (!shows_something)
    why_empty_ = whyEmpty(
        {opened_->volume, frame.time, look_.transfer, frame.options, report_.missing_share}, pass);
}

Image Drawing::draw(const PictureOptions& picture, ProgressTeller& teller) {
  return drawFrame(
      picture, [](const Picture& drawn) { return !showsNothing(drawn); }, teller);
}

Image Drawing::drawFrame(const PictureOptions& picture,
                         const std::function<bool(const Picture&)>& showsSomething,
                         ProgressTeller& teller) {
  const ProgressRelay::Call call(*opened_->relay, teller);
  frameOptions(picture, layout(), mode_);  // throws before anything is read
  ProgressMeter progress(teller.watch(Progress::Stage::kIndexing));
  const IndexPass pass{pool_, progress, memoryBudget(machine_), teller.stop()};
  const ReadyFrame of = ready(picture, pass, teller);
  Frame frame = session_->frame();
  Picture& drawn = frame.picture;
  keepReport(of, frame.report, showsSomething(drawn), pass);
  return {.width = drawn.width,
          .height = drawn.height,
          .rgba = std::move(drawn.rgba),
          .depth = std::move(drawn.depth),
          .missing_share = frame.report.missing_share,
          .will_improve = frame.report.cut && frame.report.cut->will_improve};
}

void Drawing::drawStrips(const ReadyFrame& frame, const IndexPass& pass,
                         const std::function<void(const Picture& strip)>& take,
                         ProgressTeller& teller) {
  const PictureDemand demand = pictureDemand(machine_, frame.options);
  const uint64_t bytes = strip_bytes_ >= leastPictureBytes(demand)
                             ? strip_bytes_
                             : pictureBytes(demand, memoryBudget(machine_));
  const std::vector<PictureRows> strips = stripsOf(demand, bytes);
  // The progress of the picture, of which each strip is a part.
  FrameOptions watched = frame.options;
  uint64_t done = 0;
  const ProgressWatch watch = teller.watch(Progress::Stage::kDrawing);
  watched.watch = [&](uint64_t of_strip, uint64_t total) {
    watch(done * total + of_strip, strips.size() * total);
  };
  session_->setOptions(watched);
  const auto drawStrip = [&] {
    Frame strip = session_->frame();
    ++done;
    return strip;
  };
  const DrawnStrips drawn = sluice::drawStrips(*device_, strips, drawStrip, take);
  keepReport(frame, drawn.report, drawn.shows_something, pass);
}

void Drawing::drawRows(const PictureOptions& picture,
                       const std::function<void(const Image& rows)>& take, ProgressTeller& teller) {
  const ProgressRelay::Call call(*opened_->relay, teller);
  frameOptions(picture, layout(), mode_);  // throws before anything is read
  ProgressMeter progress(teller.watch(Progress::Stage::kIndexing));
  const IndexPass pass{pool_, progress, memoryBudget(machine_), teller.stop()};
  const auto takeFew = [&](const Picture& rows, int /*above*/) {
    take({.width = rows.width, .height = rows.height, .rgba = rows.rgba, .depth = rows.depth});
  };
  drawStrips(
      ready(picture, pass, teller), pass,
      [&](const Picture& strip) { eachFewRows(strip, teller.stop(), takeFew); }, teller);
}

void Drawing::drawToFile(const std::string& path, const PictureOptions& picture,
                         const std::optional<std::array<float, 3>>& background,
                         ProgressTeller& teller) {
  const ProgressRelay::Call call(*opened_->relay, teller);
  PictureOptions in_file = picture;
  in_file.with_depth = mode_ == Mode::kComposite && pictureKind(path) == PictureKind::kExr;
  frameOptions(in_file, layout(), mode_);  // throws before anything is read
  ProgressMeter progress(teller.watch(Progress::Stage::kIndexing));
  const IndexPass pass{pool_, progress, memoryBudget(machine_), teller.stop()};
  const ReadyFrame frame = ready(in_file, pass, teller);
  const std::string look = lookOf(frame.options);
  StripFile file(path, {background, false, {}},
                 {frame.options, *opened_->volume.source, look_.transfer, look}, teller.stop());
  drawStrips(
      frame, pass, [&](const Picture& strip) { file.add(strip); }, teller);
  file.commit();
}

std::string Drawing::lookOf(const FrameOptions& options) const {
  if (mode_ != Mode::kComposite) return look_.options;
  return look_.options + fmt::format(" --step {}", options.step_vox);
}

std::optional<ScreenImage> Drawing::drawOnScreen(const PictureOptions& picture,
                                                 const std::array<float, 3>& background,
                                                 ProgressTeller& teller) {
  if (screen_ == nullptr || mode_ != Mode::kComposite || picture.with_depth) return std::nullopt;
  screen_->keepNext(background);
  try {
    std::optional<ScreenPicture> kept;
    const auto takeKept = [&](const Picture&) {
      kept = screen_->takeKept();
      SLUICE_CHECK(kept.has_value());
      return kept->shows_something;
    };
    const Image sizes = drawFrame(picture, takeKept, teller);
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

ViewOptions Drawing::placed(const PictureOptions& picture, ProgressTeller& teller) {
  const ProgressRelay::Call call(*opened_->relay, teller);
  ProgressMeter progress(teller.watch(Progress::Stage::kIndexing));
  const IndexPass pass{pool_, progress, memoryBudget(machine_), teller.stop()};
  Camera camera = framed(picture, stepAt(picture.time, pass), pass).camera;
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
  const ProgressRelay::Call call(*opened_->relay, teller);
  ProgressMeter progress(teller.watch(Progress::Stage::kIndexing));
  const IndexPass pass{pool_, progress, memoryBudget(machine_), teller.stop()};
  const FrameOptions options = looked(picture, stepAt(picture.time, pass), pass);
  const std::string look = lookOf(options);
  const Picture drawn{image.width, image.height, image.rgba, image.depth};
  sluice::writeExr(path,
                   exrContents(drawn, background, false,
                               {options, *opened_->volume.source, look_.transfer, look}),
                   ExrPrecision::kFloat);
}

ShownLook Drawing::shownLook() const {
  ShownLook shown;
  for (const ColorPoint& point : look_.transfer.colors)
    shown.colors.push_back({point.value, {point.rgb.x, point.rgb.y, point.rgb.z}});
  for (const OpacityPoint& point : look_.transfer.opacities)
    shown.opacities.push_back({point.value, point.opacity});
  shown.lit = look_.lit;
  shown.labels = look_.transfer.labels;
  shown.options = look_.options;
  shown.transfer = writeTransferFunction(look_.transfer);
  shown.warnings = look_.warnings;
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
  const TextureCache& cache = session_->textureCache();
  RenderReport report;
  report.seconds = report_.seconds;
  report.draw_seconds = report_.stages.draw;
  report.missing_share = report_.missing_share;
  report.step_vox = report_.step_vox;
  report.why_empty = why_empty_;
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
  report.read_bytes = opened_->volume.source->storedBytesRead();
  report.volume_buffer = level(session_->volumeBufferCounters());
  report.texture_buffer = level(session_->textureBufferCounters());
  report.texture_cache = level(cache.counters());
  report.pages = cache.capacityPages();
  report.page_bytes = static_cast<uint64_t>(session_->page().pageBytes());
  if (!maps) return report;
  // Numbers of chunks in the order of their first pages.
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
  const VisibleBlocksPtr visible = session_->lastVisible();
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

std::optional<VoxelProbe> Drawing::probe(const PictureOptions& picture, double right, double down,
                                         ProgressTeller& teller) {
  const ProgressRelay::Call call(*opened_->relay, teller);
  ProgressMeter progress(teller.watch(Progress::Stage::kIndexing));
  const IndexPass pass{pool_, progress, memoryBudget(machine_), teller.stop()};
  const TimeStep step = stepAt(picture.time, pass);
  const FrameOptions options = framed(picture, step, pass);
  const View view = resolve(options.camera, layout(), options.size, 1);
  return probeAlong({options, view, look_.transfer, right, down}, *session_, step, teller.stop());
}

SliceValues Drawing::slice(const SliceOptions& slice, ProgressTeller& teller) {
  const ProgressRelay::Call call(*opened_->relay, teller);
  ProgressMeter progress(teller.watch(Progress::Stage::kIndexing));
  const IndexPass pass{pool_, progress, memoryBudget(machine_), teller.stop()};
  return sliceOf(slice, *session_, stepAt(slice.time, pass), teller.stop());
}

void Drawing::recordTo(const std::string& path) {
  session_->recordTo(nullptr);
  if (trace_ != nullptr) trace_->finish();
  trace_.reset();
  if (path.empty()) return;
  trace_ = makeTraceWriter(path, traceFormatOf(path),
                           static_cast<uint64_t>(session_->page().pageBytes()));
  session_->recordTo(trace_.get());
}

Drawing::~Drawing() {
  try {
    recordTo({});
  } catch (const std::exception&) {  // NOLINT: nobody is there to be told
  }
}

}  // namespace sluice
