#include "src/view/drawing/job_queue.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

namespace sluice {
namespace {

using Doing = DeskStatus::Doing;

// For each kind of Job::task.
constexpr std::array kDoing{Doing::kOpening, Doing::kPreview, Doing::kPicture, Doing::kSlices,
                            Doing::kPlacing, Doing::kProbe,   Doing::kNothing, Doing::kSaving,
                            Doing::kSaving,  Doing::kFrame};
static_assert(kDoing.size() == std::variant_size_v<decltype(Job::task)>);

// A preview that takes longer than this is not worth waiting for when there is a newer wish.
constexpr double kStalePreview_s = 0.25;
constexpr size_t kMostUnanswered = 8192, kMostTimes = 8192;
constexpr int kMostStopped = 3;

double secondsBetween(std::chrono::steady_clock::time_point from,
                      std::chrono::steady_clock::time_point to) {
  return std::chrono::duration<double>(to - from).count();
}

void keep(std::vector<double>& times, double seconds) {
  // The older half goes at once, so that a long session does not shift the list at every picture.
  if (times.size() >= kMostTimes) times.erase(times.begin(), times.begin() + kMostTimes / 2);
  times.push_back(seconds);
}

template <class T>
T takeFirst(std::deque<T>& queue) {
  T first = std::move(queue.front());
  queue.pop_front();
  return first;
}

}  // namespace

std::string endedFilm(const FrameJob& film, const std::string& why) {
  return fmt::format("{}: {} of {} frames are written; {}", film.wish->name, film.frame,
                     frameCount(film.wish->path), why);
}

void JobQueue::open(OpenJob job) {
  const MutexLock lock(mutex_);
  requests_.open = std::move(job);
  stopWork(true);
  changed_.notifyAll();
}

uint64_t JobQueue::wish(const Wish& wish) {
  const auto now = Clock::now();
  const MutexLock lock(mutex_);
  const uint64_t number = ++status_.wished;
  requests_.wish = std::make_shared<const NumberedWish>(NumberedWish{number, now, wish});
  // Each wish is timed, also those that no picture is drawn for: a later picture answers them.
  served_.unanswered.emplace_back(number, now);
  if (served_.unanswered.size() > kMostUnanswered) served_.unanswered.pop_front();
  ++times_.wishes;
  // A preview that is nearly there is shown; one that takes long is stopped for the newer wish.
  stopWork(secondsBetween(work_.began, now) > kStalePreview_s);
  changed_.notifyAll();
  return number;
}

// A save stops nothing: a picture under way is soon whole, and the save waits its turn (choose()).
void JobQueue::save(SavePictureJob job) {
  const MutexLock lock(mutex_);
  job.volume = requests_.seen;
  requests_.pictures.push_back(std::move(job));
  changed_.notifyAll();
}

void JobQueue::save(SaveTextJob job) {
  const MutexLock lock(mutex_);
  requests_.texts.push_back(std::move(job));
  changed_.notifyAll();
}

void JobQueue::writeFrames(const FilmWish& film) {
  const MutexLock lock(mutex_);
  if (status_.doing == Doing::kFrame) work_.stop.request_stop();
  requests_.frame = FrameJob{.film = ++requests_.films,
                             .wish = std::make_shared<const FilmWish>(film),
                             .volume = requests_.seen};
  // The number is told at once, so that the window shows a film that has not begun.
  status_.frames = frameCount(film.path);
  status_.frames_written = 0;
  changed_.notifyAll();
}

void JobQueue::cancelFrames() {
  const MutexLock lock(mutex_);
  if (status_.doing == Doing::kFrame) work_.stop.request_stop();
  endFilm();
}

uint64_t JobQueue::place(const Wish& wish) {
  const MutexLock lock(mutex_);
  requests_.place = PlaceJob{++requests_.places, wish};
  stopWork(false);
  changed_.notifyAll();
  return requests_.places;
}

uint64_t JobQueue::probe(double right, double down) {
  const MutexLock lock(mutex_);
  requests_.probe = ProbeJob{++requests_.probes, right, down};
  if (status_.doing == Doing::kProbe) work_.stop.request_stop();
  changed_.notifyAll();
  return requests_.probes;
}

void JobQueue::wantReport(bool maps) {
  const MutexLock lock(mutex_);
  // A request for maps that still waits is not forgotten for one without.
  requests_.report = ReportJob{maps || (requests_.report && requests_.report->maps)};
  changed_.notifyAll();
}

DeskStatus JobQueue::status() const {
  const MutexLock lock(mutex_);
  return status_;
}

DeskTimes JobQueue::times() const {
  const MutexLock lock(mutex_);
  return times_;
}

void JobQueue::noteSeen() {
  const MutexLock lock(mutex_);
  requests_.seen = requests_.opened;
}

bool JobQueue::isOpen(uint64_t volume) const {
  const MutexLock lock(mutex_);
  return volume == requests_.opened;
}

std::optional<SavePictureJob> JobQueue::takePicture() {
  const MutexLock lock(mutex_);
  if (requests_.pictures.empty()) return std::nullopt;
  return takeFirst(requests_.pictures);
}

std::vector<std::string> JobQueue::unwritten() const {
  const MutexLock lock(mutex_);
  std::vector<std::string> lines;
  for (const SavePictureJob& picture : requests_.pictures)
    lines.push_back(picture.path + " is not saved: the window ended first");
  if (requests_.frame) lines.push_back(endedFilm(*requests_.frame, "the window ended"));
  return lines;
}

void JobQueue::end() {
  const MutexLock lock(mutex_);
  // The flag stays with the queue, so that a job which does not look at its stop token is the last
  // one, too.
  work_.ends = true;
  work_.stop.request_stop();
  changed_.notifyAll();
}

void JobQueue::stopWork(bool also_previews) {
  switch (status_.doing) {
    case Doing::kPreview:
      if (also_previews) work_.stop.request_stop();
      break;
    case Doing::kPicture:
    case Doing::kSlices:
    case Doing::kPlacing:
    case Doing::kProbe:
      work_.stop.request_stop();
      break;
    case Doing::kOpening:
      // Only another volume ends the opening of one, not a wish for a picture.
      if (requests_.open) work_.stop.request_stop();
      break;
    case Doing::kFrame:
      // A hand that never rests shall not keep a film from being written.
      if (!requests_.frame || requests_.frame->stopped < kMostStopped) work_.stop.request_stop();
      break;
    case Doing::kNothing:
    case Doing::kSaving:
      break;
  }
}

bool JobQueue::rests() const {
  return requests_.wish == nullptr || !requests_.wish->wish.moves || Clock::now() >= restsAt();
}

JobQueue::Clock::time_point JobQueue::restsAt() const {
  return requests_.wish->asked_at +
         std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(rest_s_));
}

