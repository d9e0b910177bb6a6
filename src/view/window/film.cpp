// What a sitting does with its film (view_path.h): key frames, the preview, and having it written.
#include <algorithm>
#include <cmath>
#include <utility>

#include "src/view/window/sitting.h"

namespace sluice {

void Sitting::addKey() {
  if (!isOpen()) return;
  film.kind = ViewPath::Kind::kKeys;
  film.keys.push_back({state(), film.keys.empty() ? ViewKey{}.seconds : film.keys.back().seconds});
  log.write({{"keys", film.keys.size()}});
}

void Sitting::showFrame(int64_t frame) {
  if (!isOpen() || !hasFilm()) return;
  if (!film_from) film_from = state();
  film_frame = std::clamp<int64_t>(frame, 0, frameCount(film) - 1);
  history.replace(stateAt(film, *film_from, film_frame));
}

void Sitting::endFilm() {
  is_film_playing = false;
  if (film_from) history.replace(*std::exchange(film_from, std::nullopt));
}

void Sitting::playFilm() {
  if (is_film_playing) return endFilm();
  if (!isOpen() || !hasFilm()) return;
  is_playing = false;
  is_film_playing = true;
  film_began = WindowClock::now();
  showFrame(0);
}

void Sitting::showPlayedFrame() {
  if (!is_film_playing) return;
  const auto now = WindowClock::now();
  const double seconds = std::chrono::duration<double>(now - film_began).count();
  const auto frame = static_cast<int64_t>(std::floor(seconds * film.frames_per_second));
  if (frame >= frameCount(film)) {
    log.write({{"film", "ended"}});
    return endFilm();
  }
  if (frame != film_frame) event_at = now;
  showFrame(frame);
  wakeBy(film_began +
         std::chrono::duration_cast<WindowClock::duration>(std::chrono::duration<double>(
             static_cast<double>(frame + 1) / film.frames_per_second)));
}

void Sitting::writeFilm() {
  if (status.frames > 0) {
    desk.cancelFrames();
    say("cancelled");
    return;
  }
  if (!isOpen() || !hasFilm()) return;
  FilmWish wish;
  wish.name = film_text;
  wish.path = film;
  wish.now = film_from.value_or(state());
  wish.width = pane.width;
  wish.height = pane.height;
  desk.writeFrames(wish);
}

}  // namespace sluice
