#include "tools/commands/render_checks.h"

#include <algorithm>
#include <array>
#include <filesystem>

#include "io/pictures/finished_picture.h"
#include "io/web/address.h"
#include "src/annotate/annotate.h"
#include "src/base/error.h"
#include "src/base/values/bytes.h"
#include "src/library/drawing/cost/picture_memory.h"
#include "src/library/drawing/scene/refined_frame.h"
#include "src/library/opening/channel_looks.h"
#include "src/library/opening/shown_channels.h"
#include "src/options/option_rules.h"
#include "src/view/state/view_path.h"
#include "tools/command_line/console.h"
#include "tools/command_line/interrupt.h"
#include "tools/command_line/usage.h"
#include "tools/commands/debug_views.h"
#include "tools/options/picture_checks.h"
#include "tools/options/shared_options.h"
#include "tools/options/view_arguments.h"
#include "tools/pages/report_file.h"
#include "tools/scene/series.h"

namespace sluice {
namespace {

using Arguments = RenderArguments;

bool isExr(const Arguments& arguments) {
  return pictureKind(arguments.output) == PictureKind::kExr;
}

// The frames that are still to be drawn.
std::vector<int64_t> framesToDraw(const Arguments& arguments) {
  std::vector<int64_t> frames;
  for (int64_t i = 0; i < frameCount(arguments); ++i)
    if (!arguments.resume || !isDrawn(arguments, frameName(arguments, i))) frames.push_back(i);
  return frames;
}

PictureArguments pictureOf(const Arguments& arguments) {
  return {arguments.look, arguments.frame, arguments.culling, arguments.resources};
}

// Whether pictures are rows that get better, if the volume has levels.
bool mayRefine(const Arguments& arguments, const Team* team) {
  return asksForRefinement(arguments) && !isSeries(arguments) && team == nullptr;
}

// At most one a level, and one more that the time ends.
constexpr int64_t kMostPictures = 64;

}  // namespace

bool isDrawn(const Arguments& arguments, const std::filesystem::path& path) {
  const auto size = sizeOfWholePicture(path);
  // A picture of another program is left to the check of the outputs, which refuses it.
  if (!size || !mayReplace(path, isExr(arguments) ? FileKind::kExr : FileKind::kPng)) return false;
  const PictureSize& expected = arguments.frame.size;
  if (*size != std::array<int64_t, 2>{expected.width, expected.height})
    fail(
        "{}: {} x {} pixels, expected {} x {}; --continue keeps pictures of the same options, so "
        "remove the others or give another -o",
        path.string(), (*size)[0], (*size)[1], expected.width, expected.height);
  return true;
}

void sayKept(const RenderArguments& arguments, int64_t kept, int64_t count, Comparison comparison) {
  if (kept == 0 || arguments.resources.quiet) return;
  printNotice(
      fmt::format("{}: {} of {} pictures {} there and {} as before, whatever options drew {}{}",
                  arguments.output, kept, count, kept == 1 ? "is" : "are",
                  kept == 1 ? "stays" : "stay", kept == 1 ? "it" : "them",
                  comparison == Comparison::kByReport
                      ? "; with --report in each run, other options have a warning"
                      : ""));
}

bool numbersPictures(const Arguments& arguments) {
  return arguments.progressive && isNumbered(arguments.output) && frameCount(arguments) == 1;
}

Outputs renderOutputs(const Arguments& arguments, const Scene* scene) {
  Outputs outputs(arguments.force);
  outputs.reads(arguments.volume.inputs);
  outputs.reads({arguments.volume.asked.over, arguments.path_file, arguments.state_file});
  outputs.reads(filesOf(arguments.look));
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
  if (arguments.trace_file.empty()) return outputs;
  if (scene == nullptr)
    outputs.writesTrace("--trace", arguments.trace_file);
  else
    for (const std::string& file : scene->tracePaths(arguments.trace_file))
      outputs.writesTrace("--trace", file);
  return outputs;
}

void nameOutput(Arguments& arguments) {
  if (!arguments.output.empty()) return;
  const std::vector<std::string>& inputs = arguments.volume.inputs;
  const std::string& last = inputs.back();
  std::error_code none;
  const bool is_picture = pictureKind(last).has_value() || isFilmName(last);
  if (inputs.size() > 1 && is_picture && !std::filesystem::exists(last, none))
    failUsage("--output is required; to write {}, give -o {}", last, last);
  arguments.output = pictureNameFor(withoutSecrets(inputs.front()));
  const PictureSize& size = arguments.frame.size;
  arguments.annotate =
      arguments.annotate || std::min(size.width, size.height) >= kLeastAnnotatedPixels;
}

void checkOutput(const Arguments& arguments) {
  const auto kind = pictureKind(arguments.output);
  const bool is_film = isFilmName(arguments.output);
  if (!kind && !is_film)
    fail("{}: pictures are written as .png or .exr, films as .mp4", arguments.output);
  if (is_film && frameCount(arguments) < 2)
    failUsage("{}: a film has several frames; give --frames or a range of --time",
              arguments.output);
  if (is_film && arguments.resume)
    failUsage("{}: a film is written in one go; --continue is for pictures", arguments.output);
  if (is_film && arguments.progressive)
    failUsage("{}: a film has one picture a frame; --progressive is for pictures",
              arguments.output);
  if (arguments.progressive && isSeries(arguments))
    failUsage("--progressive takes one time step and no --culling");
  if (!arguments.path_file.empty() && frameCount(arguments) < 2)
    throw CLI::RequiresError("--path", "--frames or a range of --time");
  if (arguments.aovs && kind != PictureKind::kExr)
    failUsage("{}: --aov adds channels to .exr pictures", arguments.output);
  if (arguments.annotate && kind == PictureKind::kExr)
    failUsage("{}: --annotate draws over .png pictures; an .exr holds values", arguments.output);
  checkBasis(arguments.culling);
  const PictureSize& size = arguments.frame.size;
  if (arguments.annotate && std::min(size.width, size.height) < kLeastAnnotatedPixels)
    failUsage("--annotate: a picture of {} x {} pixels has no room for letters; it needs {} x {}",
              size.width, size.height, kLeastAnnotatedPixels, kLeastAnnotatedPixels);
  if (arguments.aovs && arguments.aovs->depth && !traitsOf(arguments.frame.mode).has_colors)
    failUsage("--aov depth needs --mode composite, since depth is weighted by opacity");
  if (arguments.debug_view && frameCount(arguments) > 1)
    failUsage("--debug-view takes one frame, not {}", frameCount(arguments));
  if (arguments.times && arguments.frames > 1)
    failUsage("--frames {} takes one time step, not a range of --time", arguments.frames);
  checkPicture(pictureOf(arguments), viewState(*arguments.asked, arguments.volume, arguments.look));
  // If a saved view says it, it is the file's fault.
  if (arguments.state_file.empty())
    checkPlainOptions(arguments.volume, arguments.look, arguments.frame);
  if (arguments.verify && arguments.culling.culling != Culling::kNone && frameCount(arguments) > 1)
    failUsage("--verify with --culling takes one frame, not {}", frameCount(arguments));
  if (arguments.debug_view && arguments.frame.occlusion == Occlusion::kOff &&
      arguments.frame.partition == Partition::kBlocks)
    failUsage(
        "--debug-view shows the effect of --occlusion and --partition boxes; give one of them");
}

void readPath(Arguments& arguments, const std::set<std::string>& given) {
  const std::string& file = arguments.path_file;
  if (file.empty()) return;
  arguments.path = readCameraPath(file, interruption());
  requireOneForm(*arguments.path, arguments.frame.camera, file);
  if (!hasEyes(*arguments.path)) return;
  for (const auto& [option, other] : optionsApart())
    if (option == "--eye" && given.contains(std::string(other)))
      fail("{}: {} has no effect beside the keys' \"eye\" and \"target\"; leave it out", file,
           other);
}

std::optional<CutOptions> cutOf(const Arguments& arguments, Team* team) {
  const bool refines = mayRefine(arguments, team);
  const bool is_alone = frameCount(arguments) == 1 && !asksForRefinement(arguments);
  std::optional<CutOptions> cut =
      cutOf(pictureOf(arguments), refines, is_alone ? PictureRow::kOne : PictureRow::kMore);
  // All ranks make the same cut, that of the first one's memory, and each holds its share of the
  // blocks.
  if (cut && team != nullptr)
    cut->most_held_bytes = static_cast<uint64_t>(team->ranks()) *
                           std::stoull(team->fromFirst(std::to_string(cut->most_held_bytes)));
  return cut;
}

PictureOutput pictureOutput(const Arguments& arguments) {
  PictureOutput output;
  output.background = arguments.asked->background;
  output.annotate = arguments.annotate;
  if (pictureKind(arguments.output) == PictureKind::kExr)
    output.aovs = arguments.aovs.value_or(Aovs{.depth = traitsOf(arguments.frame.mode).has_colors});
  return output;
}

void checkLastStep(const Arguments& arguments) {
  if (!arguments.times) return;
  VolumeArguments last = arguments.volume;
  last.time = arguments.times->at(arguments.times->count() - 1);
  openChannels(last);
}

std::vector<int64_t> framesToDraw(const Arguments& arguments, Team* team) {
  std::vector<int64_t> frames = framesToDraw(arguments);
  if (team == nullptr) return frames;
  // Rank 0 looks for pictures alone: between two looks at the folder one may appear.
  return nlohmann::json::parse(team->fromFirst(nlohmann::json(frames).dump()))
      .get<std::vector<int64_t>>();
}

bool reportsParts(const Arguments& arguments) {
  return frameCount(arguments) > 1 && !arguments.report_file.empty() &&
         !isPage(arguments.report_file) && !isFilmName(arguments.output);
}

bool isRefined(const Arguments& arguments, const Scene& scene) {
  return asksForRefinement(arguments) && !isSeries(arguments) && scene.share == nullptr &&
         canRefine(scene, arguments.frame);
}

void requireOneChannel(const Arguments& arguments, const Scene& scene) {
  if (arguments.debug_view && !scene.more.empty())
    fail("{}: --debug-view shows one channel, {}", scene.volume.name, scene.notOneChannel());
}

Strips stripsOf(const Arguments& arguments, Team* team) {
  if (arguments.verify || arguments.debug_view) return Strips::kNever;
  return mayRefine(arguments, team) ? Strips::kUnlessRefined : Strips::kMayBe;
}

void requireOnePicture(const Arguments& arguments, const Scene& scene) {
  if ((arguments.verify || arguments.debug_view) && isRefined(arguments, scene))
    failUsage("{} looks at one picture; leave out --time-limit and --progressive",
              arguments.verify ? "--verify" : "--debug-view");
}

}  // namespace sluice
