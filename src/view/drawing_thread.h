// DrawingThread: the Desk that a Renderer stands behind. One thread owns the volume and the
// renderer; it takes the newest wish, draws a preview within the frame's budget and then the whole
// picture, and gives up what is not wanted any more through the stop token.
//
// Who asks only ever takes a lock that is never held while something is read or drawn.
#pragma once

#include <sluice/renderer.h>
#include <sluice/volume.h>

#include <array>
#include <chrono>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <variant>
#include <vector>

#include "src/base/mutex.h"
#include "src/base/worker_pool.h"
#include "src/view/camera_gestures.h"
#include "src/view/desk.h"
#include "src/view/pace.h"

namespace sluice {

struct DrawingOptions {
  RendererOptions renderer;
  // To begin with, of the volume that is opened first.
  ViewState state;
  bool is_saved_state = false;   // its time and cross hair hold too, where the volume has them
  std::optional<ViewPath> path;  // that was saved with it
  std::string index_folder;      // of volumes that name none
  std::string trace_file;        // empty: none; of the volume that is opened first
  // Throws Error where one of `writes` must not be written: it is one of `reads`, or something that
  // is there is of another kind. Empty: all may be.
  std::function<void(const std::vector<std::string>& reads, const std::vector<std::string>& writes)>
      check_outputs;
  double budget_s = 0.016;  // of a preview
  // A hand that rests so long gets the whole picture.
  double rest_s = 0.06;
  // Told, by the drawing thread, that there is something to take. It must return at once.
  std::function<void()> on_news;
};

class DrawingThread : public Desk {
 public:
  explicit DrawingThread(const DrawingOptions& options);
  // Stops what is under way and waits for it.
  ~DrawingThread() override;
  DrawingThread(const DrawingThread&) = delete;
  DrawingThread& operator=(const DrawingThread&) = delete;

  void open(const ViewedVolume& volume, const std::optional<ViewState>& state) override;
  uint64_t wish(const Wish& wish) override;
  void loadState(const std::string& path) override;
  void savePicture(const std::string& path, const Wish& wish) override;
  void saveText(const std::string& path, const std::string& text) override;
  void writeFrames(const FilmWish& film) override;
  void cancelFrames() override;
  void place(const ViewState& state, int width, int height) override;
  uint64_t probe(double right, double down) override;
  void wantReport(bool maps) override;
  News take() override;
  DeskStatus status() const override;
  DeskTimes times() const override;
  // Volumes that are opened from now on are drawn in it, where the CPU does not draw. It must
  // outlive this.
  void lend(std::shared_ptr<const ScreenContext> screen);
  // From now on in place of DrawingOptions::on_news; empty: nobody is told. What was told before
  // has returned.
  void tellNews(std::function<void()> on_news);

 private:
  using Clock = std::chrono::steady_clock;
  using Doing = DeskStatus::Doing;

  struct NumberedWish {
    uint64_t number = 0;
    Clock::time_point asked_at;
    Wish wish;
  };
  using WishPtr = std::shared_ptr<const NumberedWish>;
  struct OpenRequest {
    ViewedVolume volume;
    std::optional<ViewState> state;
    std::optional<ViewPath> path;
    std::string state_file;  // in place of both; empty: none
  };
  struct PictureSave {
    std::string path;
    Wish wish;
  };
  struct TextSave {
    std::string path, text;
  };
  using SaveRequest = std::variant<PictureSave, TextSave>;
  struct Film {
    uint64_t number = 0;
    std::shared_ptr<const FilmWish> wish;
    int64_t next = 0;  // frame
    int stopped = 0;   // times in a row that one was given up for something more urgent
  };
  struct ProbeRequest {
    uint64_t number = 0;
    double right = 0, down = 0;
  };
  // What is to be done next, with what it needs.
  struct Job {
    Doing doing = Doing::kNothing;
    WishPtr wish;
    OpenRequest open;
    SaveRequest save;
    Film film;
    ProbeRequest probe;
    std::optional<Wish> place;  // in place of a probe
    bool reports = false;       // nothing else is to be done
    std::stop_token stop;
  };
  // Of the volume that is open: the drawing thread's alone.
  struct Opened {
    ViewedVolume viewed;
    std::optional<Volume> volume;
    std::unique_ptr<Renderer> renderer;
    LookOptions look;        // that the renderer has
    LookOptions shown_look;  // of the newest news; a film's frames have others
    Ground ground;
    Pace pace;
    struct Slice {
      int64_t at = -1, time = -1;
      SliceValues values;
      std::optional<std::array<double, 2>> range;  // that was shown last
    };
    std::array<Slice, 3> slices;
  };

