// Between the window and its desk: takes the news, and sends the wish for the current view.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <system_error>

#include "src/options/option_words.h"
#include "src/view/window/window_state.h"

namespace sluice {
namespace {

using namespace std::chrono_literals;

constexpr auto kHandRests = 150ms, kSavedShows = 4000ms;
constexpr auto kSlowFit = 300ms;  // the corner shows a fit that takes longer
constexpr auto kFade = 120ms, kFadeTurn = 16ms;
constexpr size_t kMostTimes = 8192;

// Seconds of the system's monotonic clock, which programs that send events read too.
double clockSeconds(WindowClock::time_point when) {
  return std::chrono::duration<double>(when.time_since_epoch()).count();
}

void keepSettings(WindowState& window) {
  if (!window.request.settings_file.empty())
    window.desk.saveText(window.request.settings_file, settingsText(window.settings), {});
}

// Volumes of several files, and those with options of their own, are not kept, since one path does
// not open them again.
void keepRecent(WindowState& window) {
  const ViewedVolume& volume = window.volume.news->volume;
  if (volume.paths.size() != 1 || !volumeWords(volume.options).empty()) return;
  std::string recent = volume.paths.front();
  std::error_code unknown;
  if (!recent.starts_with("synth:")) {
    // The next start may be in another working directory.
    const auto absolute = std::filesystem::absolute(recent, unknown);
    if (!unknown) recent = absolute.string();
  }
  noteRecent(window.settings, recent);
}

// Whether a picture follows a coarser one of the same view. Pictures of one level do not fade.
bool fadesIn(const ShownPicture& picture, const ShownPicture& before) {
  return !picture.levels.empty() && !before.levels.empty() && picture.state == before.state;
}

void endFade(PictureOnScreen& shown) {
  shown.faded_in_from.reset();
  // The texture goes back to the renderer, which has few of them (ScreenTextures).
  shown.before.drop();
  shown.share = 1;
}

// The value was that of another picture, and so is an answer on its way. A pointer that rests gets
// the new one's.
void forgetReading(Pointer& pointer) {
  pointer.value.reset();
  pointer.still_since = WindowClock::now();
  // A double click still waits for its answer, which the desk gives for the newest view.
  if (!pointer.centers) pointer.question.reset();
}

void takeOpened(WindowState& window, std::unique_ptr<OpenedVolumeNews> news) {
  window.volume.news = std::move(news);
  const OpenedVolumeNews& opened = *window.volume.news;
  window.volume.ground = groundOf(opened.info);
  // Undo does not lead back into another volume, whose views need not fit this one.
  window.history = History<ViewState>(opened.state);
  for (const std::string& line : dropFit(window, "another volume was opened first"))
    window.fail(line);
  // The number goes on, since the desk counts its wishes over all volumes.
  window.wishes = {.last = {}, .number = window.wishes.number, .unanswered = {}};
  window.pointer.centers = false;
  forgetReading(window.pointer);
  window.shown.picture = {};
  // The texture of the last picture stays on the screen until the first one of this volume comes,
  // so that the pane does not flash.
  endFade(window.shown);
  for (SliceOnScreen& slice : window.slices) slice.at = slice.time = -1;
  window.series.is_playing = false;
  window.film = {.path = {}, .name = window.film.name};
  for (const std::string& warning : opened.info.warnings) window.messages.lines.push_front(warning);
  keepRecent(window);
  keepSettings(window);
  window.log.write({{"opened", opened.volume.paths.front()},
                    {"dims", opened.info.dims},
                    {"time_steps", opened.info.time_steps},
                    {"device", opened.device}});
}

void takePlaced(WindowState& window, const PlacedNews& news) {
  if (!window.fit || news.number != window.fit->number) return;
  if (!news.view) {
    for (const std::string& line : dropFit(window, "its view could not be fitted"))
      window.fail(line);
    return;
  }
  // The fit ends before its acts run, or afterFit() would queue them again. One of them may ask for
  // a fit of its own, for which the rest then waits.
  Fit fit = std::move(*window.fit);
  window.fit.reset();
  window.edit([&](ViewState& next) { next.view = *news.view; });
  ++window.gesture;  // undo takes back the moves first
  for (WaitingAct& next : fit.waiting) window.afterFit(std::move(next.act), next.loss);
}

void takePicture(PictureOnScreen& shown, ShownPicture picture) {
  if (fadesIn(picture, shown.picture)) {
    shown.faded_in_from = WindowClock::now();
    // The swap keeps the old picture without a copy. The texture that it gets in return is
    // overwritten below.
    shown.before.swap(shown.texture);
  } else {
    endFade(shown);
  }
  shown.picture = std::move(picture);
  // The texture owns the picture from here on: a second holder would keep it from the renderer.
  if (shown.picture.screen)
    shown.texture.show(*std::exchange(shown.picture.screen, std::nullopt));
  else if (shown.keeps_pixels)
    shown.texture.drop();
  else
    shown.texture.set(shown.picture.width, shown.picture.height,
                      std::exchange(shown.picture.rgba, {}));
  shown.is_new = true;
}

void takeProbe(WindowState& window, const ProbeNews& news) {
  Pointer& pointer = window.pointer;
  // The pointer has moved on since.
  if (news.number != pointer.question) return;
  pointer.value = news.found;
  if (std::exchange(pointer.centers, false) && news.found && window.isOpen()) {
    window.afterFit([found = *news.found](WindowState& fitted) {
      ViewState next = fitted.state();
      const auto& [voxel, world, value] = found;
      next.view = centerOn(next.view, {world[0], world[1], world[2]});
      for (size_t a = 0; a < 3; ++a)
        next.cross[a] =
            std::clamp(int64_t{std::llround(voxel[a])}, int64_t{0}, fitted.info().dims[a] - 1);
      fitted.change(next);
      fitted.log.write({{"centered", voxel}});
    });
  }
  if (news.found) window.log.write({{"value", news.found->value}, {"voxel", news.found->voxel}});
}

void takeSaved(WindowState& window, const SavedNews& saved) {
  // The user has not asked for the settings to be saved.
  if (saved.path == window.request.settings_file) return;
  window.say(saved.command.empty() ? saved.path : saved.command);
  window.messages.saved = "saved " + saved.path;
  window.messages.saved_until = WindowClock::now() + kSavedShows;
  window.log.write({{"saved", saved.path}, {"command", saved.command}});
}

// A step that cannot be drawn leaves no picture of another step in the pane.
void takeFailedWish(WindowState& window) {
  const ShownPicture& picture = window.shown.picture;
  if (picture.wish == 0 || picture.state.time == window.state().time) return;
  window.shown.picture = {};
  window.shown.texture.drop();
  endFade(window.shown);
  window.pointer.value.reset();
}

// The levels in the picture, and whether a finer one follows.
std::string levelsText(const ShownPicture& picture) {
  const int finest = picture.levels.front(), coarsest = picture.levels.back();
  const std::string levels = finest == coarsest ? fmt::format("level {}", finest)
                                                : fmt::format("levels {} to {}", finest, coarsest);
  if (!picture.is_complete) return levels + ", will improve";
  return levels + (picture.is_refined ? ", final" : ", as fine as the memory allows");
}

std::string failedText(const WindowState& window) {
  const ShownPicture& picture = window.shown.picture;
  std::string text = window.info().time_steps > 1 ? fmt::format("step {}", window.state().time)
                                                  : std::string("this view");
  text += " could not be drawn";
  if (picture.wish == 0) return text;
  return text + (picture.wish == window.wishes.number ? " whole" : "; the picture is an older one");
}

// The work that a picture which is not complete waits for.
std::string doingText(const DeskStatus& status, const ShownPicture& picture) {
  if (status.doing == DeskStatus::Doing::kPicture)
    return fmt::format("drawing {:.0f} %", 100 * status.share);
  if (picture.missing_share > 0)
    return fmt::format("preview, {:.0f} % read", 100 * (1 - picture.missing_share));
  return "preview";
}

}  // namespace

void takeNews(WindowState& window) {
  News news = window.desk.take();
  // The status is read after the news, so that it is never older than they are.
  const int64_t seen_frames = window.status.frames_written;
  window.status = window.desk.status();
  if (news.opened) takeOpened(window, std::move(news.opened));
  if (news.state) window.change(*news.state);
  // The volume comes first, since it drops the fit of the one before, whose news may be among
  // these.
  if (news.placed) takePlaced(window, *news.placed);
  if (news.path) window.film.path = *news.path;
  for (const std::string& gone : news.vanished) {
    if (std::erase(window.settings.recent, gone) == 0) continue;
    window.log.write({{"vanished", gone}});
    keepSettings(window);
  }
  if (window.status.frames_written != seen_frames)
    window.log.write({{"written", window.status.frames_written}, {"of", window.status.frames}});
  if (news.picture) {
    const std::string& why_added = news.picture->why_added;
    if (!why_added.empty() && why_added != window.shown.picture.why_added) window.say(why_added);
    takePicture(window.shown, std::move(*news.picture));
  }
  for (ShownSlice& slice : news.slices) {
    SliceOnScreen& shown = window.slices[static_cast<size_t>(slice.axis)];
    shown.texture.set(slice.width, slice.height, slice.rgba);
    shown.at = slice.at;
    shown.time = slice.time;
    shown.values = std::move(slice.values);
    shown.is_new = true;
    window.log.write({{"slice", slice.axis}, {"at", slice.at}});
  }
  if (news.look) window.volume.look = std::move(*news.look);
  if (news.report) window.volume.report = std::move(*news.report);
  if (news.probe) takeProbe(window, *news.probe);
  for (const SavedNews& saved : news.saved) takeSaved(window, saved);
  if (hasFailed(window)) takeFailedWish(window);
  for (const std::string& failure : news.failures) window.fail(failure);
  for (const std::string& note : news.notes) window.say(note);
}

void updateFade(WindowState& window) {
  PictureOnScreen& shown = window.shown;
  if (!shown.faded_in_from) return;
  const auto now = WindowClock::now();
  const std::chrono::duration<double> since = now - *shown.faded_in_from, all = kFade;
  shown.share = std::min(1.0, since / all);
  if (shown.share < 1) window.loop.wakeBy(now + kFadeTurn);
}

void notePresented(WindowState& window) {
  // This runs after the swap alone, so that a frame that was put off still counts as new in the
  // next turn.
  for (SliceOnScreen& slice : window.slices) slice.is_new = false;
  if (window.shown.faded_in_from && window.shown.share == 1) {
    endFade(window.shown);
    window.log.write({{"faded_in", window.shown.picture.wish}});
  }
  if (!std::exchange(window.shown.is_new, false)) return;
  const ShownPicture& picture = window.shown.picture;
  const auto now = WindowClock::now();
  auto& unanswered = window.wishes.unanswered;
  std::vector<double>& answer_s = window.loop.times.answer_s;
  // A picture answers all wishes up to its own, those included that were never drawn.
  while (!unanswered.empty() && unanswered.front().first <= picture.wish) {
    if (answer_s.size() < kMostTimes)
      answer_s.push_back(std::chrono::duration<double>(now - unanswered.front().second).count());
    unanswered.pop_front();
  }
  window.log.write({{"picture", picture.wish},
                    {"complete", picture.is_complete},
                    {"levels", picture.levels},
                    {"will_improve", picture.will_improve},
                    {"why_empty", picture.why_empty},
                    {"size", {picture.width, picture.height}},
                    {"time", picture.state.time},
                    {"seconds", picture.seconds},
                    {"of_newest", picture.wish == window.wishes.number},
                    {"at", clockSeconds(now)}});
}

void sendWish(WindowState& window) {
  // A pane that is nearly closed has no picture.
  if (!window.isOpen() || window.pane.width < 8 || window.pane.height < 8) return;
  Wish wish;
  wish.state = window.state();
  wish.width = window.pane.width;
  wish.height = window.pane.height;
  wish.showing_s = window.loop.showing_s;
  const auto rests_at = window.loop.nudged_at + kHandRests;
  const bool is_down = window.pointer.is_down;
  // A wheel or a key gives no release, so that a hand counts as moving for a while after each.
  const bool moves = is_down || window.film.is_playing || WindowClock::now() < rests_at;
  if (window.series.is_playing) wish.next_time = (wish.state.time + 1) % window.info().time_steps;
  const std::optional<Wish>& sent = window.wishes.last;
  const bool is_same =
      sent && sent->state == wish.state && sent->width == wish.width && sent->height == wish.height;
  // After a drag, the whole picture of the last view is wanted.
  if (is_same && (!sent->moves || moves)) {
    if (sent->moves && !is_down) window.loop.wakeBy(rests_at + 1ms);
    return;
  }
  // A series that plays waits for whole pictures, so its wishes count as at rest.
  wish.moves = moves && !window.series.is_playing;
  if (wish.moves && !is_down) window.loop.wakeBy(rests_at + 1ms);
  const uint64_t number = window.desk.wish(wish);
  window.wishes.last = wish;
  window.wishes.number = number;
  const auto event_at = window.loop.event_at;
  if (!is_same) {
    // Only a changed view counts: the wish that ends a drag has been answered by its last preview.
    window.wishes.unanswered.emplace_back(number, event_at);
    forgetReading(window.pointer);
  }
  window.log.write({{"wish", number}, {"moves", wish.moves}, {"event_at", clockSeconds(event_at)}});
}

bool hasFailed(const WindowState& window) {
  return window.isOpen() && window.wishes.number > 0 &&
         window.status.failed == window.wishes.number;
}

CornerText cornerText(const WindowState& window) {
  const DeskStatus& status = window.status;
  const ShownPicture& picture = window.shown.picture;
  if (status.doing == DeskStatus::Doing::kOpening)
    return {fmt::format("{} {:.0f} %", status.is_indexing ? "indexing" : "opening",
                        100 * status.share)};
  if (!window.isOpen()) return {};
  if (window.fit && WindowClock::now() - window.fit->asked_at > kSlowFit)
    return {"fitting the view"};
  const std::string levels = picture.levels.empty() ? "" : levelsText(picture);
  if (picture.wish == window.wishes.number && picture.is_complete) {
    if (!picture.why_empty.empty()) return {"nothing is visible: " + picture.why_empty};
    return {levels, true};
  }
  if (hasFailed(window)) return {failedText(window)};
  const std::string doing = doingText(status, picture);
  return {levels.empty() ? doing : levels + "; " + doing};
}

}  // namespace sluice
