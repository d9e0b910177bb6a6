#include "src/view/drawing/drawing_thread.h"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <string>
#include <string_view>
#include <utility>

#include "src/base/field_names.h"

namespace sluice {
namespace {

// The thread that shows pictures has priority if processors are few: this thread, and with it those
// that the renderer starts, come after it. One step is enough. With five, the previews that a hand
// waits for came after all other programs, too, and took twice as long during builds.
void yieldToOthers() {
  constexpr int kNicer = 1;
  const auto self = static_cast<id_t>(gettid());
  setpriority(PRIO_PROCESS, self, getpriority(PRIO_PROCESS, self) + kNicer);
}

// The window's names of the options that its check boxes stand for.
constexpr std::array kBoxes = std::to_array<std::pair<std::string_view, std::string_view>>(
    {{"--modulate", "\"by gradient\""},
     {"--shadows", "\"shadows\""},
     {"--occlusion-light", "\"occlusion\""}});

// An error's line in the words of the window; options without a check box keep their names.
std::string lineInWindow(const std::exception& error) {
  std::string line = lineInOptions(error);
  const auto isNamed = [&](const auto& box) { return line.find(box.first) != std::string::npos; };
  if (std::ranges::none_of(kBoxes, isNamed)) return line;
  return renamed(line, [](std::string_view option) {
    const auto* box =
        std::ranges::find(kBoxes, option, [](const auto& each) { return each.first; });
    return std::string(box == kBoxes.end() ? option : box->second);
  });
}

}  // namespace

DrawingThread::DrawingThread(const DrawingOptions& options)
    : options_(options),
      queue_(options.rest_s),
      news_(options.on_news),
      jobs_(options_, queue_, news_) {
  worker_.submit([this] { run(); });
}

DrawingThread::~DrawingThread() {
  queue_.end();
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
  while (const std::optional<Job> job = queue_.next()) {
    try {
      jobs_.run(*job);
    } catch (const Cancelled&) {
      queue_.noteCancelled(*job);
    } catch (const std::exception& error) {
      news_.add([&](News& news) { news.failures.push_back(lineInWindow(error)); });
      queue_.noteFailed(*job);
    }
  }
  jobs_.close();
}

}  // namespace sluice
