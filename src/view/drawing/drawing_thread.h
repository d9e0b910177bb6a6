// DrawingThread: the Desk that a Renderer stands behind. Its thread takes the newest wish from a
// JobQueue, draws a preview within the frame's budget and then the whole picture, and gives up
// unwanted work through the stop token; results lie in a NewsBox.
//
// Callers only ever take locks that are never held while something is read or drawn.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "src/base/threads/worker_pool.h"
#include "src/view/drawing/drawing_jobs.h"

namespace sluice {

class DrawingThread : public Desk {
 public:
  explicit DrawingThread(const DrawingOptions& options);
  // Stops the work under way and waits for it.
  ~DrawingThread() override;
  DrawingThread(const DrawingThread&) = delete;
  DrawingThread& operator=(const DrawingThread&) = delete;

  void open(const ViewedVolume& volume, const std::optional<ViewState>& state) override;
  uint64_t wish(const Wish& wish) override { return queue_.wish(wish); }
  void loadState(const std::string& path) override;
  void savePicture(const std::string& path, const Wish& wish) override {
    queue_.save(SavePictureJob{path, wish});
  }
  void saveText(const std::string& path, const std::string& text,
                std::optional<FileKind> kind) override {
    queue_.save(SaveTextJob{path, text, kind});
  }
  void writeFrames(const FilmWish& film) override { queue_.writeFrames(film); }
  void cancelFrames() override { queue_.cancelFrames(); }
  uint64_t place(const ViewState& state, int width, int height) override;
  uint64_t probe(double right, double down) override { return queue_.probe(right, down); }
  void wantReport(bool maps) override { queue_.wantReport(maps); }
  News take() override {
    News news = news_.take();
    if (news.opened) queue_.noteSeen();
    return news;
  }
  DeskStatus status() const override { return queue_.status(); }
  DeskTimes times() const override { return queue_.times(); }
  // Volumes that are opened from now on are drawn in it, unless the CPU draws. It must outlive
  // this.
  void lend(std::shared_ptr<const ScreenContext> screen) { jobs_.lend(std::move(screen)); }
  // Replaces DrawingOptions::on_news; empty: nobody is told. Returns after earlier calls of the old
  // function have returned.
  void tellNews(std::function<void()> on_news) { news_.tellTo(std::move(on_news)); }
  // Stops the work under way, waits for it, and lets go of the volume. Returns what the last news
  // have to say, and what was asked for and is not written, a line each. Nothing else is called
  // afterwards.
  std::vector<std::string> end();

 private:
  void run();

  const DrawingOptions options_;
  JobQueue queue_;
  NewsBox news_;
  DrawingJobs jobs_;
  std::optional<WorkerPool> worker_{std::in_place, 1};  // last: joins before the rest goes
};

}  // namespace sluice
