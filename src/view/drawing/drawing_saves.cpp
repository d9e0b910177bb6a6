// The jobs that write pictures, small files, and films frame by frame.
#include <utility>

#include "src/base/error.h"
#include "src/base/files/atomic_file.h"
#include "src/base/files/file_kind.h"
#include "src/base/files/numbered_name.h"
#include "src/view/drawing/drawing_jobs.h"
#include "src/view/drawing/picture_file.h"
#include "src/view/state/printed_command.h"

namespace sluice {
namespace {

void requireReplaceable(const std::string& path, FileKind kind) {
  if (!mayReplace(path, kind))
    failRequest("{}: exists and is not {}; give another name", path, nameOf(kind));
}

}  // namespace

void DrawingJobs::checkOutputs(const std::vector<std::string>& writes,
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

void DrawingJobs::run(const SaveTextJob& task, const Job&) {
  // Settings have no kind: the window owns their file and may always replace it.
  if (task.kind) {
    checkOutputs({task.path}, opened_.look);
    requireReplaceable(task.path, *task.kind);
  }
  // The file appears whole or not at all, even if the program is ended meanwhile.
  AtomicFile file(task.path);
  file.write(task.text);
  file.commit();
  news_.add([&](News& news) { news.saved.push_back({task.path, {}}); });
}

void DrawingJobs::savePictures(const Job& job) {
  while (std::optional<SavePictureJob> picture = queue_.takePicture()) {
    run(Job{std::move(*picture), job.wish, job.stop});
    // A picture that was stopped waits again, for whoever stopped it.
    if (job.stop.stop_requested()) throw Cancelled();
  }
}

void DrawingJobs::run(const SavePictureJob& task, const Job& job) {
  if (!queue_.isOpen(task.volume))
    failRequest("{} is not saved: another volume was opened first", task.path);
  const Wish& wish = task.wish;
  // The name that `sluice render` makes of it too.
  const std::string path = numberedName(task.path, wish.state.time, false).string();
  requirePictureName(path);
  checkOutputs({path}, wish.state.look);
  // The look is shown, too: it is that of the view which the user saves.
  useLook(wish.state);
  drawToFile(*opened_.renderer, path, wish.state, wish.width, wish.height, progress(), job.stop);
  ViewedVolume viewed = opened_.viewed;
  // The command has to open the volume as it was opened here, or its picture may show other levels.
  viewed.options.opens_soon = opened_.volume->info().was_opened_soon;
  SavedNews saved{path, renderCommand(viewed, wish.state, opened_.renderer->lookText(), wish.width,
                                      wish.height, path)};
  news_.add([&](News& news) { news.saved.push_back(std::move(saved)); });
}

void DrawingJobs::beginFilm(const FilmWish& film) {
  if (frameCount(film.path) == 0) failRequest("a film without key frames; add a view first");
  if (!isNumbered(film.name))
    failRequest("{}: frames need a place for their numbers, as in frame_%04d.png", film.name);
  // All names are checked before the first frame, so that a film does not stop halfway.
  std::vector<std::string> writes{pathFileFor(film.name)};
  for (int64_t i = 0; i < frameCount(film.path); ++i)
    writes.push_back(numberedName(film.name, i, true).string());
  requirePictureName(writes.back());
  // Each key may read a transfer function's file of its own.
  for (const ViewKey& key : film.path.keys) checkOutputs(writes, key.state.look);
  checkOutputs(writes, film.now.look);
  requireReplaceable(writes.front(), FileKind::kView);
  AtomicFile file(writes.front());
  file.write(stateText(opened_.viewed, film.now, film.path));
  file.commit();
  if (const auto jumps = jumpsAlong(film.path))
    news_.add([&](News& news) { news.notes.push_back(writes.front() + ": " + *jumps); });
}

void DrawingJobs::run(const FrameJob& task, const Job& job) {
  const FilmWish& film = *task.wish;
  if (!queue_.isOpen(task.volume))
    failRequest("{} is not written: another volume was opened first", film.name);
  // A first frame that was stopped is drawn again, and its film has begun already.
  if (task.frame == 0 && task.stopped == 0) beginFilm(film);
  const ViewState state = stateAt(film.path, film.now, task.frame);
  useLook(state, false);
  drawToFile(*opened_.renderer, numberedName(film.name, task.frame, true).string(), state,
             film.width, film.height, progress(), job.stop);
  // Cancelled, or replaced by another film, while the frame was drawn.
  if (!queue_.noteFrame(task)) return;
  news_.add([&](News& news) {
    if (task.frame + 1 == frameCount(film.path))
      news.saved.push_back(
          {film.name, framesCommand(pathFileFor(film.name), film.width, film.height, film.name)});
  });
}

}  // namespace sluice
