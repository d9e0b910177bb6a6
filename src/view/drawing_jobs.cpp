// What the drawing thread does: each job's own function. None of them holds the lock while
// something is read or drawn.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <system_error>
#include <utility>

#include "src/base/clock.h"
#include "src/base/error.h"
#include "src/view/drawing_thread.h"
#include "src/view/state_file.h"
#include "src/view/transfer_edit.h"

namespace sluice {
namespace {

// How long the whole picture waits for what is on disk before it is shown with what is there.
constexpr double kRefine_s = 0.4;
// Where less than this came in that time, waiting for all of it is shorter.
constexpr double kWorthShowing = 0.01;
constexpr size_t kMostTimes = 8192;
constexpr std::array<float, 3> kPaneColor{0.09F, 0.09F, 0.1F};

void keep(std::vector<double>& times, double seconds) {
  if (times.size() >= kMostTimes) times.erase(times.begin(), times.begin() + kMostTimes / 2);
  times.push_back(seconds);
}

std::vector<uint8_t> greys(const SliceValues& slice, std::array<double, 2> range) {
  std::vector<uint8_t> rgba(slice.values.size() * 4, 255);
  const auto lo = static_cast<float>(range[0]);
  const auto factor = static_cast<float>(255 / (range[1] - range[0]));
  for (size_t i = 0; i < slice.values.size(); ++i) {
    const auto grey =
        static_cast<uint8_t>(std::clamp((slice.values[i] - lo) * factor, 0.0F, 255.0F));
    rgba[4 * i] = rgba[4 * i + 1] = rgba[4 * i + 2] = grey;
  }
  return rgba;
}

}  // namespace

void DrawingThread::doJob(const Job& job) {
  switch (job.doing) {
    case Doing::kOpening:
      return openAny(job);
    case Doing::kPreview:
      return drawPreview(job);
    case Doing::kPicture:
      return drawWhole(job);
    case Doing::kSlices:
      return makeSlices(job);
    case Doing::kProbe:
      return answerProbe(job);
    case Doing::kSaving:
      return save(job);
    case Doing::kFrame:
      return writeFrame(job);
    case Doing::kNothing:
      return deliverReport();
  }
}

ProgressFunction DrawingThread::progressOf(const Job& job) {
  return [this, doing = job.doing](const Progress& progress) {
    const MutexLock lock(mutex_);
    if (status_.doing != doing) return;
    status_.share = progress.share();
    status_.is_indexing = progress.stage != Progress::Stage::kDrawing;
  };
}

void DrawingThread::openAny(const Job& job) {
  OpenRequest request = job.open;
  if (!request.state_file.empty()) {
    StateFile file = readState(request.state_file);
    if (file.volume) request.volume = std::move(*file.volume);
    if (!file.volume && opened_.renderer == nullptr)
      sluice::fail("{}: names no volume, and none is open", request.state_file);
    if (!file.volume) {
      if (!file.state.view.look_at)
        file.state.view = opened_.renderer->placed(pictureOf(file.state, 800, 600));
      const MutexLock lock(mutex_);
      news_.state = std::make_unique<ViewState>(std::move(file.state));
      news_.path = std::move(file.path);
    } else {
      request.state = std::move(file.state);
      request.path = std::move(file.path);
    }
  }
  if (request.volume.paths.empty()) return tell();
  try {
    openVolume(request, job);
  } catch (const Cancelled&) {
    throw;
  } catch (const std::exception&) {
    noteVanished(request.volume.paths);
    throw;
  }
}

void DrawingThread::noteVanished(const std::vector<std::string>& paths) {
  std::error_code unknown;
  if (paths.size() != 1 || std::filesystem::exists(paths.front(), unknown) || unknown) return;
  const MutexLock lock(mutex_);
  news_.vanished.push_back(paths.front());
}

void DrawingThread::openVolume(const OpenRequest& request, const Job& job) {
  const bool is_first = opened_.renderer == nullptr;
  Opened next;
  next.viewed = request.volume;
  // Its index goes where the first one's does.
  if (next.viewed.options.index_folder.empty())
    next.viewed.options.index_folder = options_.index_folder;
  next.volume.emplace(next.viewed.paths, next.viewed.options, progressOf(job), job.stop);
  std::optional<ViewState> given = request.state;
  if (!given && is_first && options_.is_saved_state) given = options_.state;
  auto news = std::make_unique<OpenedVolumeNews>();
  news->volume = next.viewed;
  news->info = next.volume->info();
  news->histogram = next.volume->histogram();
  next.ground = groundOf(news->info);
  ViewState& state = news->state;
  if (given) {
    state = *given;
  } else {
    if (is_first) state = options_.state;
    state.time = std::clamp<int64_t>(next.viewed.options.time, 0, news->info.time_steps - 1);
    for (size_t a = 0; a < 3; ++a) state.cross[a] = news->info.dims[a] / 2;
  }
  next.look = next.shown_look = state.look;
  // The levels of the volume before go first: both together may be more than the memory allows. Its
  // handle stays, for the case that the new one cannot be drawn.
  const std::optional<Volume> last = opened_.volume;
  opened_.renderer.reset();
  RendererOptions options = options_.renderer;
  {
    const MutexLock lock(mutex_);
    options.screen = screen_;
  }
  try {
    next.renderer = std::make_unique<Renderer>(*next.volume, next.look, options);
    state.view = next.renderer->placed(pictureOf(state, 800, 600), progressOf(job), job.stop);
  } catch (const std::exception&) {
    if (last) opened_.renderer = std::make_unique<Renderer>(*last, opened_.look, options);
    throw;
  }
  if (is_first && !options_.trace_file.empty()) next.renderer->recordTo(options_.trace_file);
  news->device = next.renderer->deviceName();
  auto look = std::make_unique<ShownLook>(next.renderer->shownLook());
  opened_ = std::move(next);
  {
    const MutexLock lock(mutex_);
    is_open_ = true;
    // What was wished of the volume before is not of this one.
    previewed_ = sliced_ = status_.completed = status_.wished;
    wish_.reset();
    unanswered_.clear();
    probe_.reset();
    endFilm();
    news_.path = request.path;
    if (is_first && !request.path) news_.path = options_.path;
    news_.opened = std::move(news);
    news_.look = std::move(look);
    news_.picture.reset();
    news_.slices.clear();
    status_.is_indexing = false;
  }
  tell();
}

void DrawingThread::useLook(const LookOptions& look, bool is_shown) {
  if (look != opened_.look) {
    opened_.renderer->setLook(look);
    opened_.look = look;
  } else if (look == opened_.shown_look) {
    return;
  }
  if (!is_shown) return;
  opened_.shown_look = look;
  auto shown = std::make_unique<ShownLook>(opened_.renderer->shownLook());
  const MutexLock lock(mutex_);
  news_.look = std::move(shown);
}

double DrawingThread::wholeStep(const Wish& wish) const {
  if (wish.state.step_vox) return *wish.state.step_vox;
  if (wish.state.look.mode != LookOptions::Mode::kComposite) return 1;
  const double pixel = worldPerPixel(wish.state.view, {wish.width, wish.height}, opened_.ground);
  return pixel < opened_.ground.finest_spacing ? 0.5 : 1;
}

Image DrawingThread::drawImage(const Job& job, const PictureOptions& picture) {
  return opened_.renderer->draw(picture, progressOf(job), job.stop);
}

ShownPicture DrawingThread::draw(const Job& job, const PictureOptions& picture, double step_vox) {
  const auto background = job.wish->wish.state.background.value_or(kPaneColor);
  ShownPicture shown;
  shown.screen = opened_.renderer->drawOnScreen(picture, background, progressOf(job), job.stop);
  if (shown.screen) {
    shown.width = shown.screen->width;
    shown.height = shown.screen->height;
    shown.missing_share = shown.screen->missing_share;
  } else {
    const Image image = drawImage(job, picture);
    shown.width = image.width;
    shown.height = image.height;
    shown.missing_share = image.missing_share;
    shown.rgba = image.toRgba8(background);
  }
  const RenderReport report = opened_.renderer->report();
  if (report.missing_share == 0)
    opened_.pace = learned(
        opened_.pace, {static_cast<double>(picture.width) * picture.height, step_vox,
                       report.draw_seconds, std::max(0.0, report.seconds - report.draw_seconds)});
  return shown;
}

void DrawingThread::drawPreview(const Job& job) {
  const Wish& wish = job.wish->wish;
  const Stopwatch watch;
  useLook(wish.state.look);
  PictureOptions picture = pictureOf(wish.state, wish.width, wish.height);
  const double step = wholeStep(wish);
  const double budget_s = drawingBudget(options_.budget_s, wish.showing_s);
  const Quality quality =
      qualityWithin(opened_.pace, static_cast<double>(wish.width) * wish.height, step, budget_s);
  if (!quality.isFull()) {
    picture.width = std::max(1, static_cast<int>(std::lround(wish.width * quality.scale)));
    picture.height = std::max(1, static_cast<int>(std::lround(wish.height * quality.scale)));
    picture.step_vox = step * quality.step_factor;
  }
  picture.time_limit_s = 1.25 * budget_s;
  ShownPicture shown = draw(job, picture, step * quality.step_factor);
  const bool is_complete = quality.isFull() && shown.missing_share == 0;
  deliver(job.wish, std::move(shown), is_complete, watch.seconds());
}

void DrawingThread::drawWhole(const Job& job) {
  const Wish& wish = job.wish->wish;
  const Stopwatch watch;
  useLook(wish.state.look);
  PictureOptions picture = pictureOf(wish.state, wish.width, wish.height);
  picture.next_time = wish.next_time;
  double missing = 1;
  // What is there is shown as it comes, as long as that is worth a picture.
  while (true) {
    picture.time_limit_s = kRefine_s;
    ShownPicture shown = draw(job, picture, wholeStep(wish));
    const double came = missing - shown.missing_share;
    missing = shown.missing_share;
    deliver(job.wish, std::move(shown), missing == 0, watch.seconds());
    if (missing == 0) return;
    if (came < kWorthShowing) break;
  }
  picture.time_limit_s.reset();
  deliver(job.wish, draw(job, picture, wholeStep(wish)), true, watch.seconds());
}

void DrawingThread::deliver(const WishPtr& wish, ShownPicture picture, bool is_complete,
                            double seconds) {
  auto shown = std::make_unique<ShownPicture>(std::move(picture));
  shown->wish = wish->number;
  shown->is_complete = is_complete;
  shown->time = wish->wish.state.time;
  shown->seconds = seconds;
  const auto now = Clock::now();
  {
    const MutexLock lock(mutex_);
    // The one before, if nobody took it, goes when nobody waits for the lock.
    news_.picture.swap(shown);
    previewed_ = std::max(previewed_, wish->number);
    ++(is_complete ? times_.complete : times_.previews);
    while (!unanswered_.empty() && unanswered_.front().first <= wish->number) {
      keep(times_.answer_s,
           std::chrono::duration<double>(now - unanswered_.front().second).count());
      unanswered_.pop_front();
    }
    if (is_complete) {
      status_.completed = wish->number;
      keep(times_.complete_s, std::chrono::duration<double>(now - wish->asked_at).count());
    }
  }
  tell();
}

void DrawingThread::makeSlices(const Job& job) {
  const ViewState& state = job.wish->wish.state;
  const VolumeInfo& info = opened_.volume->info();
  std::array<double, 2> range = state.look.range.value_or(info.value_range);
  if (range[0] == range[1]) range[1] = range[0] + 1;
  for (int axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<size_t>(axis);
    Opened::Slice& kept = opened_.slices[a];
    const int64_t at = std::clamp<int64_t>(state.cross[a], 0, info.dims[a] - 1);
    const bool is_same = kept.at == at && kept.time == state.time;
    if (is_same && kept.range == range) continue;
    if (!is_same) {
      kept.at = -1;
      kept.values = opened_.renderer->slice(
          {.axis = axis, .at = at, .time = state.time, .most = 512}, job.stop);
      kept.at = at;
      kept.time = state.time;
    }
    kept.range = range;
    ShownSlice shown{axis, at, kept.values.width, kept.values.height, greys(kept.values, range)};
    const MutexLock lock(mutex_);
    std::erase_if(news_.slices, [axis](const ShownSlice& other) { return other.axis == axis; });
    news_.slices.push_back(std::move(shown));
  }
  {
    const MutexLock lock(mutex_);
    sliced_ = std::max(sliced_, job.wish->number);
  }
  tell();
}

void DrawingThread::answerProbe(const Job& job) {
  if (job.place) {
    useLook(job.place->state.look);
    auto state = std::make_unique<ViewState>(job.place->state);
    state->view = opened_.renderer->placed(pictureOf(*state, job.place->width, job.place->height),
                                           {}, job.stop);
    {
      const MutexLock lock(mutex_);
      news_.state = std::move(state);
    }
    return tell();
  }
  const Wish& wish = job.wish->wish;
  useLook(wish.state.look);
  ProbeNews news{job.probe.number,
                 opened_.renderer->probe(pictureOf(wish.state, wish.width, wish.height),
                                         job.probe.right, job.probe.down, job.stop)};
  {
    const MutexLock lock(mutex_);
    news_.probe = news;
  }
  tell();
}

void DrawingThread::deliverReport() {
  bool maps = false;
  {
    const MutexLock lock(mutex_);
    wants_report_ = false;
    maps = std::exchange(wants_maps_, false);
  }
  auto report = std::make_unique<RenderReport>(opened_.renderer->report(maps));
  {
    const MutexLock lock(mutex_);
    news_.report = std::move(report);
  }
  tell();
}

}  // namespace sluice