// Chooses the next job: requests come first, then what is seen first. The whole picture waits while
// a hand moves, and so do placing a view, which may read all of a volume, and questions. Small
// files are written at once, even if no volume is open.
std::optional<Job> JobQueue::choose() {
  Requests& asked = requests_;
  const auto job = [wish = asked.wish](auto task) { return Job{std::move(task), wish, {}}; };
  // Pictures are of the volume that they were asked for, which is let go when the next one is open.
  if (asked.open && work_.is_open && !asked.pictures.empty()) return job(takeFirst(asked.pictures));
  if (asked.open) return job(*std::exchange(asked.open, std::nullopt));
  if (!asked.texts.empty()) return job(takeFirst(asked.texts));
  // All other jobs need a volume.
  if (!work_.is_open) return std::nullopt;
  const uint64_t newest = asked.wish != nullptr ? asked.wish->number : 0;
  if (served_.previewed < newest) return job(PreviewJob());
  if (asked.place && rests()) return job(*asked.place);
  if (!asked.pictures.empty()) return job(takeFirst(asked.pictures));
  if (status_.completed < newest && rests()) return job(PictureJob());
  if (served_.sliced < newest && asked.wish->wish.state.shows_slices) return job(SlicesJob());
  if (asked.probe && newest > 0 && rests()) return job(*asked.probe);
  if (asked.report) return job(*std::exchange(asked.report, std::nullopt));
  if (asked.frame && rests()) return job(*asked.frame);
  return std::nullopt;
}

Job JobQueue::start(Job job) {
  // A stop source cannot be taken back, so that each job has its own.
  work_.stop = std::stop_source();
  work_.began = Clock::now();
  job.stop = work_.stop.get_token();
  status_.doing = kDoing[job.task.index()];
  status_.share = 0;
  return job;
}

