#include "tools/commands/render_frames.h"

#include <chrono>
#include <filesystem>
#include <utility>

#include "src/base/threads/clock.h"
#include "tools/command_line/console.h"
#include "tools/command_line/interrupt.h"
#include "tools/command_line/progress_line.h"
#include "tools/commands/debug_views.h"
#include "tools/commands/render_checks.h"
#include "tools/outputs/cut_report.h"
#include "tools/outputs/film_file.h"

namespace sluice {
namespace {

// When drawing has to end, so that the picture is written in time.
std::optional<Deadline::TimePoint> endOfDrawing(const FrameOptions& options,
                                                Deadline::TimePoint began) {
  if (!options.time_limit_s) return std::nullopt;
  constexpr double kWriteSecondsAPixel = 1e-7;  // PNG on one core
  const double write_s = kWriteSecondsAPixel * options.size.width * options.size.height;
  return began + std::chrono::duration_cast<std::chrono::nanoseconds>(
                     std::chrono::duration<double>(*options.time_limit_s - write_s));
}

// How a frame becomes a row of pictures that get better.
struct Row {
  Deadline::TimePoint began;  // where its seconds are counted from
  std::optional<Deadline::TimePoint> until;
  std::vector<RefinedPicture> earlier = {};  // its pictures that were drawn before
};

// Draws a frame as pictures that get better. With --progressive each is written as it comes,
// numbered if the name has a place for a number; otherwise the caller writes the last one.
RefinedFrame drawRow(const RenderJob& job, const FrameOptions& options, const Row& row,
                     std::filesystem::path& name) {
  const RenderArguments& arguments = job.arguments;
  const auto take = [&](const BetterPicture& better) {
    if (!arguments.progressive) return;
    if (numbersPictures(arguments))
      name = numberedName(arguments.output,
                          better.number + static_cast<int64_t>(row.earlier.size()), true);
    PictureWriter writer(name, job.output, better.options, job.scene);
    writer.add(better.frame.picture);
    writer.commit();
    if (!arguments.resources.quiet && !arguments.json)
      say("{}: {:.2f} s, {}\n", name.string(), better.seconds,
          refinedLine(*better.frame.report.cut));
  };
  FrameOptions uncounted = options;
  if (options.time_limit_s) uncounted.count_samples = false;  // takes time of its own
  RefinedFrame frame =
      drawRefined(job.scene, uncounted, job.has_step, arguments.end, row.began, row.until, take);
  frame.pictures.insert(frame.pictures.begin(), row.earlier.begin(), row.earlier.end());
  return frame;
}

// Sets the camera, and unless --step is given the distance of samples that suits it; and the line
// that reproduces the look with that distance.
void look(const RenderJob& job, const Camera& camera, const std::vector<TimeStep>& steps,
          FrameOptions& options) {
  options.camera = camera;
  options.step_vox = job.arguments.frame.step_vox;
  const auto last = [&] { return lastOptions(job.scene, options, job.arguments.end); };
  if (!job.has_step) options.step_vox = job.scene.chosenStep(steps, last());
  job.scene.drawn_look = job.scene.lookOf(last(), *job.arguments.asked);
}

// The frames of a job, and what was drawn of them so far.
class Frames {
 public:
  Frames(const RenderJob& job, Series& series)
      : job_(job),
        arguments_(job.arguments),
        scene_(job.scene),
        series_(series),
        is_refined_(isRefined(job.arguments, job.scene)),
        strips_(job.scene.stripsOf(job.options)),
        options_(job.options) {
    const bool is_watched = job.is_first && !arguments_.resources.quiet;
    if (is_watched && frameCount(arguments_) > 1)
      progress_.emplace(progressLine("frames", ProgressUnit::kPieces),
                        static_cast<uint64_t>(job.to_draw.size()));
    else
      progress_.emplace();
    if (is_watched && frameCount(arguments_) == 1 && !is_refined_) watchPicture();
    if (job.is_first && isFilmName(arguments_.output))
      film_.emplace(arguments_.output, options_.size, arguments_.frames_per_second, interruption());
  }

  Drawn draw() {
    // An interruption ends the loop instead of the program where a report tells of what is done.
    for (size_t at = 0; at < job_.to_draw.size() && !drawn_.is_cut; ++at) try {
        drawFrame(at);
      } catch (const Interrupted&) {
        if (drawn_.frames.empty() || !reportsParts(arguments_)) throw;
        drawn_.is_cut = true;
      }
    if (film_) film_->finish();
    return std::move(drawn_);
  }

 private:
  // Progress of a single picture by its strips and clusters. If it has one, nobody knows how far it
  // is.
  void watchPicture() {
    const ProgressWatch line = progressLine("drawing", ProgressUnit::kShare);
    if (!line) return;
    options_.watch = [this, line, strips = strips_.size()](uint64_t done, uint64_t total) {
      if (strips * total > 1) line(strips_drawn_ * total + done, strips * total);
    };
  }

