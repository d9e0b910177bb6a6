// sluice bench quality: the error of each way to sample rays, and its time.
#include <fmt/format.h>

#include <iterator>
#include <string>
#include <vector>

#include "src/base/threads/clock.h"
#include "src/library/drawing/scene/picture_facts.h"
#include "src/options/idle_options.h"
#include "tools/bench/bench.h"
#include "tools/bench/picture_error.h"
#include "tools/command_line/console.h"
#include "tools/outputs/report.h"

namespace sluice {
namespace {

using nlohmann::json;

constexpr double kTruthStep = 1.0 / 8;

// A way to sample.
struct SamplingWay {
  bool integrates;
  double step_vox;
};
constexpr SamplingWay kSamplingWays[] = {{false, 2}, {false, 1}, {false, 0.5}, {false, 0.25},
                                         {true, 2},  {true, 1},  {true, 0.5}};

FrameOptions optionsOf(const BenchArguments& bench, const SamplingWay& way) {
  FrameOptions options = bench.frame;
  options.integrates = way.integrates;
  options.step_vox = way.step_vox;
  return options;
}

Picture drawn(Scene& scene, const FrameOptions& options) {
  scene.session->setOptions(options);
  return scene.session->frame().picture;
}

// The time of a frame on all threads, and by the wall.
struct Times {
  std::vector<double> cpu_s, wall_s;
};

// Each way once, one after the other, so that a busy machine slows down all of them alike.
void measureAll(const BenchArguments& bench, Scene& scene, std::vector<Times>& times) {
  for (size_t i = 0; i < std::size(kSamplingWays); ++i) {
    scene.session->setOptions(optionsOf(bench, kSamplingWays[i]));
    // The first frame of a way makes its plan and its tables.
    for (const bool counts : {false, true}) {
      const double before_s = processorSeconds();
      const double wall_s = scene.session->frameReport().seconds;
      if (!counts) continue;
      times[i].cpu_s.push_back(processorSeconds() - before_s);
      times[i].wall_s.push_back(wall_s);
    }
  }
}

json benchQuality(const BenchArguments& bench) {
  BenchArguments asked = bench;
  asked.frame.integrates = true;  // for blocks that have what it takes
  Scene scene = openScene(asked.volume, asked.look, asked.resources, asked.frame);
  warnOfIdle(bench, scene, asked.frame, {"--quality", "--step"});
  for (const std::string& line : idleOptions({"--quality"}, pictureFacts(scene, asked.frame)))
    printWarning(fmt::format("{}: rows of integrated samples are those of plain ones: {}",
                             scene.volume.name, line));
  const Picture truth = drawn(scene, optionsOf(asked, {false, kTruthStep}));
  std::vector<Times> times(std::size(kSamplingWays));
  for (int round = 0; round < bench.frames; ++round) measureAll(asked, scene, times);
  json rows = json::array();
  for (size_t i = 0; i < std::size(kSamplingWays); ++i) {
    const PictureError error =
        pictureError(drawn(scene, optionsOf(asked, kSamplingWays[i])), truth);
    rows.push_back({{"integrates", kSamplingWays[i].integrates},
                    {"step", kSamplingWays[i].step_vox},
                    {"max_error", error.max},
                    {"mean_error", error.mean},
                    {"ssim", error.ssim},
                    {"detail", error.detail},
                    {"truth_detail", error.truth_detail},
                    {"processor_seconds", median(times[i].cpu_s)},
                    {"seconds", median(times[i].wall_s)}});
  }
  return {{"volume", scene.volume.name}, {"rows", rows}, {"device", nameOf(*scene.device)}};
}

void printQuality(const json& report) {
  const json& rows = report["rows"];
  // Times are shares of the time of plain samples, one a voxel.
  const double one = rows[1]["processor_seconds"].get<double>();
  say("{:>10} {:>5} {:>9} {:>9} {:>7} {:>7} {:>8} {:>8} {:>6}\n", "samples", "step", "max /255",
      "mean /255", "SSIM", "detail", "CPU ms", "ms", "time");
  for (const json& row : rows) {
    const auto number = [&](const char* name) { return row[name].get<double>(); };
    say("{:>10} {:>5} {:>9.1f} {:>9.3f} {:>7.4f} {:>7.3f} {:>8.1f} {:>8.1f} {:>6.2f}\n",
        row["integrates"].get<bool>() ? "integrated" : "plain", number("step"), number("max_error"),
        number("mean_error"), number("ssim"), number("detail"), 1000 * number("processor_seconds"),
        1000 * number("seconds"), number("processor_seconds") / one);
  }
  say("detail: fine detail on smooth parts, /255; {:.3f} in the truth\n",
      rows[0]["truth_detail"].get<double>());
}

}  // namespace

Bench addQualityBench(CLI::App& app) {
  auto bench = std::make_shared<BenchArguments>();
  bench->frame = plainFrame();
  CLI::App* quality = app.add_subcommand(
      "quality",
      std::string("What pre-integration (--quality) costs and saves: the error of plain and of "
                  "integrated samples at several steps against plain samples an eighth of a voxel "
                  "apart, and their times, measured by turns\n\n") +
          kPlainPicture + "  sluice bench quality bonsai.nii.gz --threshold 40 --shade");
  addFrames(*quality, *bench, kFramesOfEachWay);
  return {quality, [bench](const Show& show) { return show(benchQuality(*bench), printQuality); }};
}

}  // namespace sluice
