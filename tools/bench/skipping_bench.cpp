// sluice bench skipping: Li's Table 1 for any set of volumes: frames a second of every block drawn
// whole with every sample lit and blended, as without any skipping (Basic), and of the visible
// growing boxes alone (ESS), whose rays go on over samples that show nothing.
#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "io/web/address.h"
#include "tools/bench/bench.h"
#include "tools/command_line/console.h"
#include "tools/scene/open_scene.h"

namespace sluice {
namespace {

struct SkippingWay {
  const char* name;
  Algorithm algorithm;
  Partition partition;
  Skipping skipping;
};
constexpr std::array<SkippingWay, 4> kSkippingWays = {
    {{"basic", Algorithm::kConventional, Partition::kBlocks, Skipping::kNone},
     {"whole", Algorithm::kConventional, Partition::kBlocks, Skipping::kShading},
     {"object", Algorithm::kMerged, Partition::kBlocks, Skipping::kShading},
     {"ess", Algorithm::kMerged, Partition::kBoxes, Skipping::kShading}}};

nlohmann::json skippingRow(const BenchArguments& bench, const std::string& word) {
  const auto [file, threshold] = splitThreshold(word, bench.look.threshold);
  LookArguments look = bench.look;
  look.threshold = threshold;
  FrameOptions boxes = bench.frame;
  boxes.partition = Partition::kBoxes;
  Scene scene =
      openScene({{file}, bench.volume.open, bench.volume.time}, look, bench.resources, boxes);
  warnOfIdle(bench, scene, bench.frame, {"--algorithm", "--partition"});
  nlohmann::json row{{"volume", withoutSecrets(file)},
                     {"threshold", threshold ? nlohmann::json(*threshold) : nlohmann::json()}};
  std::array<std::vector<double>, kSkippingWays.size()> seconds;
  for (int i = 1 - kWarmFrames; i < bench.frames; ++i)
    for (size_t way = 0; way < kSkippingWays.size(); ++way) {
      FrameOptions options = bench.frame;
      options.algorithm = kSkippingWays[way].algorithm;
      options.partition = kSkippingWays[way].partition;
      options.skipping = kSkippingWays[way].skipping;
      options.count_samples = i + 1 == bench.frames;
      scene.session->setOptions(options);
      // This frame also pays for the change of the plan, which belongs to neither way.
      FrameReport report = scene.session->frameReport();
      options.count_samples = false;
      if (i < 0) continue;
      scene.session->setOptions(options);
      seconds[way].push_back(scene.session->frameReport().seconds);
      if (i + 1 < bench.frames) continue;
      const std::string name = kSkippingWays[way].name;
      row[name + "_fps"] = 1 / median(seconds[way]);
      row[name + "_samples"] = report.samples_drawn;
      row[name + "_boxes"] = report.boxes_drawn;
    }
  row["speedup"] = row["ess_fps"].get<double>() / row["basic_fps"].get<double>();
  row["speedup_of_whole"] = row["ess_fps"].get<double>() / row["whole_fps"].get<double>();
  return row;
}

// {"rows": [...], "mean_speedup": ...}: one object a volume, with the names of the interface; in
// addition samples and boxes, whole blocks whose rays go on as well ("whole"), and object boxes
// (drawn by `--partition blocks`). The ways take turns frame by frame, so that a machine that
// drifts favours none. Throws Error.
nlohmann::json benchSkipping(const BenchArguments& bench) {
  requireNoLightAround(bench);
  nlohmann::json rows = nlohmann::json::array();
  double sum = 0;
  for (const std::string& word : bench.volume.inputs) {
    rows.push_back(skippingRow(bench, word));
    sum += rows.back()["speedup"].get<double>();
  }
  return {{"rows", rows}, {"mean_speedup", sum / static_cast<double>(bench.volume.inputs.size())}};
}

void printSkipping(const nlohmann::json& report) {
  say("{:<32} {:>9} {:>9} {:>9} {:>9} {:>8}   {:>11} {:>11} {:>11} {:>7}\n", "volume", "basic fps",
      "whole", "object", "ESS fps", "speedup", "basic Msamp", "object", "ESS Msamp", "boxes");
  for (const auto& row : report["rows"]) {
    const auto millions = [&](const char* name) { return row[name].get<double>() / 1e6; };
    say("{:<32} {:>9.2f} {:>9.2f} {:>9.2f} {:>9.2f} {:>8.2f}   {:>11.2f} {:>11.2f} {:>11.2f} "
        "{:>7}\n",
        row["volume"].get<std::string>(), row["basic_fps"].get<double>(),
        row["whole_fps"].get<double>(), row["object_fps"].get<double>(),
        row["ess_fps"].get<double>(), row["speedup"].get<double>(), millions("basic_samples"),
        millions("object_samples"), millions("ess_samples"), row["ess_boxes"].get<int64_t>());
  }
  say("mean speedup {:.2f}\n", report["mean_speedup"].get<double>());
}

}  // namespace

Bench addSkippingBench(CLI::App& app) {
  const auto bench = litBench<BenchArguments>();
  CLI::App* skipping =
      app.add_subcommand("skipping",
                         "Li's Table 1: every block whole against the visible growing boxes, lit "
                         "and modulated by the gradient, half a voxel between slices\n\n"
                         "  sluice bench skipping bonsai.nii.gz@40 engine.nii.gz@80");
  addFrames(*skipping, *bench, kFramesOfEachWay);
  return {skipping,
          [bench](const Show& show) { return show(benchSkipping(*bench), printSkipping); }};
}

}  // namespace sluice