  // Tells the session and the series which frame comes, and which one next.
  void show(size_t at) {
    const Camera& camera = cameraOf(job_.cameras, job_.to_draw[at]);
    const bool is_series = isSeries(arguments_);
    // A turn keeps its distance, and with it the distance of samples. Steps that keep thin parts
    // may show other levels.
    const bool keeps_thin = is_series && options_.cut && options_.cut->keeps_thin;
    if (arguments_.path_file.empty() && !keeps_thin)
      options_.camera = camera;
    else
      look(job_, camera,
           is_series ? series_.steps(timeOf(arguments_, job_.to_draw[at])) : scene_.openedSteps(),
           options_);
    scene_.setOptions(options_);
    if (!is_series) return;
    // The next step's blocks would take the room of those that the next strip needs again.
    const bool reads_ahead =
        arguments_.times && strips_.size() == 1 && at + 1 < job_.to_draw.size();
    series_.show(
        timeOf(arguments_, job_.to_draw[at]),
        reads_ahead ? std::optional(timeOf(arguments_, job_.to_draw[at + 1])) : std::nullopt);
  }

  void drawFrame(size_t at) {
    show(at);
    // The picture before gives its memory to the next one.
    scene_.device->reuse(std::move(drawn_.picture));
    drawn_.name = frameName(arguments_, job_.to_draw[at]);
    std::optional<PictureWriter> writer;
    SceneFrame frame;
    double write_seconds = 0;
    FrameOptions shown = options_;
    if (is_refined_) {
      Row row{std::chrono::steady_clock::now(), {}};
      if (at == 0) row = {job_.began, {}, job_.earlier};
      row.until = endOfDrawing(options_, row.began);
      RefinedFrame refined = drawRow(job_, options_, row, drawn_.name);
      drawn_.refined.push_back(std::move(refined.pictures));
      frame = std::move(refined.frame);
      shown = refined.options;
    }
    const bool writes = job_.is_first && !(is_refined_ && arguments_.progressive);
    if (writes) writer.emplace(drawn_.name, job_.output, shown, scene_, film_ ? &*film_ : nullptr);
    const auto write = [&](const Picture& rows) {
      const Stopwatch watch;
      if (writer) writer->add(rows);
      ++strips_drawn_;
      write_seconds += watch.seconds();
    };
    if (!is_refined_)
      frame = scene_.draw(strips_, write);
    else if (writes)
      writer->add(frame.whole->picture);
    if (options_.watch) {  // the session keeps the options
      options_.watch = {};
      scene_.setOptions(options_);
    }
    drawn_.blocks = frame.blocks;
    drawn_.step_vox = shown.step_vox;
    std::string empty, empty_layers;
    if (job_.is_first) {
      const IndexPass pass = passOf(scene_, *progress_);
      const int64_t time = timeOf(arguments_, job_.to_draw[at]);
      empty = scene_.whyNothing(frame, time, shown, pass);
      empty_layers = scene_.emptyLayers(frame, time, shown, pass);
    }
    const Stopwatch watch;
    if (writer) writer->commit();
    drawn_.frames.push_back({frame.report, write_seconds + watch.seconds(), std::move(empty),
                             std::move(frame.layers), std::move(empty_layers)});
    if (series_.culls()) drawn_.culling.push_back(countsJson(series_.counts()));
    progress_->add(1);
    if (arguments_.debug_view)
      drawn_.views = writeDebugViews(drawn_.name, *frame.whole, scene_, arguments_.volume,
                                     scene_.volume.places, options_.partition);
    if (frame.whole) drawn_.picture = std::move(frame.whole->picture);
  }

  const RenderJob& job_;
  const RenderArguments& arguments_;
  Scene& scene_;
  Series& series_;
  const bool is_refined_;
  const std::vector<PictureRows> strips_;
  FrameOptions options_;
  uint64_t strips_drawn_ = 0;
  std::optional<ProgressMeter> progress_;
  std::optional<FilmFile> film_;
  Drawn drawn_;
};

}  // namespace

const Camera& cameraOf(const std::vector<Camera>& cameras, int64_t frame) {
  return cameras[cameras.size() == 1 ? 0 : static_cast<size_t>(frame)];
}

FrameOptions drawingOptions(const RenderJob& job) {
  FrameOptions options = job.arguments.frame;
  look(job, job.cameras.front(), job.scene.openedSteps(), options);
  options.lighting.flat_share *= job.scene.look.flat_scale;
  options.count_samples = wantsReport(job.arguments);
  options.keep_phases = job.arguments.debug_view;
  options.with_depth = job.output.aovs.depth;
  return options;
}

std::vector<RefinedPicture> drawSample(const RenderJob& job) {
  if (!job.arguments.resources.quiet)
    for (const std::string& note : job.scene.standInNotes()) printWarning(note);
  FrameOptions options = drawingOptions(job);
  requireOnePicture(job.arguments, job.scene);
  std::filesystem::path name = frameName(job.arguments, 0);
  // The time of a sample's row is over at once, so that it ends with its first picture.
  return drawRow(job, options, {job.began, job.began}, name).pictures;
}

void chooseCulling(const RenderJob& job, Series& series) {
  std::vector<int64_t> times;
  for (const int64_t i : job.to_draw)
    if (job.arguments.times) times.push_back(timeOf(job.arguments, i));
  FrameOptions options = job.options;
  options.camera = cameraOf(job.cameras, job.to_draw.front());
  options.count_samples = options.keep_phases = false;
  job.scene.setOptions(options);
  series.choose(times);
}

Drawn drawFrames(const RenderJob& job, Series& series) {
  return Frames(job, series).draw();
}

}  // namespace sluice
