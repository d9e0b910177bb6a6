// Animation in the window: a film along its path (view_path.h), and the steps of a series.
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "src/view/window/window_state.h"

namespace sluice {
namespace {

WindowClock::duration durationOf(double seconds) {
  return std::chrono::duration_cast<WindowClock::duration>(std::chrono::duration<double>(seconds));
}

void addKeyNow(WindowState& window) {
  ViewPath& path = window.film.path;
  path.kind = ViewPath::Kind::kKeys;
  // A new key frame takes the pace of the one before it.
  path.keys.push_back(
      {window.state(), path.keys.empty() ? ViewKey{}.seconds : path.keys.back().seconds});
  window.log.write({{"keys", path.keys.size()}});
}

}  // namespace

void addKey(WindowState& window) {
  if (!window.isOpen()) return;
  window.afterFit([](WindowState& fitted) { addKeyNow(fitted); }, "the key frame is not added");
}

void showFrame(WindowState& window, int64_t frame) {
  FilmEditor& film = window.film;
  if (!window.isOpen() || frameCount(film.path) == 0) return;
  // The view to which the end of the film leads back.
  if (!film.view) film.view = window.state();
  film.frame = std::clamp<int64_t>(frame, 0, frameCount(film.path) - 1);
  // A film leaves no steps to undo.
  window.history.replace(stateAt(film.path, *film.view, film.frame));
}

void endFilm(WindowState& window) {
  FilmEditor& film = window.film;
  film.is_playing = false;
  if (film.view) window.history.replace(*std::exchange(film.view, std::nullopt));
}

void playFilm(WindowState& window) {
  if (window.film.is_playing) return endFilm(window);
  if (!window.isOpen() || frameCount(window.film.path) == 0) return;
  window.afterFit([](WindowState& fitted) {
    // The film sets the time step of each frame, and both at once would overwrite each other.
    fitted.series.is_playing = false;
    fitted.film.is_playing = true;
    fitted.film.began = WindowClock::now();
    showFrame(fitted, 0);
  });
}

void showPlayedFrame(WindowState& window) {
  const FilmEditor& film = window.film;
  if (!film.is_playing) return;
  const auto now = WindowClock::now();
  const double seconds = std::chrono::duration<double>(now - film.began).count();
  // The clock decides, so that frames which take too long are left out and the film keeps its
  // speed.
  const auto frame = static_cast<int64_t>(std::floor(seconds * film.path.frames_per_second));
  if (frame >= frameCount(film.path)) {
    window.log.write({{"film", "ended"}});
    return endFilm(window);
  }
  // Answers are timed from an event, and the clock is what moves the view here.
  if (frame != film.frame) window.loop.event_at = now;
  showFrame(window, frame);
  window.loop.wakeBy(film.began +
                     durationOf(static_cast<double>(frame + 1) / film.path.frames_per_second));
}

void writeFilm(WindowState& window) {
  if (window.status.frames > 0) {
    window.desk.cancelFrames();
    window.say("cancelled");
    return;
  }
  if (!window.isOpen() || frameCount(window.film.path) == 0) return;
  window.afterFit(
      [](WindowState& fitted) {
        const FilmEditor& film = fitted.film;
        fitted.desk.writeFrames({.name = film.name,
                                 .path = film.path,
                                 .now = film.view.value_or(fitted.state()),
                                 .width = fitted.pane.width,
                                 .height = fitted.pane.height});
      },
      window.film.name + " is not written");
}

void playSeries(WindowState& window) {
  SeriesPlayer& series = window.series;
  if (!series.is_playing || !window.isOpen() || window.info().time_steps < 2) return;
  const ShownPicture& picture = window.shown.picture;
  const bool was_seen = picture.is_complete && picture.wish == window.wishes.number &&
                        picture.state.time == window.state().time;
  // Its news will wake us. A step that cannot be drawn is passed over.
  if (!was_seen && !hasFailed(window)) return;
  const auto now = WindowClock::now();
  const double waited = std::chrono::duration<double>(now - series.step_at).count();
  // The rate is the most that the user wants. A step that took longer is followed at once.
  if (waited < 1 / series.steps_per_second)
    return window.loop.wakeBy(series.step_at + durationOf(1 / series.steps_per_second));
  // A moving mean; a pause of seconds begins a new one.
  series.achieved_steps = waited > 5 ? 0 : 0.7 * series.achieved_steps + 0.3 / waited;
  series.step_at = window.loop.event_at = now;
  ViewState next = window.state();
  next.time = (next.time + 1) % window.info().time_steps;
  // A series that plays leaves no steps to undo.
  window.history.replace(next);
}

}  // namespace sluice
