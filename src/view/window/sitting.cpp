#include "src/view/window/sitting.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <system_error>
#include <utility>

#include "src/view/state_file.h"

namespace sluice {
namespace {

using namespace std::chrono_literals;

// Wheel and keys that follow each other so soon belong together.
constexpr auto kTogether = 600ms;
constexpr auto kHandRests = 150ms;
constexpr size_t kMostMessages = 6;
constexpr size_t kMostTimes = 8192;

double secondsSince(WindowClock::time_point then) {
  return std::chrono::duration<double>(WindowClock::now() - then).count();
}

// Of the system's monotonic clock, as who sends events reads it.
double clockSeconds(WindowClock::time_point when) {
  return std::chrono::duration<double>(when.time_since_epoch()).count();
}

}  // namespace

Sitting::Sitting(const WindowRequest& given, const std::function<void()>& wake)
    : request(given),
      desk(*given.desk),
      log(given.log_file),
      settings(given.settings),
      dialog(wake) {}

void Sitting::change(const ViewState& next) {
  if (next == state()) return;
  if (film_from) {
    // The way back leads to the view, not to a frame.
    history.replace(*std::exchange(film_from, std::nullopt));
    is_film_playing = false;
  }
  const auto now = WindowClock::now();
  if (!hand_is_on && now - moved_at > kTogether) ++gesture_;
  moved_at = now;
  if (!hand_is_on) nudged_at_ = now;
  history.change(next, gesture_);
}

void Sitting::say(const std::string& line) {
  messages.push_front(line);
  if (messages.size() > kMostMessages) messages.pop_back();
  if (request.say) request.say(line);
}

void Sitting::open(const std::string& path) {
  if (path.empty()) return;
  ViewedVolume volume;
  volume.paths = {path};
  desk.open(volume, std::nullopt);
  shows_open = false;
}

void Sitting::openAny(const std::vector<std::string>& paths) {
  if (paths.empty()) return;
  if (paths.size() == 1 && std::filesystem::path(paths.front()).extension() == ".json") {
    desk.loadState(paths.front());
    shows_open = false;
    return;
  }
  if (paths.size() == 1) return open(paths.front());
  ViewedVolume volume;
  volume.paths = paths;
  desk.open(volume, std::nullopt);
  shows_open = false;
}

void Sitting::savePicture(const std::string& path) {
  if (!isOpen()) return;
  Wish wish;
  wish.state = state();
  wish.width = pane.width;
  wish.height = pane.height;
  desk.savePicture(path, wish);
}

void Sitting::saveState(const std::string& name) {
  if (!isOpen()) return;
  const bool has_film = film != ViewPath{} && hasFilm();
  desk.saveText(name, stateText(opened->volume, film_from.value_or(state()),
                                has_film ? std::optional(film) : std::nullopt));
}

void Sitting::showFrom(ViewOptions::From from) {
  if (!isOpen()) return;
  ViewState next = state();
  const ViewOptions last = next.view;
  next.view = ViewOptions{};
  next.view.from = from;
  next.view.projection = last.projection;
  next.view.field_of_view_deg = last.field_of_view_deg;
  desk.place(next, pane.width, pane.height);
}

void Sitting::toggleProjection() {
  if (!isOpen()) return;
  ViewState next = state();
  const bool is_perspective = next.view.projection == ViewOptions::Projection::kPerspective;
  next.view = withProjection(
      next.view,
      is_perspective ? ViewOptions::Projection::kParallel : ViewOptions::Projection::kPerspective,
      pane, ground);
  change(next);
}

void Sitting::takeOpened(std::unique_ptr<OpenedVolumeNews> news) {
  opened = std::move(news);
  ground = groundOf(opened->info);
  history = History<ViewState>(opened->state);
  sent_.reset();
  unanswered_.clear();
  hovered.reset();
  picture = {};
  slice_at = {-1, -1, -1};
  is_playing = false;
  film = {};
  film_from.reset();
  is_film_playing = false;
  for (const std::string& warning : opened->info.warnings) messages.push_front(warning);
  while (messages.size() > kMostMessages) messages.pop_back();
  keepRecent();
  if (!request.settings_file.empty()) desk.saveText(request.settings_file, settingsText(settings));
  log.write({{"opened", opened->volume.paths.front()},
             {"dims", opened->info.dims},
             {"time_steps", opened->info.time_steps},
             {"device", opened->device}});
}

// Several files, and those of which their name says not all, are not opened again by one path.
void Sitting::keepRecent() {
  const ViewedVolume& volume = opened->volume;
  const VolumeOptions& said = volume.options;
  if (volume.paths.size() != 1 || said.dims || !said.type.empty() || !said.grid.empty() ||
      said.channel || !said.channel_name.empty())
    return;
  std::string recent = volume.paths.front();
  std::error_code unknown;
  if (!recent.starts_with("synth:")) {
    const auto absolute = std::filesystem::absolute(recent, unknown);
    if (!unknown) recent = absolute.string();
  }
  noteRecent(settings, recent);
}

void Sitting::takeVanished(const std::string& gone) {
  if (std::erase(settings.recent, gone) == 0) return;
  log.write({{"vanished", gone}});
  if (!request.settings_file.empty()) desk.saveText(request.settings_file, settingsText(settings));
}

void Sitting::takePicture(ShownPicture shown) {
  picture = std::move(shown);
  if (picture.screen) {
    texture.show(*std::exchange(picture.screen, std::nullopt));
  } else if (keeps_pixels) {
    texture.drop();
  } else {
    texture.set(picture.width, picture.height, std::exchange(picture.rgba, {}));
  }
  picture_is_new = true;
}

void Sitting::notePresented() {
  slice_is_new = {};
  if (!std::exchange(picture_is_new, false)) return;
  while (!unanswered_.empty() && unanswered_.front().first <= picture.wish) {
    if (times.answer_s.size() < kMostTimes)
      times.answer_s.push_back(secondsSince(unanswered_.front().second));
    unanswered_.pop_front();
  }
  log.write({{"picture", picture.wish},
             {"complete", picture.is_complete},
             {"size", {picture.width, picture.height}},
             {"time", picture.time},
             {"seconds", picture.seconds},
             {"of_newest", picture.wish == sent_number_},
             {"at", clockSeconds(WindowClock::now())}});
}

void Sitting::takeNews() {
  News news = desk.take();
  status = desk.status();
  if (news.opened) takeOpened(std::move(news.opened));
  if (news.state) change(*news.state);
  if (news.path) film = *news.path;
  for (const std::string& gone : news.vanished) takeVanished(gone);
  if (status.frames_written != seen_frames_) {
    seen_frames_ = status.frames_written;
    log.write({{"written", status.frames_written}, {"of", status.frames}});
  }
  if (news.picture) takePicture(std::move(*news.picture));
  for (const ShownSlice& slice : news.slices) {
    const auto axis = static_cast<size_t>(slice.axis);
    slices[axis].set(slice.width, slice.height, slice.rgba);
    slice_at[axis] = slice.at;
    slice_is_new[axis] = true;
    log.write({{"slice", slice.axis}, {"at", slice.at}});
  }
  if (news.look) look = std::move(*news.look);
  if (news.report) report = std::move(*news.report);
  if (news.probe && news.probe->number == probe_number) {
    if (centers_on_probe && news.probe->found && isOpen()) {
      ViewState next = state();
      const auto& world = news.probe->found->world;
      next.view = centerOn(next.view, {world[0], world[1], world[2]});
      for (size_t a = 0; a < 3; ++a)
        next.cross[a] = std::clamp(int64_t{std::llround(news.probe->found->voxel[a])}, int64_t{0},
                                   info().dims[a] - 1);
      change(next);
      log.write({{"centered", news.probe->found->voxel}});
    }
    hovered = news.probe->found;
    if (hovered) log.write({{"value", hovered->value}, {"voxel", hovered->voxel}});
    centers_on_probe = false;
  }
  for (const SavedNews& saved : news.saved) {
    if (saved.path == request.settings_file) continue;
    say(saved.command.empty() ? saved.path : saved.command);
    log.write({{"saved", saved.path}, {"command", saved.command}});
  }
  for (const std::string& failure : news.failures) {
    failures.push_back(failure);
    wakeBy(WindowClock::now());  // a window of ImGui's shows in the frame after its first
    log.write({{"failure", failure}});
  }
}

void Sitting::sendWish() {
  if (!isOpen() || pane.width < 8 || pane.height < 8) return;
  Wish wish;
  wish.state = state();
  wish.width = pane.width;
  wish.height = pane.height;
  wish.showing_s = showing_s;
  const bool moves = hand_is_on || is_film_playing || WindowClock::now() - nudged_at_ < kHandRests;
  if (is_playing) wish.next_time = (state().time + 1) % info().time_steps;
  const bool is_same = sent_ && sent_->state == wish.state && sent_->width == wish.width &&
                       sent_->height == wish.height;
  // The hand that let go wants the whole picture of what it saw last.
  if (is_same && (!sent_->moves || moves)) {
    if (sent_->moves && !hand_is_on) wakeBy(nudged_at_ + kHandRests + 1ms);
    return;
  }
  wish.moves = moves && !is_playing;
  if (wish.moves && !hand_is_on) wakeBy(nudged_at_ + kHandRests + 1ms);
  sent_ = wish;
  sent_number_ = desk.wish(wish);
  if (!is_same) unanswered_.emplace_back(sent_number_, event_at);
  log.write({{"wish", sent_number_}, {"moves", wish.moves}, {"event_at", clockSeconds(event_at)}});
}

std::string Sitting::incompleteText() const {
  if (status.doing == DeskStatus::Doing::kOpening)
    return fmt::format("{} {:.0f} %", status.is_indexing ? "indexing" : "opening",
                       100 * status.share);
  if (!isOpen()) return {};
  if (picture.wish == sent_number_ && picture.is_complete) return {};
  std::string text = "preview";
  if (picture.missing_share > 0)
    text = fmt::format("{:.0f} % of it is not read yet", 100 * picture.missing_share);
  if (status.doing == DeskStatus::Doing::kPicture)
    text += fmt::format(", drawing {:.0f} %", 100 * status.share);
  return text;
}

void Sitting::play() {
  if (!is_playing || !isOpen() || info().time_steps < 2) return;
  const double waited = secondsSince(step_at_);
  const bool was_seen =
      picture.is_complete && picture.wish == sent_number_ && picture.time == state().time;
  if (!was_seen) return;  // its picture's news will wake us
  if (waited < 1 / steps_per_second) {
    wakeBy(step_at_ + std::chrono::duration_cast<WindowClock::duration>(
                          std::chrono::duration<double>(1 / steps_per_second)));
    return;
  }
  achieved_steps = waited > 5 ? 0 : 0.7 * achieved_steps + 0.3 / waited;
  step_at_ = WindowClock::now();
  event_at = step_at_;
  ViewState next = state();
  next.time = (next.time + 1) % info().time_steps;
  history.replace(next);
}

}  // namespace sluice
