// JobQueue: the open requests to a desk, and the choice of the drawing thread's next job. It also
// keeps the status and the times that a desk tells.
//
// Any thread may ask; nothing here waits but next(), which the drawing thread alone calls. The lock
// is never held while something is read, drawn or written.
#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "src/base/threads/mutex.h"
#include "src/view/drawing/desk.h"

namespace sluice {

struct NumberedWish {
  uint64_t number = 0;
  std::chrono::steady_clock::time_point asked_at;
  Wish wish;
};

// The tasks that the drawing thread does without interruption by another.
struct OpenJob {
  ViewedVolume volume;
  std::optional<ViewState> state;
  std::optional<ViewPath> path;
  std::string state_file;  // the file that names the volume, state and path; empty: no file
};
struct PreviewJob {};
struct PictureJob {};
struct SlicesJob {};
struct PlaceJob {
  uint64_t number = 0;
  Wish wish;
};
struct ProbeJob {
  uint64_t number = 0;
  double right = 0, down = 0;
};
struct ReportJob {
  bool maps = false;
};
struct SavePictureJob {
  std::string path;
  Wish wish;
  uint64_t volume = 0;  // see JobQueue::isOpen()
};
struct SaveTextJob {
  std::string path, text;
  std::optional<FileKind> kind;  // see Desk::saveText()
};
struct FrameJob {
  uint64_t film = 0;  // number of the film
  std::shared_ptr<const FilmWish> wish;
  int64_t frame = 0;
  int stopped = 0;      // times in a row that it was given up for something more urgent
  uint64_t volume = 0;  // see JobQueue::isOpen()
};

// A line for people about a film that ends before its last frame. `film`: its next frame.
std::string endedFilm(const FrameJob& film, const std::string& why);

struct Job {
  // The tasks in the order of kDoing in the source.
  std::variant<OpenJob, PreviewJob, PictureJob, SlicesJob, PlaceJob, ProbeJob, ReportJob,
               SavePictureJob, SaveTextJob, FrameJob>
      task;
  std::shared_ptr<const NumberedWish> wish;  // the newest; null: there is none yet
  std::stop_token stop;
};

class JobQueue {
 public:
  // `rest_s`: a hand that is still for so long gets the whole picture.
  explicit JobQueue(double rest_s) : rest_s_(rest_s) {}

  // See Desk.
  void open(OpenJob job);
  uint64_t wish(const Wish& wish);
  void save(SavePictureJob job);
  void save(SaveTextJob job);
  void writeFrames(const FilmWish& film);
  void cancelFrames();
  uint64_t place(const Wish& wish);
  uint64_t probe(double right, double down);
  void wantReport(bool maps);
  DeskStatus status() const;
  DeskTimes times() const;
  // The caller has seen the news of the volume that is open: from now on, it asks for this one.
  void noteSeen();
  // Stops the job under way; next() gives the small files that are not written yet and then ends.
  void end();
  // The pictures and the film that were asked for and are not written, a line each. Requires: end()
  // was called.
  std::vector<std::string> unwritten() const;

  // Waits for something to do; nullopt: the end. The job that it returned before counts as done.
  std::optional<Job> next();
  // Progress of the job under way.
  void noteProgress(double share, bool is_indexing);
  // Another volume is open: wishes and questions about the one before are dropped. Returns its film
  // if one was being written, which ends, too.
  std::optional<FrameJob> noteOpened();
  // Whether this is the number of the open volume. Pictures and films have the number of the volume
  // that their caller had seen, which may be the one before.
  bool isOpen(uint64_t volume) const;
  // The first picture that waits to be written; nullopt: none does.
  std::optional<SavePictureJob> takePicture();
  void notePicture(const NumberedWish& wish, bool is_complete);
  void noteSlices(uint64_t wish);
  // The view is placed, or cannot be.
  void notePlaced(const PlaceJob& job);
  // The question is answered, or cannot be.
  void noteProbed(const ProbeJob& job);
  // False: the film was cancelled or replaced meanwhile. After its last frame there is none.
  bool noteFrame(const FrameJob& job);
  // A wish that cannot be drawn is as good as served, so that it is not tried for ever; a film
  // ends.
  void noteFailed(const Job& job);
  // A picture that was to be written waits again.
  void noteCancelled(const Job& job);

 private:
  using Clock = std::chrono::steady_clock;

  // Requests that are still open. Of wishes, films and questions only the newest is kept.
  struct Requests {
    std::optional<OpenJob> open;
    std::deque<SavePictureJob> pictures;
    std::deque<SaveTextJob> texts;
    std::optional<FrameJob> frame;  // the film's next
    std::optional<PlaceJob> place;  // also while it is under way, which a wish may stop
    std::optional<ProbeJob> probe;  // this one, too
    std::optional<ReportJob> report;
    std::shared_ptr<const NumberedWish> wish;
    uint64_t films = 0, probes = 0, places = 0;  // numbers that were given
    uint64_t opened = 0, seen = 0;               // volumes, by this side and by the caller
  };
  // Numbers of the wishes that were served last.
  struct Served {
    uint64_t previewed = 0, sliced = 0;
    std::deque<std::pair<uint64_t, Clock::time_point>> unanswered;
  };
  // The job under way.
  struct Work {
    std::stop_source stop;
    Clock::time_point began;
    bool is_open = false, ends = false;
  };

  std::optional<Job> choose() SLUICE_REQUIRES(mutex_);
  Job start(Job job) SLUICE_REQUIRES(mutex_);
  // No hand moves the view, or it has been still for rest_s_.
  bool rests() const SLUICE_REQUIRES(mutex_);
  Clock::time_point restsAt() const SLUICE_REQUIRES(mutex_);
  void stopWork(bool also_previews) SLUICE_REQUIRES(mutex_);
  void endFilm() SLUICE_REQUIRES(mutex_);
  bool isFilm(uint64_t number) const SLUICE_REQUIRES(mutex_);

  const double rest_s_;
  mutable Mutex mutex_;
  Condition changed_;
  Requests requests_ SLUICE_GUARDED_BY(mutex_);
  Served served_ SLUICE_GUARDED_BY(mutex_);
  Work work_ SLUICE_GUARDED_BY(mutex_);
  DeskStatus status_ SLUICE_GUARDED_BY(mutex_);
  DeskTimes times_ SLUICE_GUARDED_BY(mutex_);
};

}  // namespace sluice
