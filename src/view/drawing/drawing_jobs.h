// DrawingJobs: the jobs of the drawing thread: it opens volumes, draws, answers and writes. It owns
// the volume and the renderer; the drawing thread alone calls it.
#pragma once

#include <sluice/renderer.h>
#include <sluice/volume.h>

#include <array>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "src/base/threads/mutex.h"
#include "src/view/drawing/job_queue.h"
#include "src/view/drawing/news_box.h"
#include "src/view/drawing/pace.h"
#include "src/view/state/files/state_file.h"

namespace sluice {

struct DrawingOptions {
  RendererOptions renderer;
  // The first state of the volume that is opened first.
  ViewState state;
  // The file that `state` was saved in, whose time and cross hair hold too; empty: no file.
  std::string state_file;
  std::optional<ViewPath> path;  // the path saved with it
  std::string index_folder;      // for volumes that name none
  // Gives the cache and the key with which these paths are read if they are addresses; not set:
  // neither.
  std::function<VolumeOptions::Web(const std::vector<std::string>& paths)> web_of;
  std::string trace_file;  // empty: none; of the volume that is opened first
  // Throws Error if one of `writes` must not be written: it is one of `reads`, or an existing file
  // of another kind. Empty: all may be.
  std::function<void(const std::vector<std::string>& reads, const std::vector<std::string>& writes)>
      check_outputs;
  double budget_s = 0.016;  // time for a preview
  // A hand that rests so long gets the whole picture.
  double rest_s = 0.06;
  // The drawing thread calls it when there is something to take. It must return at once.
  std::function<void()> on_news;
};

class DrawingJobs {
 public:
  DrawingJobs(const DrawingOptions& options, JobQueue& queue, NewsBox& news)
      : options_(options), queue_(queue), news_(news) {}

  // Does the job, tells the queue what is done and adds the results, or the failure, to the news.
  void run(const Job& job);
  // Lets go of the volume and the renderer.
  void close();
  // Volumes that are opened from now on are drawn in it. Any thread.
  void lend(std::shared_ptr<const ScreenContext> screen);

 private:
  // The volume that is open.
  struct Opened {
    ViewedVolume viewed;
    std::optional<Volume> volume;
    std::unique_ptr<Renderer> renderer;  // null: see useLook()
    LookOptions look;                    // the renderer's look
    LookOptions shown_look;              // look of the newest news; a film's frames have others
    Pace pace;
    struct Slice {
      int64_t at = -1, time = -1;
      SliceValues values;
      std::optional<std::array<double, 2>> range;  // the range shown last
    };
    std::array<Slice, 3> slices;
    bool is_recorded = false;  // in DrawingOptions::trace_file
  };

  // Each job throws Error, and Cancelled when its stop asks for it.
  void run(const OpenJob& task, const Job& job);
  void run(const PreviewJob& task, const Job& job);
  void run(const PictureJob& task, const Job& job);
  void run(const SlicesJob& task, const Job& job);
  void run(const PlaceJob& task, const Job& job);
  void run(const ProbeJob& task, const Job& job);
  void run(const ReportJob& task, const Job& job);
  void run(const SavePictureJob& task, const Job& job);
  void run(const SaveTextJob& task, const Job& job);
  void run(const FrameJob& task, const Job& job);

  void openVolume(OpenJob task, const Job& job);
  // Writes the pictures that wait for the volume that is open. Throws Cancelled.
  void savePictures(const Job& job);
  // Finishes the trace, if there is one; a failure is told in the news.
  void endTrace();
  void tellFailure(const std::string& line);
  // Shows the state on the volume that is open.
  void loadInto(StateFile file, const std::string& name, const Job& job);
  // Called before the first frame of a film.
  void beginFilm(const FilmWish& film);
  // Throws Error if they must not be written.
  void checkOutputs(const std::vector<std::string>& writes, const LookOptions& look) const;

  std::unique_ptr<Renderer> makeRenderer(const Volume& volume, const LookOptions& look) const;
  // Gives the renderer the state's look. Makes it again when another volume could not be opened in
  // place of this one. Throws Error.
  void useLook(const ViewState& state, bool is_shown = true);
  // The state's view by eye, target and up. Throws as Renderer::placed() does.
  ViewOptions placed(const ViewState& state, int width, int height, const Job& job);
  // Draws what a screen is to show: pixels, or the texture that holds them. Learns the pace from
  // it.
  ShownPicture draw(const Job& job, const PictureOptions& picture);
  void deliver(const NumberedWish& wish, ShownPicture picture, bool is_complete, double seconds);
  ProgressFunction progress() const;

  const DrawingOptions& options_;
  JobQueue& queue_;
  NewsBox& news_;
  mutable Mutex screen_mutex_;
  std::shared_ptr<const ScreenContext> screen_ SLUICE_GUARDED_BY(screen_mutex_);
  Opened opened_;
};

}  // namespace sluice
