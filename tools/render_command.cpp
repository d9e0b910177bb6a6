// sluice render: pictures of a volume, as PNG or EXR.
#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <memory>

#include "io/exr_file.h"
#include "io/png_file.h"
#include "src/base/atomic_file.h"
#include "src/base/bytes.h"
#include "src/base/clock.h"
#include "src/base/error.h"
#include "src/classify/transfer_file.h"
#include "src/render/camera_path.h"
#include "tools/commands.h"
#include "tools/debug_views.h"
#include "tools/options.h"
#include "tools/report.h"
#include "tools/trace_files.h"

namespace sluice {
namespace {

struct Arguments {
  VolumeArguments volume;
  LookArguments look;
  FrameOptions frame;
  ResourceArguments resources;
  std::string output;
  std::string report_file;
  std::string path_file;
  std::string trace_file;
  int64_t frames = 1;
  bool verify = false;
  bool debug_view = false;
  bool json = false;
};

struct Verification {
  double max_difference = 0, mean_difference = 0;  // in 1/255
};

// "turn.png" -> "turn_007.png", or where "%03d" says.
std::filesystem::path frameName(const std::string& output, int64_t frame, int64_t frames) {
  const size_t percent = output.find('%');
  if (percent != std::string::npos) {
    const size_t end = output.find('d', percent);
    const std::string width = output.substr(percent + 1, end - percent - 1);
    const bool understood = end != std::string::npos && width.size() <= 3 &&
                            width.find_first_not_of("0123456789") == std::string::npos;
    if (!understood)
      fail("{}: the only pattern understood in -o is %d, as in turn_%03d.png", output);
    const int digits = width.empty() ? 1 : std::stoi(width);
    return output.substr(0, percent) + fmt::format("{:0{}}", frame, digits) +
           output.substr(end + 1);
  }
  if (frames == 1) return output;
  const std::filesystem::path path(output);
  return path.parent_path() /
         fmt::format("{}_{:03}{}", path.stem().string(), frame, path.extension().string());
}

std::string cameraText(const FrameOptions& options) {
  const Camera& c = options.camera;
  std::string text =
      fmt::format("--projection {} --zoom {} --fov {} --size {}x{} --step {}",
                  c.projection == Projection::kOrtho ? "ortho" : "perspective", c.zoom,
                  c.field_of_view_deg, options.size.width, options.size.height, options.step_vox);
  if (!c.look_at)
    return text + fmt::format(" --azimuth {} --elevation {}", c.azimuth_deg, c.elevation_deg);
  const auto& [eye, target, up] = *c.look_at;
  return text + fmt::format(" --eye {},{},{} --target {},{},{} --up {},{},{}", eye.x, eye.y, eye.z,
                            target.x, target.y, target.z, up.x, up.y, up.z);
}

void write(const std::filesystem::path& path, const Picture& picture, const Arguments& arguments,
           const FrameOptions& options, const Scene& scene) {
  const Picture shown =
      arguments.look.has_background ? over(picture, arguments.look.background) : picture;
  if (path.extension() != ".exr") {
    writePng(path, shown);
    return;
  }
  writeExr(path, shown,
           {{"camera", cameraText(options)},
            {"transferFunction", writeTransferFunction(scene.transfer)},
            {"volume", scene.volume.source->identity()},
            {"software", std::string("sluice ") + SLUICE_VERSION}},
           ExrPrecision::kFloat);
}

// Against the plain way: every block loaded and drawn whole.
Verification verify(Scene& scene, FrameOptions options, const Picture& picture) {
  options.algorithm = Algorithm::kConventional;
  options.partition = Partition::kBlocks;
  options.opacity_threshold = 1;
  options.occlusion = Occlusion::kOff;
  options.count_samples = false;
  options.keep_phases = false;
  scene.session->setOptions(options);
  const Picture plain = scene.session->frame().picture;
  Verification result;
  double sum = 0;
  for (size_t i = 0; i < plain.rgba.size(); ++i) {
    const double a = std::clamp(plain.rgba[i], 0.0F, 1.0F),
                 b = std::clamp(picture.rgba[i], 0.0F, 1.0F);
    const double difference = 255 * std::abs(a - b);
    result.max_difference = std::max(result.max_difference, difference);
    sum += difference;
  }
  result.mean_difference = sum / static_cast<double>(plain.rgba.size());
  return result;
}

void checkOutput(const Arguments& arguments) {
  const std::filesystem::path path(arguments.output);
  if (path.extension() != ".png" && path.extension() != ".exr")
    fail("{}: pictures are written as .png or .exr", arguments.output);
  if (arguments.debug_view && arguments.frames > 1)
    fail("--debug-view is of one frame, not of --frames {}", arguments.frames);
  if (arguments.debug_view && arguments.frame.occlusion == Occlusion::kOff &&
      arguments.frame.partition == Partition::kBlocks)
    fail("--debug-view shows what --occlusion and --partition boxes do; give one of them");
  if (arguments.frame.with_depth && arguments.frame.mode != Mode::kComposite)
    SLUICE_CHECK(path.extension() == ".exr");
}

void printHuman(const Scene& scene, const std::vector<RenderedFrame>& frames,
                const std::filesystem::path& last, const std::optional<Verification>& verified) {
  const FrameReport& report = frames.back().report;
  const VolumeLayout& layout = scene.volume.source->layout();
  fmt::print("{} x {} x {} {}, {}: {} white, {} grey, {} black blocks\n", layout.dims.x,
             layout.dims.y, layout.dims.z, name(layout.type), scene.transfer.name, report.white,
             report.grey, report.black);
  fmt::print("{} frame{} of {:.3f} s on {} ({}), read {}, peak memory {}\n", frames.size(),
             frames.size() == 1 ? "" : "s, the last", report.seconds, scene.device->backend(),
             scene.device->renderer(), formatBytes(scene.volume.source->storedBytesRead()),
             formatBytes(peakResidentBytes()));
  if (report.missing_share > 0)
    fmt::print("incomplete: {:.1f} % of what can be seen was not there within --time-limit\n",
               100 * report.missing_share);
  if (!scene.volume.index.note.empty()) fmt::print("{}\n", scene.volume.index.note);
  if (verified)
    fmt::print("against the plain picture: largest difference {:.3f}/255, mean {:.5f}/255\n",
               verified->max_difference, verified->mean_difference);
  fmt::print("{}\n", last.string());
}

int run(const Arguments& arguments, const CLI::App& app) {
  checkOutput(arguments);
  Scene scene(arguments.volume, arguments.look, arguments.resources, arguments.frame.partition);
  std::optional<CameraPath> path;
  if (!arguments.path_file.empty()) path = readCameraPath(arguments.path_file);
  const bool wants_report = !arguments.report_file.empty() || arguments.json;

  std::unique_ptr<TraceWriter> trace;
  if (!arguments.trace_file.empty()) {
    trace = makeTraceWriter(arguments.trace_file, traceFormatOf(arguments.trace_file),
                            static_cast<uint64_t>(scene.session->page().pageBytes()));
    scene.session->recordTo(trace.get());
  }
  std::vector<RenderedFrame> frames;
  std::filesystem::path name;
  std::vector<std::filesystem::path> views;
  Picture picture;
  FrameOptions options = arguments.frame;
  options.count_samples = wants_report;
  options.keep_phases = arguments.debug_view;
  options.with_depth = std::filesystem::path(arguments.output).extension() == ".exr" &&
                       options.mode == Mode::kComposite;
  for (int64_t i = 0; i < arguments.frames; ++i) {
    const double share = static_cast<double>(i) / static_cast<double>(arguments.frames);
    if (path) {
      options.camera = cameraAt(*path, arguments.frame.camera, i, arguments.frames);
    } else {
      options.camera.azimuth_deg = arguments.frame.camera.azimuth_deg + 360 * share;
    }
    scene.session->setOptions(options);
    scene.device->reuse(std::move(picture));
    Frame frame = scene.session->frame();
    picture = std::move(frame.picture);
    name = frameName(arguments.output, i, arguments.frames);
    const Stopwatch watch;
    write(name, picture, arguments, options, scene);
    frames.push_back({frame.report, watch.seconds()});
    if (arguments.debug_view)
      views = writeDebugViews(name, frame, scene, arguments.volume, options.partition);
  }
  if (trace) {
    trace->finish();
    scene.session->recordTo(nullptr);
  }
  nlohmann::json report;
  if (wants_report) {
    report = sceneJson(scene, frames);
    report["command"] = "render";
    report["options"] = optionsJson(app);
    report["output"] = name.string();
  }
  std::optional<Verification> verified;
  if (arguments.verify) {
    verified = verify(scene, options, picture);
    report["verify"] = {{"max_difference", verified->max_difference},
                        {"mean_difference", verified->mean_difference}};
  }
  if (!arguments.report_file.empty()) {
    AtomicFile file(arguments.report_file);
    file.write(report.dump(2) + "\n");
    file.commit();
  }
  if (arguments.json) {
    fmt::print("{}\n", report.dump(2));
  } else {
    printHuman(scene, frames, name, verified);
    for (const std::filesystem::path& view : views) fmt::print("{}\n", view.string());
  }
  return 0;
}

}  // namespace

Command addRender(CLI::App& program) {
  auto arguments = std::make_shared<Arguments>();
  CLI::App* app = program.add_subcommand(
      "render",
      "Draws a volume into PNG or EXR pictures\n\n"
      "  sluice render bonsai.nii.gz -o bonsai.png --threshold 40 --azimuth 30 --shade");
  addVolumeOptions(*app, arguments->volume);
  app->add_option("-o,--output", arguments->output,
                  "Picture: .png, or .exr with depth; %03d takes the frame")
      ->required()
      ->type_name("FILE");
  addLookOptions(*app, arguments->look);
  addViewOptions(*app, arguments->frame);
  CLI::Option* frames =
      app->add_option("--frames", arguments->frames, "Pictures of a full turn, or of the path")
          ->capture_default_str()
          ->check(CLI::PositiveNumber)
          ->type_name("N");
  app->add_option("--path", arguments->path_file, "Key frames of the camera, JSON")
      ->type_name("FILE")
      ->needs(frames);
  addResourceOptions(*app, arguments->resources);
  app->add_option("--trace", arguments->trace_file,
                  "Records the texture cache's requests: text (.txt), .csv, .oracleGeneral, .din, "
                  "otherwise compact binary")
      ->type_name("FILE");
  app->add_option("--report", arguments->report_file, "What it took, as JSON")->type_name("FILE");
  app->add_flag("--debug-view", arguments->debug_view,
                "Also writes what was drawn between updates of the opacity map, the maps, and the "
                "growing boxes of the middle slice");
  app->add_flag("--verify", arguments->verify,
                "Draws the plain way too and prints the largest and mean difference");
  app->add_flag("--json", arguments->json, "Prints the report instead of a summary");
  return [arguments, app] { return run(*arguments, *app); };
}

}  // namespace sluice
