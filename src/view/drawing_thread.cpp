#include "src/view/drawing_thread.h"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <utility>

namespace sluice {
namespace {

// A preview that takes longer than this is not worth waiting for when there is a newer wish.
constexpr double kStalePreview_s = 0.25;
constexpr size_t kMostUnanswered = 8192;
constexpr int kMostStopped = 3;

// What shows the pictures goes first where processors are few: this thread, and with it those that
// the renderer starts, take what is left.
void yieldToOthers() {
  constexpr int kNicer = 5;
  const auto self = static_cast<id_t>(gettid());
  setpriority(PRIO_PROCESS, self, getpriority(PRIO_PROCESS, self) + kNicer);
}

}  // namespace

DrawingThread::DrawingThread(const DrawingOptions& options)
    : options_(options), on_news_(options.on_news) {
  worker_.submit([this] { run(); });
}

DrawingThread::~DrawingThread() {
  const MutexLock lock(mutex_);
  ends_ = true;
  work_.request_stop();
  changed_.notifyAll();
}

void DrawingThread::tellNews(std::function<void()> on_news) {
  const MutexLock lock(telling_);
  on_news_ = std::move(on_news);
}

void DrawingThread::lend(std::shared_ptr<const ScreenContext> screen) {
  const MutexLock lock(mutex_);
  screen_ = std::move(screen);
}

void DrawingThread::open(const ViewedVolume& volume, const std::optional<ViewState>& state) {
  OpenRequest request;
  request.volume = volume;
  request.state = state;
  ask(std::move(request));
}

void DrawingThread::loadState(const std::string& path) {
  OpenRequest request;
  request.state_file = path;
  ask(std::move(request));
}

void DrawingThread::ask(OpenRequest request) {
  const MutexLock lock(mutex_);
  open_ = std::move(request);
  stopWork(true);
  changed_.notifyAll();
}

uint64_t DrawingThread::wish(const Wish& wish) {
  const auto now = Clock::now();
  const MutexLock lock(mutex_);
  const uint64_t number = ++status_.wished;
  wish_ = std::make_shared<const NumberedWish>(NumberedWish{number, now, wish});
  unanswered_.emplace_back(number, now);
  if (unanswered_.size() > kMostUnanswered) unanswered_.pop_front();
  ++times_.wishes;
  stopWork(std::chrono::duration<double>(now - work_began_).count() > kStalePreview_s);
  changed_.notifyAll();
  return number;
}

void DrawingThread::stopWork(bool also_previews) {
  switch (status_.doing) {
    case Doing::kPreview:
      if (also_previews) work_.request_stop();
      break;
    case Doing::kPicture:
    case Doing::kSlices:
    case Doing::kProbe:
      work_.request_stop();
      break;
    case Doing::kOpening:
      if (open_) work_.request_stop();
      break;
    case Doing::kFrame:
      // A hand that never rests shall not keep a film from being written.
      if (!film_ || film_->stopped < kMostStopped) work_.request_stop();
      break;
    case Doing::kNothing:
    case Doing::kSaving:
      break;
  }
}

void DrawingThread::place(const ViewState& state, int width, int height) {
  Wish wish;
  wish.state = state;
  wish.width = width;
  wish.height = height;
  const MutexLock lock(mutex_);
  place_ = std::move(wish);
  stopWork(false);
  changed_.notifyAll();
}

uint64_t DrawingThread::probe(double right, double down) {
  const MutexLock lock(mutex_);
  probe_ = ProbeRequest{++probes_, right, down};
  if (status_.doing == Doing::kProbe) work_.request_stop();
  changed_.notifyAll();
  return probes_;
}

void DrawingThread::wantReport(bool maps) {
  const MutexLock lock(mutex_);
  wants_report_ = true;
  wants_maps_ = wants_maps_ || maps;
  changed_.notifyAll();
}

News DrawingThread::take() {
  const MutexLock lock(mutex_);
  return std::exchange(news_, {});
}

DeskStatus DrawingThread::status() const {
  const MutexLock lock(mutex_);
  return status_;
}

DeskTimes DrawingThread::times() const {
  const MutexLock lock(mutex_);
  return times_;
}

void DrawingThread::tell() {
  const MutexLock lock(telling_);
  if (on_news_) on_news_();
}

void DrawingThread::fail(const std::string& line) {
  {
    const MutexLock lock(mutex_);
    news_.failures.push_back(line);
  }
  tell();
}

// What is asked for first; then what is seen first. The whole picture waits while a hand moves.
DrawingThread::Job DrawingThread::chooseJob() {
  Job job;
  if (open_) {
    job.doing = Doing::kOpening;
    job.open = std::move(*std::exchange(open_, std::nullopt));
    return job;
  }
  if (takeTextSave(job) || !is_open_) return job;
  job.wish = wish_;
  const uint64_t newest = wish_ != nullptr ? wish_->number : 0;
  const bool rests = wish_ != nullptr &&
                     (!wish_->wish.moves || Clock::now() - wish_->asked_at >=
                                                std::chrono::duration<double>(options_.rest_s));
  if (place_) {
    job.doing = Doing::kProbe;
    job.place = std::move(*std::exchange(place_, std::nullopt));
  } else if (previewed_ < newest) {
    job.doing = Doing::kPreview;
  } else if (!saves_.empty()) {
    job.doing = Doing::kSaving;
    job.save = std::move(saves_.front());
    saves_.pop_front();
  } else if (status_.completed < newest && rests) {
    job.doing = Doing::kPicture;
  } else if (sliced_ < newest && wish_->wish.state.shows_slices) {
    job.doing = Doing::kSlices;
  } else if (probe_ && newest > 0) {
    job.doing = Doing::kProbe;
    job.probe = *std::exchange(probe_, std::nullopt);
  } else if (wants_report_) {
    job.reports = true;
  } else if (film_ && (rests || newest == 0)) {
    job.doing = Doing::kFrame;
    job.wish.reset();
    job.film = *film_;
  }
  return job;
}

// Small files are written at once, also where no volume is open and when all ends: a window's
// settings are its last wish.
bool DrawingThread::takeTextSave(Job& job) {
  const auto text = std::find_if(saves_.begin(), saves_.end(), [](const auto& save) {
    return std::holds_alternative<TextSave>(save);
  });
  if (text == saves_.end()) return false;
  job.doing = Doing::kSaving;
  job.save = std::move(*text);
  saves_.erase(text);
  return true;
}

DrawingThread::Job DrawingThread::startJob(Job job) {
  work_ = std::stop_source();
  work_began_ = Clock::now();
  job.stop = work_.get_token();
  status_.doing = job.doing;
  status_.share = 0;
  return job;
}

std::optional<DrawingThread::Job> DrawingThread::nextJob() {
  MutexLock lock(mutex_);
  status_.doing = Doing::kNothing;
  while (!ends_) {
    Job job = chooseJob();
    if (job.doing != Doing::kNothing || job.reports) return startJob(std::move(job));
    const bool waits_for_rest = is_open_ && wish_ != nullptr && status_.completed < wish_->number;
    if (waits_for_rest) {
      changed_.waitUntil(lock,
                         wish_->asked_at + std::chrono::duration_cast<Clock::duration>(
                                               std::chrono::duration<double>(options_.rest_s)));
    } else {
      changed_.wait(lock);
    }
  }
  Job last;
  if (takeTextSave(last)) return startJob(std::move(last));
  return std::nullopt;
}

void DrawingThread::run() {
  yieldToOthers();
  while (const std::optional<Job> job = nextJob()) {
    try {
      doJob(*job);
    } catch (const Cancelled&) {
      const MutexLock lock(mutex_);
      ++times_.cancelled;
    } catch (const std::exception& error) {
      // Of a wish: it is as good as served, so that it is not tried for ever.
      if (job->wish != nullptr && job->doing != Doing::kSaving) {
        const MutexLock lock(mutex_);
        previewed_ = sliced_ = status_.completed = job->wish->number;
      }
      fail(error.what());
    }
  }
  opened_ = {};
}

}  // namespace sluice