  void ask(OpenRequest request);
  void run();
  // Waits for something to do; nullopt: the end.
  std::optional<Job> nextJob();
  Job chooseJob() SLUICE_REQUIRES(mutex_);
  bool takeTextSave(Job& job) SLUICE_REQUIRES(mutex_);
  Job startJob(Job job) SLUICE_REQUIRES(mutex_);
  void doJob(const Job& job);
  void openAny(const Job& job);
  void openVolume(const OpenRequest& request, const Job& job);
  void noteVanished(const std::vector<std::string>& paths);
  void drawPreview(const Job& job);
  void drawWhole(const Job& job);
  void makeSlices(const Job& job);
  void answerProbe(const Job& job);
  void save(const Job& job);
  void save(const PictureSave& save, const Job& job);
  void save(const TextSave& save);
  void writeFrame(const Job& job);
  // Of a film, before its first frame.
  void beginFilm(const FilmWish& film);
  void endFilm() SLUICE_REQUIRES(mutex_);

  // Throws Error where they must not be written.
  void checkOutputs(const std::vector<std::string>& writes, const LookOptions& look) const;

  void useLook(const LookOptions& look, bool is_shown = true);
  // Voxels between samples of the wish's whole picture.
  double wholeStep(const Wish& wish) const;
  Image drawImage(const Job& job, const PictureOptions& picture);
  // What a screen is to show of it, nothing but pixels or where they are. Learns from it.
  ShownPicture draw(const Job& job, const PictureOptions& picture, double step_vox);
  void deliver(const WishPtr& wish, ShownPicture picture, bool is_complete, double seconds);
  void deliverReport();
  void stopWork(bool also_previews) SLUICE_REQUIRES(mutex_);
  void fail(const std::string& line);
  void tell();
  ProgressFunction progressOf(const Job& job);

  const DrawingOptions options_;

  Mutex telling_;  // held while somebody is told: who is no longer told is not told any more
  std::function<void()> on_news_ SLUICE_GUARDED_BY(telling_);

  mutable Mutex mutex_;
  Condition changed_;
  bool ends_ SLUICE_GUARDED_BY(mutex_) = false;
  bool is_open_ SLUICE_GUARDED_BY(mutex_) = false;
  std::shared_ptr<const ScreenContext> screen_ SLUICE_GUARDED_BY(mutex_);
  std::optional<OpenRequest> open_ SLUICE_GUARDED_BY(mutex_);
  std::deque<SaveRequest> saves_ SLUICE_GUARDED_BY(mutex_);
  std::optional<Film> film_ SLUICE_GUARDED_BY(mutex_);
  uint64_t films_ SLUICE_GUARDED_BY(mutex_) = 0;
  std::optional<ProbeRequest> probe_ SLUICE_GUARDED_BY(mutex_);
  std::optional<Wish> place_ SLUICE_GUARDED_BY(mutex_);
  bool wants_report_ SLUICE_GUARDED_BY(mutex_) = false, wants_maps_
                                                        SLUICE_GUARDED_BY(mutex_) = false;
  uint64_t probes_ SLUICE_GUARDED_BY(mutex_) = 0;
  WishPtr wish_ SLUICE_GUARDED_BY(mutex_);  // the newest
  // Numbers of the wishes that were served last.
  uint64_t previewed_ SLUICE_GUARDED_BY(mutex_) = 0, sliced_ SLUICE_GUARDED_BY(mutex_) = 0;
  uint64_t answered_ SLUICE_GUARDED_BY(mutex_) = 0;  // by any picture
  std::deque<std::pair<uint64_t, Clock::time_point>> unanswered_ SLUICE_GUARDED_BY(mutex_);
  DeskStatus status_ SLUICE_GUARDED_BY(mutex_);
  DeskTimes times_ SLUICE_GUARDED_BY(mutex_);
  News news_ SLUICE_GUARDED_BY(mutex_);
  std::stop_source work_ SLUICE_GUARDED_BY(mutex_);  // of the job under way
  Clock::time_point work_began_ SLUICE_GUARDED_BY(mutex_);

  Opened opened_;         // the drawing thread's alone
  WorkerPool worker_{1};  // last: joins before the rest goes
};

}  // namespace sluice
