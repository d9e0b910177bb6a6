// sluice render: pictures of a volume, as PNG or EXR.
#include <algorithm>
#include <chrono>
#include <memory>
#include <set>
#include <string>

#include "src/annotate/annotate.h"
#include "src/base/error.h"
#include "src/base/field_names.h"
#include "src/library/drawing/scene/channel_shares.h"
#include "src/library/drawing/scene/picture_facts.h"
#include "tools/command_line/console.h"
#include "tools/commands/commands.h"
#include "tools/commands/render_checks.h"
#include "tools/commands/render_frames.h"
#include "tools/commands/verification.h"
#include "tools/options/shared_options.h"
#include "tools/options/view_arguments.h"
#include "tools/options/view_state_option.h"
#include "tools/outputs/film.h"
#include "tools/outputs/film_file.h"
#include "tools/scene/fitted_scene.h"
#include "tools/scene/rank_agreement.h"

namespace sluice {
namespace {

using Arguments = RenderArguments;

// The field of a camera path's keys that an option stands for.
std::string nameInPath(std::string_view option) {
  return option == "--fov" ? "\"fov\"" : std::string(option);
}

// Options that were given for nothing, one line each, and such fields of a camera path.
std::vector<std::string> idleLines(const RenderJob& job, const std::set<std::string>& given) {
  std::vector<std::string> lines;
  const Arguments& arguments = job.arguments;
  const Scene& scene = job.scene;
  PictureFacts facts = pictureFacts(scene, lastOptions(scene, job.options, arguments.end));
  facts.is_cut = arguments.frame.cut.has_value();
  facts.is_culled = arguments.culling.culling != Culling::kNone;
  facts.is_film = isFilmName(arguments.output);
  for (const std::string& line : idleOptions(given, facts))
    lines.push_back(fmt::format("{}: {}", scene.volume.name, line));
  if (!arguments.path) return lines;
  const bool has_fov = std::ranges::any_of(
      arguments.path->keys, [](const CameraKey& key) { return key.field_of_view_deg.has_value(); });
  if (!has_fov) return lines;
  for (const std::string& line : idleOptions({"--fov"}, facts))
    lines.push_back(fmt::format("{}: {}", arguments.path_file, renamed(line, nameInPath)));
  return lines;
}

// The warnings that do not follow from the scene's look or its volumes' notes.
std::vector<std::string> warningsOf(const RenderJob& job, const std::set<std::string>& given,
                                    const std::optional<SavedView>& saved) {
  std::vector<std::string> lines = job.scene.standInNotes();
  if (saved) std::ranges::move(saved->notes(), std::back_inserter(lines));
  if (saved && saved->film && (job.arguments.times || job.arguments.path))
    lines.push_back(fmt::format("{}: the saved path is left out: {} takes its place", saved->name,
                                job.arguments.path ? "--path" : "the range of --time"));
  std::ranges::move(idleLines(job, given), std::back_inserter(lines));
  return lines;
}

nlohmann::json reportOf(const RenderJob& job, const CLI::App& app, const Drawn& drawn) {
  nlohmann::json report = reportOf(job.arguments, app, job.to_draw, drawn, job.scene);
  for (const std::string& line : job.warnings) report["warnings"].push_back(line);
  return report;
}

void requireSingleProcess(const Arguments& arguments, const Team& team) {
  if (!arguments.debug_view && !arguments.progressive && arguments.trace_file.empty()) return;
  fail("{} needs a single process, not {} ranks",
       arguments.debug_view    ? "--debug-view"
       : arguments.progressive ? "--progressive"
                               : "--trace",
       team.ranks());
}

// Records the requests of the scene's frames, if the command asks for a trace.
void startTrace(const Arguments& arguments, Scene& scene) {
  if (arguments.trace_file.empty()) return;
  for (const Layer* layer : scene.layers())
    // A channel's trace has a name of its own, which is known only now.
    renderOutputs(arguments, &scene).check(layer->volume.source->files());
  scene.recordTo(arguments.trace_file);
}

// Keeps the report of the frames that were drawn before a signal, for --continue.
void reportUntilSignal(const RenderJob& job, const CLI::App& app, const Drawn& drawn,
                       const nlohmann::json& earlier) {
  nlohmann::json report = reportOf(job, app, drawn);
  addEarlierFrames(job.arguments, earlier, report);
  writeReportOf(job.arguments, report, drawn, job.scene, true);
}

// Verifies the last picture.
Verification verifyLast(const RenderJob& job, const FittedScene& fitted, Room room,
                        const Drawn& drawn) {
  const Arguments& arguments = job.arguments;
  const int64_t frame = job.to_draw.back();
  FrameOptions options = job.options;
  options.camera = cameraOf(job.cameras, frame);
  return verify(job.scene,
                {arguments.volume, arguments.resources, fitted.asked,
                 static_cast<size_t>(arguments.times ? 0 : frame), arguments.fit, room,
                 arguments.look.this_step, timeOf(arguments, frame), job.has_step,
                 drawn.frames.back().layers},
                options, drawn.picture);
}

nlohmann::json verificationJson(const Verification& verified) {
  return {{"max_difference", verified.max_difference},
          {"mean_difference", verified.mean_difference},
          {"differing_pixels", verified.differing_pixels},
          {"unchecked", verified.unchecked}};
}

// Draws the frames of an opened scene, and writes their pictures and the report.
int drawAndReport(const RenderJob& job, const FittedScene& fitted, Room room, const CLI::App& app,
                  Team* team) {
  const Arguments& arguments = job.arguments;
  Scene& scene = job.scene;
  const nlohmann::json earlier = earlierReport(arguments);
  // The series comes before the trace, since culling opens the session anew.
  Series series(scene, arguments.culling, arguments.resources, job.options);
  chooseCulling(job, series);
  startTrace(arguments, scene);
  const Drawn drawn = drawFrames(job, series);
  scene.keepLearntRanges();
  if (drawn.is_cut) {
    if (team == nullptr) reportUntilSignal(job, app, drawn, earlier);
    throw Interrupted();
  }
  scene.recordTo("");
  nlohmann::json report;
  if (wantsReport(arguments)) {
    report = reportOf(job, app, drawn);
    if (series.choice()) report["culling_choice"] = choiceJson(*series.choice());
    addEarlierFrames(arguments, earlier, report);
  }
  // All ranks take part, those as well that print nothing.
  if (scene.share && wantsReport(arguments)) gatherReport(*team, scene.composited, report);
  if (!job.is_first) return 0;
  warnOfEmptyPictures(arguments, job.to_draw, drawn);
  std::optional<Verification> verified;
  if (arguments.verify) {
    verified = verifyLast(job, fitted, room, drawn);
    report["verify"] = verificationJson(*verified);
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

// Opens the scene that the command asks for, and draws it. `team`: null for a single process.
int run(Arguments& arguments, CLI::App& app, Team* team) {
  const auto began = std::chrono::steady_clock::now();
  const std::set<std::string> given = givenOptions(app);
  std::optional<SavedView> saved;
  if (!arguments.state_file.empty())
    saved = applyState(app, arguments.state_file,
                       viewState(*arguments.asked, arguments.volume, arguments.look));
  if (arguments.volume.inputs.empty()) throw CLI::RequiredError("volume");
  nameOutput(arguments);
  if (saved && saved->film && asksForFilm(arguments)) {
    if (team != nullptr)
      fail("{}: a single process must draw the frames of a path", arguments.state_file);
    return writeFilm(arguments, app, *saved, given);
  }
  if (team != nullptr) expectSameCommand(*team, app);
  checkOutput(arguments);
  readPath(arguments, given);
  if (team != nullptr) requireSingleProcess(arguments, *team);
  const Outputs outputs = renderOutputs(arguments);
  const std::vector<int64_t> to_draw = framesToDraw(arguments, team);
  const bool is_first = team == nullptr || team->isFirst();
  if (team != nullptr) shareMachine(*team, arguments.resources);
  const int64_t kept = frameCount(arguments) - static_cast<int64_t>(to_draw.size());
  if (is_first && kept > 0 && !arguments.resources.quiet) {
    const nlohmann::json earlier = earlierReport(arguments);
    if (earlier.is_object())
      warnOfOtherOptions(arguments, app, earlier);
    else
      sayKept(arguments, kept, frameCount(arguments), Comparison::kByReport);
  }
  if (to_draw.empty()) {
    sayAllAreThere(arguments, app);
    return 0;
  }
  arguments.look.whole_series = (isSeries(arguments) && !arguments.look.this_step) ||
                                looksAtAllSteps(arguments.look, arguments.frame, arguments.fit);
  const bool is_unasked = arguments.frame.cut && arguments.frame.cut->is_default;
  arguments.end = is_unasked ? RowEnd::kUnasked : RowEnd::kCut;
  arguments.frame.cut = cutOf(arguments, team);
  arguments.frame.strips = stripsOf(arguments, team);
  checkLastStep(arguments);
  const Room room = arguments.annotate ? annotationRoom(arguments.frame.size) : Room{};
  FittedScene fitted = openFitted(arguments, saved, outputs, team, room);
  arguments.frame.shown_points = fitted.shown_points;
  const PictureOutput output = pictureOutput(arguments);
  const bool has_step = app.count("--step") > 0;
  std::vector<RefinedPicture> earlier_pictures;
  // A time limit leaves no time for a pass over all voxels.
  if (fitted.scene->volume.sample && !arguments.frame.time_limit_s) {
    earlier_pictures = drawSample(
        {arguments, to_draw, fitted.cameras, output, {}, *fitted.scene, is_first, has_step, began});
    // The sample's scene ends first: both together would exceed --memory.
    fitted = {};
    fitted = openFitted(arguments, saved, outputs, team, room, FinestLevel::kMayWait);
    arguments.frame.shown_points = fitted.shown_points;
  }
  Scene& scene = *fitted.scene;
  requireOneChannel(arguments, scene);
  const std::vector<Camera>& cameras = fitted.cameras;
  if (is_first && !arguments.resources.quiet)
    for (const std::string& warning : scene.lookWarnings()) printWarning(warning);
  if (team != nullptr) expectSameScene(*team, scene, cameras, arguments.frame);
  RenderJob job{arguments, to_draw,  cameras,  output, {},
                scene,     is_first, has_step, began,  std::move(earlier_pictures)};
  job.options = drawingOptions(job);
  job.warnings = warningsOf(job, given, saved);
  if (isFilmName(arguments.output))
    if (std::string note = filmSizeNote(arguments.output, arguments.frame.size); !note.empty())
      job.warnings.push_back(std::move(note));
  if (is_first && !arguments.resources.quiet)
    for (const std::string& line : job.warnings) printWarning(line);
  requireOnePicture(arguments, scene);
  return drawAndReport(job, fitted, room, app, team);
}

}  // namespace

Command addRender(CLI::App& program) {
  auto arguments = std::make_shared<Arguments>();
  CLI::App* app = program.add_subcommand(
      "render",
      "Draws a volume into PNG or EXR pictures\n\n"
      "  sluice render bonsai.nii.gz -o bonsai.png --threshold 40 --azimuth 30");
  addVolumeOptions(*app, arguments->volume, &arguments->times, false);
  addOverOption(*app, arguments->volume);
  const OptionGroup output(*app, kOutputHeading);
  output.text("-o,--output", "FILE", arguments->output,
              "Picture: .png, or .exr with depth; #### or %04d becomes the number of the frame or "
              "time step. Film: .mp4, encoded by ffmpeg. Without it: NAME.png in the current "
              "folder, after the volume, with --annotate");
  const OptionGroup film(*app, "Film");
  addFramesOption(film, arguments->frames,
                  "Pictures of a full turn, or along the path of --path or --state");
  film.text("--path", "FILE", arguments->path_file,
            "Key frames of the camera, JSON: for --frames pictures, or along a range of --time");
  film.rare().number("--rate", "FPS", arguments->frames_per_second, {0, 1000, true},
                     "Frames per second of an .mp4 file");
  OptionGroup(*app, "View")
      .text("--state", "FILE", arguments->state_file,
            "Draws a view saved by sluice view, and its volume; further options replace its own. "
            "With -o frame_%04d.png or --frames, draws frames of the saved path");
  output.flag("--annotate", arguments->annotate,
              "PNG: draws orientation axes, a scale bar and a colour bar");
  output.rare().parsed(
      "--aov", "LIST", "depth, opacity, both with a comma between, or none", parseAovs,
      [arguments](const Aovs& aovs) { arguments->aovs = aovs; },
      "EXR: channels in addition to colour and alpha: depth, opacity or none", "depth");
  output.rare().text(
      "--trace", "FILE", arguments->trace_file,
      "Records the texture cache's requests: text (.txt), .csv, .oracleGeneral, .din, "
      "otherwise compact binary; of several channels a file each, as t_0.txt for t.txt");
  addReportOption(output, arguments->report_file);
  output.rare().flag(
      "--debug-view", arguments->debug_view,
      "--occlusion, --partition boxes: also writes the boxes drawn between updates of the "
      "opacity map, the maps, and the growing boxes of the middle slice");
  output.rare().flag("--verify", arguments->verify,
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
  addFrameOptions(*app, arguments->asked, arguments->frame);
  addTimeLimit(*app, arguments->asked, arguments->frame);
  addCullingOptions(*app, arguments->culling, true);
  OptionGroup(*app, kSeriesHeading)
      .rare()
      .flag(
          "--continue", arguments->resume,
          "Draws only the pictures that do not exist yet or are not whole; give the same options");
  addLevelOptions(*app, arguments->asked, arguments->frame, arguments->resources);
  addResourceOptions(*app, arguments->resources);
  return
      [arguments, app] { return onRanks([&](Team* team) { return run(*arguments, *app, team); }); };
}

}  // namespace sluice
