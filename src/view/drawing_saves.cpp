// What the drawing thread writes: pictures, small files, and films frame by frame.
#include <sluice/error.h>

#include <utility>

#include "src/base/atomic_file.h"
#include "src/base/error.h"
#include "src/base/numbered_name.h"
#include "src/view/drawing_thread.h"
#include "src/view/picture_file.h"
#include "src/view/render_command.h"
#include "src/view/state_file.h"

namespace sluice {
void DrawingThread::savePicture(const std::string& path, const Wish& wish) {
  const MutexLock lock(mutex_);
  saves_.emplace_back(PictureSave{path, wish});
  changed_.notifyAll();
}

void DrawingThread::saveText(const std::string& path, const std::string& text) {
  const MutexLock lock(mutex_);
  saves_.emplace_back(TextSave{path, text});
  changed_.notifyAll();
}

void DrawingThread::writeFrames(const FilmWish& film) {
  const MutexLock lock(mutex_);
  if (status_.doing == Doing::kFrame) work_.request_stop();
  film_ = Film{.number = ++films_, .wish = std::make_shared<const FilmWish>(film)};
  status_.frames = frameCount(film.path);
  status_.frames_written = 0;
  changed_.notifyAll();
}

void DrawingThread::cancelFrames() {
  const MutexLock lock(mutex_);
  if (status_.doing == Doing::kFrame) work_.request_stop();
  endFilm();
}

void DrawingThread::endFilm() {
  film_.reset();
  status_.frames = status_.frames_written = 0;
}

void DrawingThread::checkOutputs(const std::vector<std::string>& writes,
                                 const LookOptions& look) const {
  if (!options_.check_outputs) return;
  std::vector<std::string> reads = opened_.viewed.paths;
  if (opened_.volume) {
    const VolumeInfo& info = opened_.volume->info();
    reads.insert(reads.end(), info.files.begin(), info.files.end());
  }
  if (!look.transfer_file.empty()) reads.push_back(look.transfer_file);
  options_.check_outputs(reads, writes);
}

void DrawingThread::save(const Job& job) {
  if (const auto* text = std::get_if<TextSave>(&job.save))
    save(*text);
  else
    save(std::get<PictureSave>(job.save), job);
  tell();
}

void DrawingThread::save(const TextSave& save) {
  checkOutputs({save.path}, opened_.look);
  AtomicFile file(save.path);
  file.write(save.text);
  file.commit();
  const MutexLock lock(mutex_);
  news_.saved.push_back({save.path, {}});
}

void DrawingThread::save(const PictureSave& save, const Job& job) {
  const Wish& wish = save.wish;
  // The name that `sluice render` makes of it too.
  const std::string path = numberedName(save.path, wish.state.time, false).string();
  requirePictureName(path);
  checkOutputs({path}, wish.state.look);
  useLook(wish.state.look);
  drawToFile(*opened_.renderer, path, wish.state, wish.width, wish.height, progressOf(job),
             job.stop);
  const std::string look = opened_.renderer->lookText();
  const MutexLock lock(mutex_);
  news_.saved.push_back(
      {path, renderCommand(opened_.viewed, wish.state, look, wish.width, wish.height, path)});
}

void DrawingThread::beginFilm(const FilmWish& film) {
  if (frameCount(film.path) == 0) sluice::fail("a film without key frames; add a view first");
  if (!isNumbered(film.name))
    sluice::fail("{}: frames need a place for their numbers, as in frame_%04d.png", film.name);
  std::vector<std::string> writes{pathFileFor(film.name)};
  for (int64_t i = 0; i < frameCount(film.path); ++i)
    writes.push_back(numberedName(film.name, i, true).string());
  requirePictureName(writes.back());
  for (const ViewKey& key : film.path.keys) checkOutputs(writes, key.state.look);
  checkOutputs(writes, film.now.look);
  AtomicFile file(writes.front());
  file.write(stateText(opened_.viewed, film.now, film.path));
  file.commit();
}

void DrawingThread::writeFrame(const Job& job) {
  const FilmWish& film = *job.film.wish;
  try {
    if (job.film.next == 0 && job.film.stopped == 0) beginFilm(film);
    const ViewState state = stateAt(film.path, film.now, job.film.next);
    useLook(state.look, false);
    drawToFile(*opened_.renderer, numberedName(film.name, job.film.next, true).string(), state,
               film.width, film.height, progressOf(job), job.stop);
  } catch (const Cancelled&) {
    const MutexLock lock(mutex_);
    if (film_ && film_->number == job.film.number) ++film_->stopped;
    throw;
  } catch (const std::exception&) {
    const MutexLock lock(mutex_);
    if (film_ && film_->number == job.film.number) endFilm();
    throw;
  }
  {
    const MutexLock lock(mutex_);
    if (!film_ || film_->number != job.film.number) return;  // cancelled meanwhile
    film_->stopped = 0;
    status_.frames_written = ++film_->next;
    if (film_->next == status_.frames) {
      news_.saved.push_back(
          {film.name, framesCommand(pathFileFor(film.name), film.width, film.height, film.name)});
      endFilm();
    }
  }
  tell();
}

}  // namespace sluice
