// sluice render: pictures of a volume, as PNG or EXR.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <memory>

#include "src/annotate/annotate.h"
#include "src/base/error.h"
#include "src/base/threads/clock.h"
#include "src/base/values/bytes.h"
#include "src/library/empty_picture.h"
#include "src/library/picture_memory.h"
#include "src/render/blocks/level_cut.h"
#include "src/render/session/planner.h"
#include "src/view/state/view_path.h"
#include "tools/command_line/console.h"
#include "tools/command_line/interrupt.h"
#include "tools/command_line/progress_line.h"
#include "tools/commands/commands.h"
#include "tools/commands/debug_views.h"
#include "tools/commands/verification.h"
#include "tools/options/render_arguments.h"
#include "tools/options/shared_options.h"
#include "tools/options/view_state_option.h"
#include "tools/outputs/film.h"
#include "tools/outputs/film_file.h"
#include "tools/outputs/picture_output.h"
#include "tools/outputs/render_report.h"
#include "tools/outputs/report.h"
#include "tools/pages/report_file.h"
#include "tools/scene/fitted_scene.h"
#include "tools/scene/rank_agreement.h"
#include "tools/scene/ranks.h"
#include "tools/scene/refined_drawing.h"
#include "tools/scene/scene.h"
#include "tools/scene/series.h"
#include "tools/scene/strip_drawing.h"

