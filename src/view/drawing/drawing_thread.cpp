#include "src/view/drawing/drawing_thread.h"

#include <sys/resource.h>
#include <unistd.h>

#include <string>
#include <utility>

namespace sluice {
namespace {

// The thread that shows pictures has priority if processors are few: this thread, and with it those
// that the renderer starts, come after it. One step is enough. With five, the previews that a hand
// waits for came after all other programs, too, and took twice as long during builds.
void yieldToOthers() {
  constexpr int kNicer = 1;
  // Linux keeps a nice value for each thread, and threads inherit that of the one that starts them.
  const auto self = static_cast<id_t>(gettid());
  setpriority(PRIO_PROCESS, self, getpriority(PRIO_PROCESS, self) + kNicer);
}

}  // namespace

DrawingThread::DrawingThread(const DrawingOptions& options)
    : options_(options),
      queue_(options.rest_s),
      news_(options.on_news),
      jobs_(options_, queue_, news_) {
  worker_->submit([this] { run(); });
}

// The members go in reverse order: the pool comes first and joins the thread, which uses all others
// until then.
DrawingThread::~DrawingThread() {
  queue_.end();
}

std::vector<std::string> DrawingThread::end() {
  queue_.end();
  // Whatever the thread still adds to the news is there when it has been joined.
  worker_.reset();  // joins
  News last = news_.take();
  std::vector<std::string> lines = std::move(last.notes);
  for (const std::vector<std::string>& more : {last.failures, queue_.unwritten()})
    lines.insert(lines.end(), more.begin(), more.end());
  return lines;
}

void DrawingThread::open(const ViewedVolume& volume, const std::optional<ViewState>& state) {
  OpenJob job;
  job.volume = volume;
  job.state = state;
  queue_.open(std::move(job));
}

void DrawingThread::loadState(const std::string& path) {
  OpenJob job;
  job.state_file = path;
  queue_.open(std::move(job));
}

uint64_t DrawingThread::place(const ViewState& state, int width, int height) {
  return queue_.place(Wish{.state = state, .width = width, .height = height});
}

void DrawingThread::run() {
  yieldToOthers();
  while (const std::optional<Job> job = queue_.next()) jobs_.run(*job);
  jobs_.close();
}

}  // namespace sluice
