// sluice bench limit and bench render: this machine's sampling rate, and the frames of a turn.
#include <algorithm>

#include "src/base/threads/clock.h"
#include "src/render/camera/sampling_limit.h"
#include "tools/bench/bench.h"
#include "tools/command_line/console.h"
#include "tools/outputs/report.h"
#include "tools/scene/open_scene.h"

namespace sluice {
namespace {

using nlohmann::json;

// Full-screen slices of one resident texture: `samples_per_second`. Throws Error.
json benchLimit(const BenchArguments& bench) {
  Workers pool(bench.resources.threads);
  const auto device = makeDevice(bench.resources.device, pool);
  const SamplingRate limit = samplingLimit(*device, bench.frame.size, bench.frames);
  return {{"samples_per_second", limit.samples_per_second},
          {"samples_per_processor_second", limit.samples_per_processor_second},
          {"device", nameOf(*device)},
          {"backend", device->backend()},
          {"renderer", device->renderer()}};
}

void printLimit(const json& report) {
  say("{:.1f} million samples a second ({}, {})\n",
      report["samples_per_second"].get<double>() / 1e6, report["backend"].get<std::string>(),
      report["renderer"].get<std::string>());
}

// The frames of a turn, warm: their seconds, the processor's, their samples, and their share of the
// sampling rate, which is measured too; the last frame's report. Throws Error.
json benchFrames(const BenchArguments& bench) {
  Scene scene = openScene(bench.volume, bench.look, bench.resources, bench.frame);
  warnOfIdle(bench, scene, bench.frame);
  FrameOptions options = bench.frame;
  const auto turnTo = [&](int frame) {
    options.camera.azimuth_deg =
        bench.frame.camera.azimuth_deg + 360.0 * std::max(0, frame) / bench.frames;
    scene.session->setOptions(options);
  };
  std::vector<double> seconds;
  // The time of all threads: other work on the machine changes it little.
  double processor_seconds = 0;
  for (int i = -kWarmFrames; i < bench.frames; ++i) {
    turnTo(i);
    const double before = processorSeconds();
    const double frame_seconds = scene.session->frameReport().seconds;
    if (i < 0) continue;
    processor_seconds += (processorSeconds() - before) / bench.frames;
    seconds.push_back(frame_seconds);
  }
  // Counting takes time: the same frames again.
  double drawn = 0, taken = 0, object = 0;
  RenderedFrame last;
  options.count_samples = options.counts_leaps = true;
  for (int i = 0; i < bench.frames; ++i) {
    turnTo(i);
    last.report = scene.session->frameReport();
    drawn += static_cast<double>(last.report.samples_drawn) / bench.frames;
    taken += static_cast<double>(last.report.samples_taken) / bench.frames;
    object += static_cast<double>(last.report.samples_object) / bench.frames;
  }
  // Measured in the same process and moment, since machines drift.
  const SamplingRate limit = samplingLimit(*scene.device, options.size, bench.frames);
  const auto [least, most] = std::minmax_element(seconds.begin(), seconds.end());
  const double middle = median(seconds);
  // Cells outside the object boxes are drawn in vain; inside them only the samples taken count.
  const double samples = std::min(taken, object);
  json report = sceneJson(scene, {last});
  report.update({{"frame_seconds", {{"median", middle}, {"min", *least}, {"max", *most}}},
                 {"frame_processor_seconds", processor_seconds},
                 {"frames_measured", bench.frames},
                 {"samples_drawn", drawn},
                 {"samples_taken", taken},
                 {"samples_object", object},
                 {"limit_samples_per_second", limit.samples_per_second},
                 {"share_of_limit", samples / middle / limit.samples_per_second},
                 {"share_of_processor_limit",
                  samples / processor_seconds / limit.samples_per_processor_second}});
  return report;
}

void printFrames(const json& report) {
  const auto number = [&report](const char* at) {
    return report[json::json_pointer(at)].get<double>();
  };
  say("frame {:.4f} s (least {:.4f}, most {:.4f}), warm, {} frames of a turn\n",
      number("/frame_seconds/median"), number("/frame_seconds/min"), number("/frame_seconds/max"),
      report["frames_measured"].get<int>());
  say("{:.4f} s of the processor's time a frame, all threads\n",
      number("/frame_processor_seconds"));
  say("{:.2f} million samples drawn, {:.2f} million taken, {:.2f} million inside object boxes\n",
      number("/samples_drawn") / 1e6, number("/samples_taken") / 1e6,
      number("/samples_object") / 1e6);
  say("{:.2f} of this machine's {:.1f} million samples a second; {:.2f} of its rate by the "
      "processor's time\n",
      number("/share_of_limit"), number("/limit_samples_per_second") / 1e6,
      number("/share_of_processor_limit"));
}

}  // namespace

Bench addLimitBench(CLI::App& app) {
  auto bench = std::make_shared<BenchArguments>();
  CLI::App* limit = app.add_subcommand(
      "limit",
      "Measures this machine's sampling rate with full-screen slices of one resident texture");
  const OptionGroup machine(*limit, kMachineHeading);
  addThreadsOption(machine, bench->resources.threads);
  addDeviceOptions(machine, bench->resources.device);
  addFramesOption(OptionGroup(*limit, kOutputHeading), bench->frames, kFrames);
  return {limit, [bench](const Show& show) { return show(benchLimit(*bench), printLimit); }};
}

Bench addRenderBench(CLI::App& app) {
  auto bench = std::make_shared<BenchArguments>();
  bench->frame = plainFrame();
  CLI::App* render = app.add_subcommand(
      "render",
      std::string(
          "Measures the median frame of a turn, warm, and its share of the sampling rate\n\n") +
          kPlainPicture + "  sluice bench render bonsai.nii.gz --threshold 40");
  addFrames(*render, *bench, kFrames);
  return {render, [bench](const Show& show) { return show(benchFrames(*bench), printFrames); }};
}

}  // namespace sluice