namespace sluice {
namespace {

using Arguments = RenderArguments;

// A single picture has its own progress, if any.
bool showsFrames(const Arguments& arguments) {
  return frameCount(arguments) > 1 && !arguments.resources.quiet;
}

// The frames that are still to be drawn: pictures appear whole or not at all.
std::vector<int64_t> framesToDraw(const Arguments& arguments) {
  std::vector<int64_t> frames;
  for (int64_t i = 0; i < frameCount(arguments); ++i)
    if (!arguments.resume || !std::filesystem::exists(frameName(arguments, i))) frames.push_back(i);
  return frames;
}

bool isExr(const Arguments& arguments) {
  return pictureKind(arguments.output) == PictureKind::kExr;
}

// Whether the pictures of one frame that gets better are files of their own.
bool numbersPictures(const Arguments& arguments) {
  return arguments.progressive && isNumbered(arguments.output) && frameCount(arguments) == 1;
}
// At most one a level, and one more that the time ends.
constexpr int64_t kMostPictures = 64;

Outputs outputsOf(const Arguments& arguments) {
  Outputs outputs(arguments.force);
  outputs.reads(arguments.volume.inputs);
  outputs.reads({arguments.look.transfer_file, arguments.path_file, arguments.state_file});
  outputs.reads(basisFiles(arguments.culling));
  if (isFilmName(arguments.output))
    outputs.writes("-o", arguments.output, FileKind::kFilm);
  else if (numbersPictures(arguments))
    for (int64_t i = 0; i < kMostPictures; ++i)
      outputs.writes("-o", numberedName(arguments.output, i, true),
                     isExr(arguments) ? FileKind::kExr : FileKind::kPng);
  else
    for (const int64_t i : framesToDraw(arguments))
      outputs.writes("-o", frameName(arguments, i),
                     isExr(arguments) ? FileKind::kExr : FileKind::kPng);
  if (arguments.debug_view)
    for (const auto& view : debugViewNames(frameName(arguments, 0)))
      outputs.writes("--debug-view", view, FileKind::kPng);
  outputs.writes("--report", arguments.report_file, reportKind(arguments.report_file));
  outputs.writesTrace("--trace", arguments.trace_file);
  return outputs;
}

void checkOutput(const Arguments& arguments) {
  const auto kind = pictureKind(arguments.output);
  const bool is_film = isFilmName(arguments.output);
  if (!kind && !is_film)
    fail("{}: pictures are written as .png or .exr, films as .mp4", arguments.output);
  if (is_film && frameCount(arguments) < 2)
    fail("{}: a film has several frames; give --frames or a range of --time", arguments.output);
  if (is_film && arguments.resume)
    fail("{}: a film is written in one go; --continue is for pictures", arguments.output);
  if (is_film && arguments.progressive)
    fail("{}: a film has one picture a frame; --progressive is for pictures", arguments.output);
  if (arguments.progressive && isSeries(arguments))
    fail("--progressive takes one time step and no --culling");
  if (!arguments.path_file.empty() && frameCount(arguments) < 2)
    throw CLI::RequiresError("--path", "--frames or a range of --time");
  if (arguments.aovs && kind != PictureKind::kExr)
    fail("{}: --aov adds channels to .exr pictures", arguments.output);
  if (arguments.annotate && kind == PictureKind::kExr)
    fail("{}: --annotate draws over .png pictures; an .exr holds values", arguments.output);
  const PictureSize& size = arguments.frame.size;
  if (arguments.annotate && std::min(size.width, size.height) < kLeastAnnotatedPixels)
    fail("--annotate: a picture of {} x {} pixels has no room for letters; it needs {} x {}",
         size.width, size.height, kLeastAnnotatedPixels, kLeastAnnotatedPixels);
  if (arguments.aovs && arguments.aovs->depth && arguments.frame.mode != Mode::kComposite)
    fail("--aov depth needs --mode composite, since depth is weighted by opacity");
  if (arguments.debug_view && frameCount(arguments) > 1)
    fail("--debug-view takes one frame, not {}", frameCount(arguments));
  if (arguments.times && arguments.frames > 1)
    fail("--frames {} takes one time step, not a range of --time", arguments.frames);
  if (arguments.culling.culling != Culling::kNone && arguments.frame.mode != Mode::kComposite)
    fail("--culling needs --mode composite, since other modes hide nothing");
  if (arguments.verify && arguments.culling.culling != Culling::kNone && frameCount(arguments) > 1)
    fail("--verify with --culling takes one frame, not {}", frameCount(arguments));
  if (arguments.debug_view && arguments.frame.occlusion == Occlusion::kOff &&
      arguments.frame.partition == Partition::kBlocks)
    fail("--debug-view shows the effect of --occlusion and --partition boxes; give one of them");
}

// The finest level in the picture.
int finestLevelOf(Scene& scene, const View& view, const FrameOptions& options) {
  const TimeStep step = scene.volume.step();
  if (!drawsCut(step, options.cut, options.mode, scene.transfer.labels)) return 0;
  if (!options.cut->keeps_thin) return finestLevelShown(step, view, *options.cut);
  // Thin parts may be refined anywhere, which the cut alone tells.
  ChunkNames names;
  Planner planner(scene.volume.page, scene.pool, names);
  const LookPtr look =
      planner.look(step, std::make_shared<const TransferFunction>(scene.transfer), options.mode);
  const VisibleBlocksPtr blocks = planner.visibleBlocks(step, look, view, options);
  return blocks->cut->levels.empty() ? 0 : blocks->cut->levels.front().level;
}

// The distance between slices if the user does not set it: it follows from the first view.
double chosenStep(Scene& scene, const Camera& camera, const FrameOptions& options) {
  if (options.mode != Mode::kComposite) return options.step_vox;
  const VolumeLayout& layout = scene.volume.source->layout();
  const View view = resolve(camera, layout, options.size, options.step_vox);
  return stepFor(view, scene.volume.step(), finestLevelOf(scene, view, options));
}

// Culling knows the blocks of the finest level alone.
std::optional<CutOptions> cutOf(const Arguments& arguments, Team* team) {
  if (arguments.culling.culling != Culling::kNone) {
    refuseLevels(arguments.levels, "--culling draws the finest level alone");
    return std::nullopt;
  }
  LevelArguments levels = arguments.levels;
  // Pictures that get better begin with any level; means cannot show some of them.
  if (asksForRefinement(arguments) && !isSeries(arguments) && team == nullptr && !levels.level &&
      suitDefaultCut(arguments.frame.mode, arguments.look.labels))
    levels.pixel_error = levels.pixel_error.value_or(CutOptions().pixel_error);
  std::optional<CutOptions> cut =
      cutOptions(levels, arguments.resources, arguments.look, arguments.frame);
  // All ranks make the same cut, and each holds its share of the blocks.
  if (cut && team != nullptr)
    cut->most_held_bytes = static_cast<uint64_t>(team->ranks()) *
                           std::stoull(team->fromFirst(std::to_string(cut->most_held_bytes)));
  return cut;
}

PictureOutput outputOf(const Arguments& arguments) {
  PictureOutput output;
  if (arguments.look.has_background) output.background = arguments.look.background;
  output.annotate = arguments.annotate;
  if (pictureKind(arguments.output) == PictureKind::kExr)
    output.aovs = arguments.aovs.value_or(Aovs{.depth = arguments.frame.mode == Mode::kComposite});
  return output;
}

// Reports a step that the series lacks before anything is drawn.
void checkLastStep(const Arguments& arguments) {
  if (!arguments.times) return;
  VolumeArguments last = arguments.volume;
  last.time = arguments.times->at(arguments.times->count() - 1);
  openSource(last);
}

// For a series without a path, one camera shows every step.
const Camera& cameraOf(const std::vector<Camera>& cameras, int64_t frame) {
  return cameras[cameras.size() == 1 ? 0 : static_cast<size_t>(frame)];
}

// The frames of rank 0, which writes them.
std::vector<int64_t> framesToDraw(const Arguments& arguments, Team* team) {
  std::vector<int64_t> frames = framesToDraw(arguments);
  if (team == nullptr) return frames;
  return nlohmann::json::parse(team->fromFirst(nlohmann::json(frames).dump()))
      .get<std::vector<int64_t>>();
}

// `first`: the camera of the first picture.
FrameOptions frameOptions(const Arguments& arguments, const CLI::App& app, const Camera& first,
                          const PictureOutput& output, Scene& scene) {
  FrameOptions options = arguments.frame;
  if (app.count("--step") == 0) options.step_vox = chosenStep(scene, first, options);
  if (options.mode == Mode::kComposite)
    scene.look.options += fmt::format(" --step {}", options.step_vox);
  options.lighting.flat_share *= scene.look.flat_scale;
  options.count_samples = wantsReport(arguments);
  options.keep_phases = arguments.debug_view;
  options.with_depth = output.aovs.depth;
  return options;
}

// Whether a signal leaves a report of the pictures that were there by then: --continue draws the
// others and reports all.
bool reportsParts(const Arguments& arguments) {
  return frameCount(arguments) > 1 && !arguments.report_file.empty() &&
         !isPage(arguments.report_file) && !isFilmName(arguments.output);
}

// Whether the scene's frames are rows of pictures that get better: a volume of one level has no
// coarser picture to begin with.
bool isRefined(const Arguments& arguments, const Scene& scene) {
  return asksForRefinement(arguments) && !isSeries(arguments) && scene.share == nullptr &&
         drawsCut(scene.volume.step(), arguments.frame.cut, arguments.frame.mode,
                  scene.transfer.labels);
}

// Options that look at a whole picture do not go with one that is drawn in strips.
void requireWholePicture(const Arguments& arguments, const Scene& scene) {
  const bool is_refined = isRefined(arguments, scene);
  if (!arguments.verify && !arguments.debug_view && !is_refined) return;
  if (is_refined && (arguments.verify || arguments.debug_view))
    fail("{} looks at one picture; leave out --time-limit and --progressive",
         arguments.verify ? "--verify" : "--debug-view");
  if (stripsFor(scene).size() == 1) return;
  const PictureSize size = scene.pictures.size;
  const uint64_t needed = 4 * wholePictureBytes(scene.pictures);
  fail(
      "{} needs the whole picture of {} x {} in memory, and --memory {} has no room; give "
      "--memory {}",
      arguments.verify        ? "--verify"
      : arguments.debug_view  ? "--debug-view"
      : arguments.progressive ? "--progressive"
                              : "--time-limit with levels of resolution",
      size.width, size.height, formatBytes(scene.memory_bytes), needed);
}

// The reason why the picture of a frame shows nothing, in one line; empty if it shows something.
std::string emptyReason(const Arguments& arguments, Scene& scene, const FrameOptions& options,
                        const WrittenFrame& frame, int64_t number, ProgressMeter& progress) {
  if (frame.shows_something) return "";
  return whyEmpty({scene.volume, timeOf(arguments, number), scene.transfer, options,
                   frame.report.missing_share},
                  {scene.pool, progress, scene.memory_bytes, interruption()});
}

// Decides for --culling auto before the first picture; frames of turns and paths show one step,
// which is not measured.
void chooseCulling(const Arguments& arguments, const std::vector<int64_t>& to_draw,
                   const std::vector<Camera>& cameras, FrameOptions options, Scene& scene,
                   Series& series) {
  std::vector<int64_t> times;
  for (const int64_t i : to_draw)
    if (arguments.times) times.push_back(timeOf(arguments, i));
  options.camera = cameraOf(cameras, to_draw.front());
  options.count_samples = options.keep_phases = false;
  scene.session->setOptions(options);
  series.choose(times);
}

// When drawing has to end, so that the picture is written in time.
std::optional<Deadline::TimePoint> endOfDrawing(const FrameOptions& options,
                                                Deadline::TimePoint began) {
  if (!options.time_limit_s) return std::nullopt;
  constexpr double kWriteSecondsAPixel = 1e-7;  // PNG on one core
  const double write_s = kWriteSecondsAPixel * options.size.width * options.size.height;
  return began + std::chrono::duration_cast<std::chrono::nanoseconds>(
                     std::chrono::duration<double>(*options.time_limit_s - write_s));
}

// How the frames become rows of pictures that get better.
struct RowOptions {
  bool is_refined = false;
  bool has_step = false;      // --step is given, the same for all pictures
  Deadline::TimePoint began;  // of the command: the first frame's time counts from here
  // Pictures of the first frame that were drawn from a sample, as in its report.
  nlohmann::json earlier = nlohmann::json::array();
};

// Draws a frame as pictures that get better. With --progressive each is written as it comes,
// numbered if the name has a place for a number; the last one is written by the caller otherwise.
RefinedFrame drawPictures(const Arguments& arguments, const PictureOutput& output,
                          const FrameOptions& options, const RowOptions& row, Scene& scene,
                          std::optional<Deadline::TimePoint> until, std::filesystem::path& name) {
  const auto step_of = [&](const CutOptions& cut) {
    if (row.has_step) return options.step_vox;
    FrameOptions of_cut = options;
    of_cut.cut = cut;
    return chosenStep(scene, options.camera, of_cut);
  };
  const auto take = [&](const BetterPicture& better) {
    if (!arguments.progressive) return;
    if (numbersPictures(arguments))
      name = numberedName(arguments.output,
                          better.number + static_cast<int64_t>(row.earlier.size()), true);
    PictureWriter writer(name, output, better.options, scene);
    writer.add(better.frame.picture);
    writer.commit();
    if (!arguments.resources.quiet && !arguments.json)
      say("{}: {:.2f} s, {}\n", name.string(), better.seconds,
          refinedLine(*better.frame.report.cut));
  };
  FrameOptions uncounted = options;
  if (options.time_limit_s) uncounted.count_samples = false;  // takes time of its own
  RefinedFrame frame = drawRefined(scene, uncounted, step_of, row.began, until, take);
  frame.pictures.insert(frame.pictures.begin(), row.earlier.begin(), row.earlier.end());
  return frame;
}

// Draws the one picture that a sample gives. The pass over all voxels follows it, and better
// pictures. Returns its part of the report.
nlohmann::json drawSample(const Arguments& arguments, const CLI::App& app,
                          const PictureOutput& output, const FittedScene& fitted,
                          Deadline::TimePoint began) {
  Scene& scene = *fitted.scene;
  if (!arguments.resources.quiet) printWarning(scene.volume.standInNote());
  FrameOptions options = frameOptions(arguments, app, fitted.cameras.front(), output, scene);
  options.camera = fitted.cameras.front();
  requireWholePicture(arguments, scene);
  const RowOptions row{.is_refined = true, .has_step = app.count("--step") > 0, .began = began};
  std::filesystem::path name = frameName(arguments, 0);
  return drawPictures(arguments, output, options, row, scene, began, name).pictures;
}

// Draws the frames and writes their pictures, which the first rank does for all.
Drawn drawAll(const Arguments& arguments, const std::vector<int64_t>& to_draw,
              const std::vector<Camera>& cameras, const PictureOutput& output, FrameOptions options,
              const RowOptions& row, Scene& scene, Series& series, bool is_first) {
  ProgressMeter progress = showsFrames(arguments)
                               ? ProgressMeter(progressLine("frames", ProgressUnit::kPieces),
                                               static_cast<uint64_t>(to_draw.size()))
                               : ProgressMeter();
  Drawn drawn;
  std::optional<FilmFile> film;
  if (is_first && isFilmName(arguments.output))
    film.emplace(arguments.output, options.size, arguments.frames_per_second, interruption());
  const std::vector<PictureRows> strips = stripsFor(scene);
  // The next step's blocks would take the room of those that the next strip needs again.
  const bool reads_ahead = arguments.times && strips.size() == 1;
  const auto drawFrame = [&](size_t at) {
    const int64_t i = to_draw[at];
    options.camera = cameraOf(cameras, i);
    scene.session->setOptions(options);
    if (isSeries(arguments))
      series.show(timeOf(arguments, i), reads_ahead && at + 1 < to_draw.size()
                                            ? std::optional(timeOf(arguments, to_draw[at + 1]))
                                            : std::nullopt);
    scene.device->reuse(std::move(drawn.picture));
    drawn.name = frameName(arguments, i);
    std::optional<PictureWriter> writer;
    WrittenFrame frame;
    FrameOptions shown = options;
    if (row.is_refined) {
      RowOptions of_frame = row;
      if (at > 0) of_frame = {true, row.has_step, std::chrono::steady_clock::now()};
      RefinedFrame refined = drawPictures(arguments, output, options, of_frame, scene,
                                          endOfDrawing(options, of_frame.began), drawn.name);
      drawn.refined.push_back(std::move(refined.pictures));
      frame = std::move(refined.frame);
      shown = refined.options;
    }
    const bool writes = is_first && !(row.is_refined && arguments.progressive);
    if (writes) writer.emplace(drawn.name, output, shown, scene, film ? &*film : nullptr);
    if (!row.is_refined)
      frame = drawFrameOf(scene, strips, writer ? &*writer : nullptr);
    else if (writes)
      writer->add(frame.whole->picture);
    drawn.blocks = frame.blocks;
    std::string empty =
        is_first ? emptyReason(arguments, scene, shown, frame, i, progress) : std::string();
    const Stopwatch watch;
    if (writer) writer->commit();
    drawn.frames.push_back({frame.report, frame.write_seconds + watch.seconds(), std::move(empty)});
    if (series.culls()) drawn.culling.push_back(countsJson(series.counts()));
    progress.add(1);
    if (arguments.debug_view)
      drawn.views = writeDebugViews(drawn.name, *frame.whole, scene, arguments.volume,
                                    scene.volume.places, options.partition);
    if (frame.whole) drawn.picture = std::move(frame.whole->picture);
  };
  for (size_t at = 0; at < to_draw.size() && !drawn.is_cut; ++at) try {
      drawFrame(at);
    } catch (const Interrupted&) {
      if (drawn.frames.empty() || !reportsParts(arguments)) throw;
      drawn.is_cut = true;
    }
  if (film) film->finish();
  return drawn;
}

int run(Arguments& arguments, CLI::App& app, Team* team) {
  const auto began = std::chrono::steady_clock::now();
  std::optional<SavedView> saved;
  if (!arguments.state_file.empty()) {
    saved = applyState(app, arguments.state_file);
    if (saved->film && asksForFilm(arguments)) {
      if (team != nullptr)
        fail("{}: a single process must draw the frames of a path", arguments.state_file);
      refuseLevels(arguments.levels,
                   "frames of a saved path are drawn at the default levels, as in the window");
      return writeFilm(arguments, app, *saved);
    }
  }
  if (arguments.volume.inputs.empty()) throw CLI::RequiredError("volume");
  if (team != nullptr) expectSameCommand(*team, app);
  checkOutput(arguments);
  if (team != nullptr &&
      (arguments.debug_view || arguments.progressive || !arguments.trace_file.empty()))
    fail("{} needs a single process, not {} ranks",
         arguments.debug_view    ? "--debug-view"
         : arguments.progressive ? "--progressive"
                                 : "--trace",
         team->ranks());
  const Outputs outputs = outputsOf(arguments);
  const std::vector<int64_t> to_draw = framesToDraw(arguments, team);
  const bool is_first = team == nullptr || team->isFirst();
  if (team != nullptr) shareMachine(*team, arguments.resources);
  if (to_draw.empty()) {
    sayAllAreThere(arguments, app);
    return 0;
  }
  arguments.look.whole_series = isSeries(arguments);
  arguments.frame.cut = cutOf(arguments, team);
  checkLastStep(arguments);
  const Room room = arguments.annotate ? annotationRoom(arguments.frame.size) : Room{};
  FittedScene fitted = openFitted(arguments, saved, outputs, team, room);
  const PictureOutput output = outputOf(arguments);
  nlohmann::json earlier_pictures = nlohmann::json::array();
  // A time limit leaves no time for a pass over all voxels.
  if (fitted.scene->volume.sample && !arguments.frame.time_limit_s) {
    earlier_pictures = drawSample(arguments, app, output, fitted, began);
    fitted = {};
    fitted = openFitted(arguments, saved, outputs, team, room, FinestLevel::kMayWait);
  }
  Scene& scene = *fitted.scene;
  if (scene.share && arguments.frame.cut)
    arguments.frame.cut->coarsest = scene.share->dealing().coarsest_level;
  const std::vector<Camera>& cameras = fitted.cameras;
  if (is_first)
    for (const std::string& warning : scene.look.warnings) printWarning(warning);
  if (scene.volume.stand_in && !arguments.resources.quiet) printWarning(scene.volume.standInNote());
  if (team != nullptr) expectSameScene(*team, scene, cameras, arguments.frame);
  const FrameOptions options = frameOptions(arguments, app, cameras.front(), output, scene);
  requireWholePicture(arguments, scene);

  const nlohmann::json earlier = earlierReport(arguments);
  // The series comes before the trace, since culling opens the session anew.
  Series series(scene, arguments.culling, arguments.resources, options);
  chooseCulling(arguments, to_draw, cameras, options, scene, series);
  std::unique_ptr<TraceWriter> trace;
  if (!arguments.trace_file.empty()) {
    trace = makeTraceWriter(arguments.trace_file, traceFormatOf(arguments.trace_file),
                            static_cast<uint64_t>(scene.session->page().pageBytes()));
    scene.session->recordTo(trace.get());
  }
  const RowOptions row{isRefined(arguments, scene), app.count("--step") > 0, began,
                       std::move(earlier_pictures)};
  const Drawn drawn =
      drawAll(arguments, to_draw, cameras, output, options, row, scene, series, is_first);
  if (drawn.is_cut) {
    if (team == nullptr) {
      nlohmann::json report = reportOf(arguments, app, to_draw, drawn, scene);
      addEarlierFrames(arguments, earlier, report);
      writeReportOf(arguments, report, drawn, scene, true);
    }
    throw Interrupted();
  }
  if (trace) {
    trace->finish();
    scene.session->recordTo(nullptr);
  }
  nlohmann::json report;
  if (wantsReport(arguments)) {
    report = reportOf(arguments, app, to_draw, drawn, scene);
    if (series.choice()) report["culling_choice"] = choiceJson(*series.choice());
    addEarlierFrames(arguments, earlier, report);
  }
  if (scene.share && wantsReport(arguments)) gatherReport(*team, *scene.share, report);
  if (!is_first) return 0;
  warnOfEmptyPictures(arguments, to_draw, drawn);
  std::optional<Verification> verified;
  if (arguments.verify) {
    const auto at = static_cast<size_t>(arguments.times ? 0 : to_draw.back());
    FrameOptions last = options;
    last.camera = cameraOf(cameras, to_draw.back());
    verified = verify(
        scene,
        {arguments.volume, arguments.resources, fitted.asked, at, arguments.fit, room,
         arguments.look.this_step, timeOf(arguments, to_draw.back()), app.count("--step") > 0},
        last, drawn.picture);
    report["verify"] = {{"max_difference", verified->max_difference},
                        {"mean_difference", verified->mean_difference},
                        {"differing_pixels", verified->differing_pixels},
                        {"unchecked", verified->unchecked}};
  }
  if (!arguments.report_file.empty())
    writeReportOf(arguments, report, drawn, scene, team == nullptr);
  if (arguments.json) {
    sayJson(report);
  } else if (!arguments.resources.quiet) {
    printDrawn(arguments, scene, series, drawn, verified);
  }
  return 0;
}

}  // namespace

Command addRender(CLI::App& program) {
  auto arguments = std::make_shared<Arguments>();
  CLI::App* app = program.add_subcommand(
      "render",
      "Draws a volume into PNG or EXR pictures\n\n"
      "  sluice render bonsai.nii.gz -o bonsai.png --threshold 40 --azimuth 30");
  addVolumeOptions(*app, arguments->volume, &arguments->times, false);
  const OptionGroup output(*app, kOutputHeading);
  output
      .text("-o,--output", "FILE", arguments->output,
            "Picture: .png, or .exr with depth; #### or %04d becomes the number of the frame or "
            "time step. Film: .mp4, encoded by ffmpeg")
      ->required();
  const OptionGroup film(*app, "Film");
  addFramesOption(film, arguments->frames, "Pictures of a full turn, or along the path");
  film.text("--path", "FILE", arguments->path_file,
            "Key frames of the camera, JSON: for --frames pictures, or along a range of --time");
  film.number("--rate", "FPS", arguments->frames_per_second, {0, 1000, true},
              "Frames per second of an .mp4 file");
  OptionGroup(*app, "View")
      .text("--state", "FILE", arguments->state_file,
            "Draws a view saved by sluice view, and its volume; further options replace its own. "
            "With -o frame_%04d.png, draws the frames of the saved path");
  output.flag("--annotate", arguments->annotate,
              "PNG: draws orientation axes, a scale bar and a colour bar");
  output.parsed(
      "--aov", "LIST", "depth, opacity, both with a comma between, or none", parseAovs,
      [arguments](const Aovs& aovs) { arguments->aovs = aovs; },
      "EXR: channels in addition to colour and alpha: depth, opacity or none", "depth");
  output.text("--trace", "FILE", arguments->trace_file,
              "Records the texture cache's requests: text (.txt), .csv, .oracleGeneral, .din, "
              "otherwise compact binary");
  addReportOption(output, arguments->report_file);
  output.flag("--debug-view", arguments->debug_view,
              "Also writes the boxes drawn between updates of the opacity map, the maps, and the "
              "growing boxes of the middle slice");
  output.flag("--verify", arguments->verify,
              "Also draws the picture without acceleration, and prints the largest and mean "
              "difference and what it cannot check");
  output.flag(
      "--progressive", arguments->progressive,
      "Volumes with levels of resolution, and large ones: writes a coarse picture first and "
      "replaces it by better ones; #### or %04d in -o numbers them");
  addForceOption(output, arguments->force);
  addQuietOption(output, arguments->resources.quiet);
  addJsonOption(output, arguments->json, "Prints the report instead of a summary");
  arguments->asked = addPictureOptions(*app, arguments->look, arguments->frame, arguments->fit);
  addCullingOptions(*app, arguments->culling, true);
  OptionGroup(*app, kSeriesHeading)
      .flag("--continue", arguments->resume, "Draws only the pictures that do not exist yet");
  addLevelOptions(*app, arguments->levels, arguments->resources);
  addResourceOptions(*app, arguments->resources);
  return
      [arguments, app] { return onRanks([&](Team* team) { return run(*arguments, *app, team); }); };
}

}  // namespace sluice
