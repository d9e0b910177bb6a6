#include "tools/outputs/render_report.h"

#include <CLI/CLI.hpp>

#include <map>
#include <set>
#include <string>
#include <system_error>
#include <utility>

#include "src/base/files/text_file.h"
#include "src/base/threads/clock.h"
#include "src/base/values/bytes.h"
#include "src/cpu/kernels/kernel_values.h"
#include "src/library/opening/thick_source.h"
#include "src/options/option_table.h"
#include "tools/command_line/console.h"
#include "tools/command_line/interrupt.h"
#include "tools/outputs/cut_report.h"
#include "tools/pages/report_file.h"
#include "tools/scene/empty_pictures.h"
#include "tools/scene/ranks.h"

namespace sluice {
namespace {

// Whether the volume decides the up direction of the picture.
bool leavesUpToVolume(const RenderArguments& arguments) {
  const Camera& camera = arguments.frame.camera;
  return !camera.up && !camera.look_at && camera.view != ViewName::kPlain &&
         arguments.path_file.empty() && arguments.state_file.empty();
}

// "shows channel 0 (DAPI), channel 1 (GFP)".
std::string channelsLine(const Scene& scene) {
  std::string line = "shows";
  for (const Layer* layer : scene.layers())
    line += (layer == &scene ? " " : ", ") + layer->volume.channel.title();
  return line;
}

// The values that were chosen, in place of "auto" and of defaults that stand for a choice.
void addChosen(nlohmann::json& options, const RenderArguments& arguments, const Drawn& drawn,
               const Scene& scene) {
  if (stepCounts(arguments.frame.mode, drawn.step_vox))
    options["step"] = fmt::format("{}", drawn.step_vox);
  options["threads"] = fmt::format("{}", scene.pool.threads());
  const std::string device = nameOf(*scene.device);
  options["device"] = device;
  if (device == "gl") options["gl"] = scene.device->backend();
  if (device == "cpu") options["simd"] = kernelsOf(arguments.resources.device.simd).name;
}

}  // namespace

nlohmann::json reportOf(const RenderArguments& arguments, const CLI::App& app,
                        const std::vector<int64_t>& to_draw, const Drawn& drawn,
                        const Scene& scene) {
  nlohmann::json report = sceneJson(scene, drawn.frames);
  report["command"] = "render";
  report["options"] = optionsJson(app);
  addChosen(report["options"], arguments, drawn, scene);
  report["output"] = drawn.name.string();
  for (size_t i = 0; i < drawn.frames.size() && isSeries(arguments); ++i)
    report["frames"][i]["time"] = timeOf(arguments, to_draw[i]);
  for (size_t i = 0; i < drawn.frames.size() && frameCount(arguments) > 1; ++i)
    report["frames"][i]["picture"] = frameName(arguments, to_draw[i]).string();
  for (size_t i = 0; i < drawn.culling.size(); ++i)
    report["frames"][i]["culling"] = drawn.culling[i];
  for (size_t i = 0; i < drawn.refined.size(); ++i)
    report["frames"][i]["pictures"] = refinedJson(drawn.refined[i]);
  return report;
}

nlohmann::json earlierReport(const RenderArguments& arguments) {
  constexpr uint64_t kMostBytes = uint64_t{64} << 20;
  const std::string& file = arguments.report_file;
  std::error_code unknown;
  if (!arguments.resume || file.empty() || isPage(file) ||
      !std::filesystem::is_regular_file(file, unknown))
    return nullptr;
  auto report = nlohmann::json::parse(readTextFile(file, kMostBytes, "a report", interruption()),
                                      nullptr, false);
  return report.is_object() ? report : nlohmann::json();
}

namespace {

// The names of the options that pictures depend on, but for the steps that a run draws. A report
// has the step between slices that was chosen, if none was given.
std::set<std::string> picturesOptions(const CLI::App& app) {
  std::set<std::string> names{"volume", "size", "frames", "path", "state", "annotate", "aov"};
  const auto add = [&](const auto& table) {
    for (const auto& entry : table)
      for (const std::string_view name : optionNames(entry)) names.emplace(name.substr(2));
  };
  add(optionTable());
  add(volumeTable());
  names.insert("this-step");
  names.erase("time");
  if (app.count("--step") == 0) names.erase("step");
  return names;
}

std::string wordsOf(const nlohmann::json& options, const std::string& name) {
  if (!options.contains(name)) return "";
  const nlohmann::json& value = options[name];
  if (value.is_string()) return value.get<std::string>();
  if (!value.is_array()) return value.dump();
  std::string words;
  for (const nlohmann::json& word : value)
    words +=
        (words.empty() ? "" : " ") + (word.is_string() ? word.get<std::string>() : word.dump());
  return words;
}

}  // namespace

void warnOfOtherOptions(const RenderArguments& arguments, const CLI::App& app,
                        const nlohmann::json& earlier) {
  if (!earlier.is_object() || !earlier.contains("options") || !earlier["options"].is_object())
    return;
  const nlohmann::json now = optionsJson(app);
  for (const std::string& name : picturesOptions(app)) {
    const std::string before = wordsOf(earlier["options"], name), given = wordsOf(now, name);
    if (before == given) continue;
    const auto said = [](const std::string& words) {
      return words.empty() ? std::string("nothing") : "'" + words + "'";
    };
    printWarning(fmt::format(
        "{}: the pictures that are there may look otherwise: their run had {} for {}{}, "
        "this one has {}",
        arguments.report_file, said(before), name == "volume" ? "" : "--", name, said(given)));
    return;
  }
}

void addEarlierFrames(const RenderArguments& arguments, const nlohmann::json& earlier,
                      nlohmann::json& report) {
  if (!arguments.resume) return;
  std::map<std::string, nlohmann::json> known;  // by the picture's name in its folder
  // This run comes last: its frames take the place of earlier ones of the same name.
  for (const nlohmann::json* run : {&earlier, &std::as_const(report)})
    if (run->is_object() && run->contains("frames") && (*run)["frames"].is_array())
      for (const nlohmann::json& frame : (*run)["frames"])
        if (frame.is_object() && frame.contains("picture") && frame["picture"].is_string())
          known[std::filesystem::path(frame["picture"].get<std::string>()).filename()] = frame;
  nlohmann::json frames = nlohmann::json::array(), not_measured = frames;
  for (int64_t i = 0; i < frameCount(arguments); ++i) {
    const std::filesystem::path picture = frameName(arguments, i);
    const auto found = known.find(picture.filename());
    if (found != known.end())
      frames.push_back(found->second);
    else
      not_measured.push_back(picture.string());
  }
  report["frames"] = std::move(frames);
  if (!not_measured.empty()) report["frames_not_measured"] = std::move(not_measured);
}

void writeReportOf(const RenderArguments& arguments, const nlohmann::json& report,
                   const Drawn& drawn, const Scene& scene, bool maps) {
  PagePictures pictures;
  if (isPage(arguments.report_file)) {
    // A picture that was drawn in strips would make the page as large as its file.
    if (drawn.picture.width > 0) addPicture(pictures, drawn.name, drawn.picture);
    if (maps && !isCoarser(*drawn.blocks))
      addBlocks(pictures, scene.volume.step().ranges->layout.grid, *drawn.blocks);
  }
  writeReport(arguments.report_file, report, pictures);
}

void warnOfEmptyPictures(const RenderArguments& arguments, const std::vector<int64_t>& to_draw,
                         const Drawn& drawn) {
  if (arguments.resources.quiet) return;
  EmptyPictures empty;
  for (size_t i = 0; i < drawn.frames.size(); ++i)
    empty.add(frameName(arguments, to_draw[i]).string(), drawn.frames[i].empty);
  empty.warn();
  // Once: of a turn, all pictures are without the same channels.
  for (size_t i = 0; i < drawn.frames.size(); ++i)
    if (!drawn.frames[i].empty_layers.empty()) {
      printWarning(fmt::format("{}: {}", frameName(arguments, to_draw[i]).string(),
                               drawn.frames[i].empty_layers));
      break;
    }
}

void sayAllAreThere(const RenderArguments& arguments, const CLI::App& app) {
  const nlohmann::json earlier = earlierReport(arguments);
  if (arguments.json)
    sayJson({{"command", "render"},
             {"options", optionsJson(app)},
             {"output", arguments.output},
             {"frames", earlier.contains("frames") ? earlier["frames"] : nlohmann::json::array()}});
  else if (!arguments.resources.quiet)
    say("all {} pictures are there\n", frameCount(arguments));
}

void printDrawn(const RenderArguments& arguments, const Scene& scene, const Series& series,
                const Drawn& drawn, const std::optional<Verification>& verified) {
  const std::vector<RenderedFrame>& frames = drawn.frames;
  const FrameReport& report = frames.back().report;
  const VolumeLayout& layout = storedLayout(*scene.volume.source);
  say("{} x {} x {} {}, {}: {} white, {} grey, {} black blocks{}\n", layout.dims.x, layout.dims.y,
      layout.dims.z, name(layout.type), scene.look.transfer.name, report.blocks.white,
      report.blocks.grey, report.blocks.black, scene.share ? " of rank 0" : "");
  say("look: {}\n", scene.drawn_look);
  if (!scene.more.empty()) say("{}\n", channelsLine(scene));
  if (isCoarser(*drawn.blocks)) say("{}\n", cutLine(*report.cut));
  if (!drawn.refined.empty())
    say("{} picture{}, the last after {:.2f} s: {}\n", drawn.refined.back().size(),
        drawn.refined.back().size() == 1 ? "" : "s", drawn.refined.back().back().seconds,
        refinedLine(*report.cut));
  say("{} frame{} of {:.3f} s on {} ({}), read {}, peak memory {} of its own, {} resident\n",
      frames.size(), frames.size() == 1 ? "" : "s, the last", report.seconds,
      scene.device->backend(), scene.device->renderer(), formatBytes(scene.storedBytesRead()),
      formatBytes(scene.peak_anonymous_bytes), formatBytes(peakResidentBytes()));
  const std::string upright = uprightHint(layout);
  if (!upright.empty() && leavesUpToVolume(arguments)) say("up: {}\n", upright);
  if (series.choice()) say("culling auto: {}\n", series.choice()->line);
  if (series.culls()) {
    const CullingCounts& counts = series.counts();
    say("culling: {} of {} blocks visible, estimated in {:.2f} ms from {} of {} pixels\n",
        counts.blocks_visible, counts.blocks_nonempty, 1e3 * counts.estimate_seconds,
        counts.pixels_checked, counts.pixels);
  }
  if (scene.share) {
    const CompositingReport& parts = scene.composited;
    say("{} ranks; rank 0 sent {} and received {} of parts of the last picture\n",
        scene.share->team().ranks(), formatBytes(parts.sent_bytes),
        formatBytes(parts.received_bytes));
  }
  if (report.missing_share > 0)
    say("incomplete: {:.1f} % of the visible cells were not read within --time-limit\n",
        100 * report.missing_share);
  if (verified)
    say("against the plain picture{}: largest difference {:.3f}/255, mean {:.5f}/255, {} pixels "
        "above 1/255; not checked: {}\n",
        isCoarser(*drawn.blocks) ? " of level 0" : "", verified->max_difference,
        verified->mean_difference, verified->differing_pixels,
        fmt::join(verified->unchecked, "; "));
  say("{}\n", drawn.name.string());
  for (const std::filesystem::path& view : drawn.views) say("{}\n", view.string());
}

}  // namespace sluice
