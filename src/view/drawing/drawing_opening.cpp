// How the drawing thread opens volumes and saved views.
#include <algorithm>
#include <filesystem>
#include <system_error>
#include <utility>

#include "src/base/error.h"
#include "src/options/option_rules.h"
#include "src/view/drawing/drawing_jobs.h"
#include "src/view/drawing/picture_file.h"
#include "src/view/state/view_check.h"

namespace sluice {
namespace {

// The size that a view is placed for before a window has sent its own.
constexpr int kWidth = 800, kHeight = 600;

bool isGone(const std::vector<std::string>& paths) {
  std::error_code unknown;
  return paths.size() == 1 && !std::filesystem::exists(paths.front(), unknown) && !unknown;
}

}  // namespace

void DrawingJobs::lend(std::shared_ptr<const ScreenContext> screen) {
  // The window lends from its own thread, before it asks for a volume.
  const MutexLock lock(screen_mutex_);
  screen_ = std::move(screen);
}

std::unique_ptr<Renderer> DrawingJobs::makeRenderer(const Volume& volume,
                                                    const LookOptions& look) const {
  RendererOptions options = options_.renderer;
  {
    const MutexLock lock(screen_mutex_);
    options.screen = screen_;
  }
  return std::make_unique<Renderer>(volume, look, options);
}

void DrawingJobs::run(const OpenJob& task, const Job& job) {
  OpenJob open = task;
  if (!open.state_file.empty()) {
    // The file is read here and not by the window, whose loop must not wait for a disk.
    StateFile file = readState(open.state_file);
    if (!file.volume) return loadInto(std::move(file), open.state_file, job);
    open.volume = std::move(*file.volume);
    open.state = std::move(file.state);
    open.path = std::move(file.path);
  }
  try {
    openVolume(open, job);
  } catch (const Cancelled&) {
    throw;
  } catch (const std::exception&) {
    // A recent file that was deleted leaves the list, whatever reader complained about it.
    if (isGone(open.volume.paths))
      news_.add([&](News& news) { news.vanished.push_back(open.volume.paths.front()); });
    throw;
  }
}

void DrawingJobs::loadInto(StateFile file, const std::string& name, const Job& job) {
  // A view without a volume is one for the volume that is open.
  if (!opened_.volume) fail("{}: the file names no volume, and no volume is open", name);
  requireFits(file.state, file.path, opened_.volume->info(), name);
  // The view fits what is visible in the saved look.
  useLook(file.state);
  // A view is placed for the pane of the newest wish. Before the first one, nobody knows the size
  // of the pane.
  const Wish pane = job.wish != nullptr ? job.wish->wish : Wish{.width = kWidth, .height = kHeight};
  file.state.view = placed(file.state, pane.width, pane.height, job);
  if (file.path) placeKeys(*file.path, *opened_.renderer, progress(), job.stop);
  news_.add([&](News& news) {
    news.state = std::make_unique<ViewState>(std::move(file.state));
    news.path = std::move(file.path);
  });
}

void DrawingJobs::close() {
  endTrace();
  news_.dropPicture();
  opened_ = {};
}

void DrawingJobs::endTrace() {
  if (!std::exchange(opened_.is_recorded, false)) return;
  try {
    opened_.renderer->recordTo({});
  } catch (const std::exception& error) {
    tellFailure(error.what());
  }
}

void DrawingJobs::openVolume(OpenJob task, const Job& job) {
  const bool is_first = !opened_.volume;
  Opened next;
  next.viewed = std::move(task.volume);
  // Its index goes to the first one's folder.
  if (next.viewed.options.index_folder.empty())
    next.viewed.options.index_folder = options_.index_folder;
  if (options_.web_of) next.viewed.options.web = options_.web_of(namesOf(next.viewed));
  // A window is there before its volume, and does not wait for a pass over all voxels.
  VolumeOptions how = next.viewed.options;
  how.opens_soon = true;
  next.volume.emplace(next.viewed.paths, how, progress(), job.stop);
  // The options of the command line belong to the volume that it names, and not to others that are
  // opened later.
  if (is_first && !task.path) task.path = options_.path;
  if (is_first && !task.state && !options_.state_file.empty()) {
    task.state = options_.state;
    task.state_file = options_.state_file;
  }
  auto news = std::make_unique<OpenedVolumeNews>();
  news->volume = next.viewed;
  news->info = next.volume->info();
  news->histogram = next.volume->histogram();
  ViewState& state = news->state;
  if (task.state) {
    state = *task.state;
    // The check comes before the volume that is open is let go.
    requireFits(state, task.path, news->info,
                task.state_file.empty() ? next.viewed.paths.front() : task.state_file);
  } else {
    if (is_first) state = options_.state;
    state.time = std::clamp<int64_t>(next.viewed.options.time, 0, news->info.time_steps - 1);
    for (size_t a = 0; a < 3; ++a) state.cross[a] = news->info.dims[a] / 2;
  }
  next.look = next.shown_look = lookOf(state);
  // The levels of the volume before go first: both together may be more than the memory allows. Its
  // handle stays, so that useLook() can bring them back.
  if (!is_first) savePictures(job);
  if (opened_.is_recorded) {
    endTrace();
    news_.add([&](News& news) {
      news.notes.push_back(options_.trace_file +
                           ": the trace ends, because another volume takes the place of the first");
    });
  }
  news_.dropPicture();
  opened_.renderer.reset();
  next.renderer = makeRenderer(*next.volume, next.look);
  state.view = next.renderer->placed(pictureOf(state, kWidth, kHeight), progress(), job.stop);
  if (task.path) placeKeys(*task.path, *next.renderer, progress(), job.stop);
  if (is_first && !options_.trace_file.empty()) {
    next.renderer->recordTo(options_.trace_file);
    next.is_recorded = true;
  }
  news->device = next.renderer->deviceName();
  // All that can fail has been done. From here on, the new volume takes the place of the old one.
  auto look = std::make_unique<ShownLook>(next.renderer->shownLook());
  opened_ = std::move(next);
  if (const auto film = queue_.noteOpened())
    tellFailure(endedFilm(*film, "another volume was opened"));
  news_.add([&](News& all) {
    all.path = std::move(task.path);
    all.opened = std::move(news);
    all.look = std::move(look);
    all.picture.reset();
    all.slices.clear();
  });
}

}  // namespace sluice
