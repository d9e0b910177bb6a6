// sluice bench levels: what drawing coarser levels of resolution costs and saves.
#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "src/base/error.h"
#include "src/render/blocks/cut/cut_rules.h"
#include "tools/bench/bench.h"
#include "tools/bench/picture_error.h"
#include "tools/command_line/console.h"
#include "tools/outputs/cut_report.h"
#include "tools/outputs/report.h"

namespace sluice {
namespace {

using nlohmann::json;

constexpr int kTruthPixels = 4;  // for one, along each axis
constexpr double kPixelErrors[] = {0.5, 1, 2, 4};

struct LevelsArguments : BenchArguments {
  bool has_step = false;  // the user set the distance between slices
};

// The distance between slices is the one that `render` chooses; --step counts in voxels of the
// finest level that the picture shows.
FrameOptions optionsOf(const LevelsArguments& bench, const Scene& scene,
                       const std::optional<CutOptions>& cut) {
  FrameOptions options = bench.frame;
  options.cut = cut;
  const TimeStep step = scene.volume.step();
  if (!bench.has_step) options.step_vox = scene.chosenStep({step}, options);
  if (!cut || !bench.has_step) return options;
  const View view = resolve(options, step.source->layout());
  options.step_vox *= spacingOfLevel(step, finestLevelShown(step, view, *cut));
  return options;
}

Picture truthOf(const LevelsArguments& bench, Scene& scene) {
  FrameOptions options = optionsOf(bench, scene, std::nullopt);
  options.size = {options.size.width * kTruthPixels, options.size.height * kTruthPixels};
  options.step_vox /= 2;
  scene.session->setOptions(options);
  return averagedDown(scene.session->frame().picture, kTruthPixels);
}

json rowOf(const LevelsArguments& bench, Scene& scene, const std::optional<CutOptions>& cut,
           const Picture& truth) {
  FrameOptions options = optionsOf(bench, scene, cut);
  scene.session->setOptions(options);
  std::vector<double> seconds;
  for (int i = -kWarmFrames; i < bench.frames; ++i) {
    const double frame_seconds = scene.session->frameReport().seconds;
    if (i >= 0) seconds.push_back(frame_seconds);
  }
  // Counted in a frame of its own, since counting takes time.
  options.count_samples = true;
  scene.session->setOptions(options);
  const Frame frame = scene.session->frame();
  const PictureError error = pictureError(frame.picture, truth);
  json row{{"pixel_error", cut ? json(cut->pixel_error) : json()},
           {"max_error", error.max},
           {"mean_error", error.mean},
           {"ssim", error.ssim},
           {"mean_opacity_error", error.mean_opacity},
           {"detail", error.detail},
           {"truth_detail", error.truth_detail},
           {"read_bytes", frame.report.rebuild.decoded},
           {"samples", frame.report.samples_drawn},
           {"seconds", median(seconds)}};
  if (frame.report.cut) row["cut"] = cutJson(*frame.report.cut);
  return row;
}

// Pictures at pixel errors of 0.5, 1, 2 and 4 and of level 0, each compared with the truth: level 0
// with four pixels for one along each axis and half the distance between slices. `read_bytes`:
// stored voxels of the blocks that a picture needs. `detail` and `truth_detail`: see PictureError.
// Throws Error if the volume has one level.
json benchLevels(const LevelsArguments& bench) {
  LevelsArguments asked = bench;
  // Levels are opened only for a frame that may draw them.
  asked.frame.cut = CutOptions{};
  Scene scene = openScene(asked.volume, asked.look, asked.resources, asked.frame);
  if (scene.volume.step().coarser.empty())
    fail("{}: has one level; sluice pack --levels auto makes more", scene.volume.name);
  asked.frame.cut.reset();
  // The truth and the row of level 0 can be integrated, those of coarser levels never are.
  warnOfIdle(bench, scene, asked.frame);
  const Picture truth = truthOf(asked, scene);
  json rows = json::array();
  for (const double pixel_error : kPixelErrors)
    rows.push_back(rowOf(asked, scene, CutOptions{.pixel_error = pixel_error}, truth));
  rows.push_back(rowOf(asked, scene, std::nullopt, truth));
  return {{"volume", scene.volume.name}, {"rows", rows}, {"device", nameOf(*scene.device)}};
}

void printLevels(const json& report) {
  say("{:>11} {:>9} {:>9} {:>7} {:>9} {:>7} {:>10} {:>9} {:>8}\n", "pixel error", "max /255",
      "mean /255", "SSIM", "opacity", "detail", "read MB", "Msamples", "ms");
  for (const json& row : report["rows"]) {
    const auto number = [&](const char* name) { return row[name].get<double>(); };
    say("{:>11} {:>9.1f} {:>9.3f} {:>7.4f} {:>8.2f}% {:>7.3f} {:>10.2f} {:>9.2f} {:>8.1f}\n",
        row["pixel_error"].is_null() ? "level 0" : fmt::format("{}", number("pixel_error")),
        number("max_error"), number("mean_error"), number("ssim"),
        100 * number("mean_opacity_error"), number("detail"), number("read_bytes") / 1e6,
        number("samples") / 1e6, 1000 * number("seconds"));
  }
  say("detail: fine detail on smooth parts, /255; {:.3f} in the truth\n",
      report["rows"][0]["truth_detail"].get<double>());
}

}  // namespace

Bench addLevelsBench(CLI::App& app) {
  auto bench = std::make_shared<LevelsArguments>();
  bench->frame = plainFrame();
  CLI::App* levels = app.add_subcommand(
      "levels",
      std::string("What coarser levels of resolution cost and save: their error against level 0 "
                  "with four samples a pixel along each axis, bytes, samples and seconds\n\n") +
          kPlainPicture +
          "Without --step, slices are as far apart as render draws them: half of a voxel of each "
          "level if --shade is given.\n\n"
          "  sluice bench levels synth:phantom,dims=512x512x512,levels=4 "
          "--size 256x256");
  addFrames(*levels, *bench, kFramesOfEachWay);
  return {levels, [bench, levels](const Show& show) {
            bench->has_step = levels->count("--step") > 0;
            return show(benchLevels(*bench), printLevels);
          }};
}

}  // namespace sluice