std::optional<Job> JobQueue::next() {
  MutexLock lock(mutex_);
  // The thread asks for the next job when the last one is done, whatever became of it.
  status_.doing = Doing::kNothing;
  while (!work_.ends) {
    if (std::optional<Job> job = choose()) return start(std::move(*job));
    // Views to be placed, the whole picture, questions and a film's next frame wait for a hand to
    // rest, which no event will tell.
    if (work_.is_open && !rests())
      changed_.waitUntil(lock, restsAt());
    else
      changed_.wait(lock);
  }
  // A window's settings are its last wish.
  if (requests_.texts.empty()) return std::nullopt;
  return start({takeFirst(requests_.texts), {}, {}});
}

void JobQueue::noteProgress(double share, bool is_indexing) {
  const MutexLock lock(mutex_);
  status_.share = share;
  status_.is_indexing = is_indexing;
}

std::optional<FrameJob> JobQueue::noteOpened() {
  const MutexLock lock(mutex_);
  work_.is_open = true;
  ++requests_.opened;
  // Wishes for the volume before do not count for this one.
  served_ = {.previewed = status_.wished, .sliced = status_.wished, .unanswered = {}};
  status_.completed = status_.wished;
  status_.failed = 0;
  status_.is_indexing = false;
  requests_.wish.reset();
  requests_.probe.reset();
  requests_.place.reset();
  std::optional<FrameJob> film = std::move(requests_.frame);
  endFilm();
  return film;
}

void JobQueue::notePicture(const NumberedWish& wish, bool is_complete) {
  const auto now = Clock::now();
  const MutexLock lock(mutex_);
  // A whole picture that a newer preview has overtaken does not make it wanted again.
  served_.previewed = std::max(served_.previewed, wish.number);
  ++(is_complete ? times_.complete : times_.previews);
  auto& unanswered = served_.unanswered;
  // A picture answers all wishes up to its own: those between were never drawn.
  while (!unanswered.empty() && unanswered.front().first <= wish.number) {
    keep(times_.answer_s, secondsBetween(unanswered.front().second, now));
    unanswered.pop_front();
  }
  if (!is_complete) return;
  status_.completed = wish.number;
  keep(times_.complete_s, secondsBetween(wish.asked_at, now));
}

void JobQueue::noteSlices(uint64_t wish) {
  const MutexLock lock(mutex_);
  // A newer wish may have been noted while these slices were read.
  served_.sliced = std::max(served_.sliced, wish);
}

void JobQueue::notePlaced(const PlaceJob& job) {
  const MutexLock lock(mutex_);
  // A newer request stays: its number differs from that of the job which is done.
  if (requests_.place && requests_.place->number == job.number) requests_.place.reset();
}

void JobQueue::noteProbed(const ProbeJob& job) {
  const MutexLock lock(mutex_);
  if (requests_.probe && requests_.probe->number == job.number) requests_.probe.reset();
}

bool JobQueue::isFilm(uint64_t number) const {
  return requests_.frame && requests_.frame->film == number;
}

void JobQueue::endFilm() {
  requests_.frame.reset();
  status_.frames = status_.frames_written = 0;
}

bool JobQueue::noteFrame(const FrameJob& job) {
  const MutexLock lock(mutex_);
  if (!isFilm(job.film)) return false;
  requests_.frame->stopped = 0;
  status_.frames_written = ++requests_.frame->frame;
  // The counts go back to 0, by which the window sees that no film is being written.
  if (status_.frames_written == status_.frames) endFilm();
  return true;
}

void JobQueue::noteFailed(const Job& job) {
  const MutexLock lock(mutex_);
  if (const auto* frame = std::get_if<FrameJob>(&job.task)) {
    if (isFilm(frame->film)) endFilm();
    return;
  }
  const Doing doing = kDoing[job.task.index()];
  if (doing == Doing::kPreview || doing == Doing::kPicture || doing == Doing::kSlices)
    // A view that cannot be drawn is not tried again before the next wish, or it would fail for
    // ever.
    served_.previewed = served_.sliced = status_.completed = status_.failed = job.wish->number;
}

void JobQueue::noteCancelled(const Job& job) {
  const MutexLock lock(mutex_);
  ++times_.cancelled;
  const auto* frame = std::get_if<FrameJob>(&job.task);
  if (frame != nullptr && isFilm(frame->film)) ++requests_.frame->stopped;
  if (const auto* picture = std::get_if<SavePictureJob>(&job.task))
    requests_.pictures.push_front(*picture);
}

}  // namespace sluice
