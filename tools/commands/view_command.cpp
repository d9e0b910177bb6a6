// sluice view: a volume in a window.
#include <filesystem>
#include <memory>
#include <system_error>
#include <utility>

#include "io/formats.h"
#include "src/base/error.h"
#include "src/classify/transfer/color_maps.h"
#if SLUICE_HAS_GL
#include "src/gl/contexts/backends.h"
#endif
#include "src/options/option_rules.h"
#include "src/view/drawing/drawing_thread.h"
#include "src/view/drawing/window_module.h"
#include "src/view/state/files/settings.h"
#include "src/view/state/files/state_file.h"
#include "tools/command_line/console.h"
#include "tools/command_line/environment.h"
#include "tools/command_line/interrupt.h"
#include "tools/command_line/outputs.h"
#include "tools/command_line/usage.h"
#include "tools/commands/commands.h"
#include "tools/options/shared_options.h"
#include "tools/options/view_arguments.h"
#include "tools/outputs/picture_output.h"

namespace sluice {
namespace {

struct ViewArguments {
  VolumeArguments volume;
  LookArguments look;
  FrameOptions frame;
  FitChoice fit;
  AskedView asked;
  ResourceArguments resources;
  std::string state_file, trace_file, log_file;
};

// A view or a transfer function, if not a picture: the window names both as it is told to.
FileKind kindOf(const std::string& path) {
  if (const auto picture = pictureKind(path))
    return *picture == PictureKind::kExr ? FileKind::kExr : FileKind::kPng;
  return mayReplace(path, FileKind::kView) ? FileKind::kView : FileKind::kTransferFunction;
}

// Checks the files that the window saves, as other commands check theirs before they write.
void checkSaved(const std::vector<std::string>& reads, const std::vector<std::string>& writes) {
  Outputs outputs;
  outputs.reads(reads);
  const std::string settings = windowSettings().string();  // the window's own
  for (const std::string& path : writes)
    if (path != settings) outputs.writes("saving", path, kindOf(path));
  outputs.check();
}

DrawingOptions drawingOptions(const ViewArguments& arguments) {
  DrawingOptions options;
  options.renderer = rendererOptions(arguments.resources);
  options.state = viewState(*arguments.asked, arguments.volume, arguments.look);
  options.trace_file = arguments.trace_file;
  options.check_outputs = checkSaved;
  options.web_of = [web = arguments.volume.open.web](const std::vector<std::string>& paths) {
    return webOf(web, paths);
  };
  const IndexWish wish = indexWish(arguments.resources.index_dir);
  if (!wish.disabled) options.index_folder = wish.folder.string();
  return options;
}

// The file of the window's settings; empty if there is no folder for it.
std::string settingsFile() {
  const std::filesystem::path file = windowSettings();
  if (file.empty()) return {};
  std::error_code failed;
  std::filesystem::create_directories(file.parent_path(), failed);
  return failed ? "" : file.string();
}

int run(const ViewArguments& arguments, const CLI::App& app) {
  Outputs outputs;
  outputs.reads(arguments.volume.inputs);
  outputs.reads({arguments.look.transfer_file, arguments.look.label_table, arguments.state_file});
  outputs.writesTrace("--trace", arguments.trace_file);
  outputs.writes("--log", arguments.log_file, FileKind::kLog);
  outputs.check();
  RunWindow* const run_window = openWindowModule();
  DrawingOptions options = drawingOptions(arguments);
  if (const auto conflict = conflictIn(options.state)) failUsage("{}", *conflict);
  WindowRequest request;
  request.volume = viewedVolume(arguments.volume, arguments.resources, options.index_folder,
                                !arguments.look.this_step);
  if (!arguments.state_file.empty()) {
    StateFile file = readState(arguments.state_file, interruption());
    // A volume that is named on the command line comes before the saved one.
    if (request.volume.paths.empty() && file.volume) request.volume = *file.volume;
    options.state = std::move(file.state);
    options.state_file = arguments.state_file;
    options.path = std::move(file.path);
  }
  auto drawing = std::make_unique<DrawingThread>(options);
  request.desk = drawing.get();
  const DeviceArguments& device = arguments.resources.device;
  if (device.device != DeviceChoice::kCpu && device.gl == GlChoice::kAuto)
    request.lend = [&drawing](std::shared_ptr<const ScreenContext> screen) {
      drawing->lend(std::move(screen));
    };
  request.lends_software = device.device == DeviceChoice::kGl;
#if SLUICE_HAS_GL
  if (request.lends_software) prepareGlEnvironment();  // the window's driver reads it first
#endif
  request.end_desk = [&drawing] {
    const std::unique_ptr<DrawingThread> ending = std::move(drawing);
    return ending != nullptr ? ending->end() : std::vector<std::string>();
  };
  for (const std::string_view name : colorMapNames()) request.color_maps.emplace_back(name);
  request.volume_endings = volumeEndings();
  if (app.count("--size") > 0) {
    request.pane_width = arguments.frame.size.width;
    request.pane_height = arguments.frame.size.height;
  }
  request.settings_file = settingsFile();
  if (!request.settings_file.empty()) request.settings = readSettings(request.settings_file);
  request.log_file = arguments.log_file;
  request.tell_news = [&drawing](std::function<void()> on_news) {
    if (drawing != nullptr) drawing->tellNews(std::move(on_news));
  };
  request.is_asked_to_end = [stop = interruption()] { return stop.isStopRequested(); };
  request.say = [](const std::string& line) { say("{}\n", line); };
  run_window(request);
  // The window closed in good order, but the exit status has to name the signal.
  interruption().throwIfStopped();
  return kDone;
}

}  // namespace

Command addView(CLI::App& program) {
  auto arguments = std::make_shared<ViewArguments>();
  CLI::App* app = program.add_subcommand("view",
                                         "Shows a volume in a window; ? there lists the keys\n\n"
                                         "  sluice view bonsai.nii.gz --threshold 40");
  addVolumeOptions(*app, arguments->volume, nullptr, false);
  addOverOption(*app, arguments->volume);
  const OptionGroup output(*app, kOutputHeading);
  output.text("--state", "FILE", arguments->state_file, "Opens a saved view and its volume");
  output.rare().text("--trace", "FILE", arguments->trace_file,
                     "Records the texture cache's requests, for sluice simulate");
  output.text("--log", "FILE", arguments->log_file,
              "Writes events, a JSON object per line: places of controls, pictures, measurements");
  arguments->asked = addPictureOptions(*app, arguments->look, arguments->frame, arguments->fit);
  const OptionGroup machine(*app, kMachineHeading);
  addMemoryOption(machine, arguments->resources);
  addThreadsOption(machine, arguments->resources.threads);
  addDeviceOptions(machine, arguments->resources.device);
  addIndexDirOption(machine, arguments->resources.index_dir);
  takeIdleOptions(*app);
  return [arguments, app] { return run(*arguments, *app); };
}

}  // namespace sluice
