// sluice bench occlusion: Li's Table 2 and the data of Figure 6 for any set of volumes: frames a
// second of every block drawn whole (Basic), of the visible growing boxes (ESS), of these with the
// opacity map asked in vain (ESS+M), with hidden boxes culled (ESS+C), and clipped too (ESS+CC). In
// addition the device's own methods without a map: object boxes, and if the device can, rays that
// leap inside them and end behind opaque matter.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <vector>

#include "io/web/address.h"
#include "src/classify/transfer/transfer_makers.h"
#include "src/render/frame/frame_run.h"
#include "tools/bench/bench.h"
#include "tools/command_line/console.h"
#include "tools/scene/open_scene.h"

namespace sluice {
namespace {

using nlohmann::json;

struct OcclusionBench : BenchArguments {
  int adapt_frames = 0;
  // The number of map updates that frames begin with, from which it adapts in a window of 3 to
  // either side (section 4.4). The paper's is 9.
  int updates = FrameLessons::kUpdates.first;
};

constexpr int kFramesATurn = 4;
// The default ramp begins at opacity 0.01 a voxel: at the threshold a ray is opaque within two.
constexpr double kSurfaceFactor = 80;
constexpr std::array<double, 4> kAdaptTurns = {0, 60, 150, 240};  // degrees more of azimuth

struct Way {
  const char* name;
  Algorithm algorithm;
  Partition partition;
  Occlusion occlusion;
  Skipping skipping;
};
constexpr std::array<Way, 6> kWays = {
    {{"basic", Algorithm::kConventional, Partition::kBlocks, Occlusion::kOff, Skipping::kShading},
     {"ess", Algorithm::kMerged, Partition::kBoxes, Occlusion::kOff, Skipping::kShading},
     {"ess_m", Algorithm::kMerged, Partition::kBoxes, Occlusion::kMap, Skipping::kShading},
     {"ess_c", Algorithm::kMerged, Partition::kBoxes, Occlusion::kCull, Skipping::kShading},
     {"ess_cc", Algorithm::kMerged, Partition::kBoxes, Occlusion::kClip, Skipping::kShading},
     {"own", Algorithm::kMerged, Partition::kBlocks, Occlusion::kOff, Skipping::kLeaps}}};

UpdateCountOptions scheduleOf(const OcclusionBench& bench) {
  UpdateCountOptions options = FrameLessons::kUpdates;
  options.first = bench.updates;
  return options;
}

FrameOptions optionsOf(FrameOptions options, const Way& way) {
  options.algorithm = way.algorithm;
  options.skipping = way.skipping;
  options.partition = way.partition;
  options.occlusion = way.occlusion;
  return options;
}

// Frames a second of each way. They go by turns, so that a machine's slower times are everyone's.
std::array<double, kWays.size()> speedsOf(Session& session, const FrameOptions& options,
                                          int frames) {
  std::array<std::vector<double>, kWays.size()> seconds;
  for (int done = 0; done < frames; done += kFramesATurn)
    for (size_t way = 0; way < kWays.size(); ++way) {
      session.setOptions(optionsOf(options, kWays[way]));
      for (int i = -kWarmFrames; i < std::min(kFramesATurn, frames - done); ++i) {
        const double frame_seconds = session.frame().report.seconds;
        if (i >= 0) seconds[way].push_back(frame_seconds);
      }
    }
  std::array<double, kWays.size()> speeds{};
  for (size_t way = 0; way < kWays.size(); ++way) speeds[way] = 1 / median(seconds[way]);
  return speeds;
}

// The report of a frame whose samples are counted.
FrameReport countedFrame(Session& session, FrameOptions options) {
  options.count_samples = true;
  session.setOptions(options);
  return session.frame().report;
}

json updatesOf(Session& session, const OcclusionBench& bench, double turn) {
  FrameOptions options = bench.frame;
  options.partition = Partition::kBoxes;
  options.skipping = Skipping::kShading;
  options.camera.azimuth_deg += turn;
  options.occlusion = Occlusion::kClip;
  session.setOptions(options);
  session.forgetLastFrame(scheduleOf(bench));  // and the number of updates with it
  json wanted = json::array(), made = json::array();
  for (int i = 0; i < bench.adapt_frames; ++i) {
    const OcclusionReport report = session.frame().report.occlusion;
    wanted.push_back(report.updates_wanted);
    made.push_back(report.updates);
  }
  return {{"azimuth", options.camera.azimuth_deg}, {"wanted", wanted}, {"made", made}};
}

json rowOf(const OcclusionBench& bench, const std::string& word) {
  const auto [file, threshold] = splitThreshold(word, bench.look.threshold);
  LookArguments look = bench.look;
  look.threshold = threshold;
  FrameOptions boxes = bench.frame;
  boxes.partition = Partition::kBoxes;
  Scene scene =
      openScene({{file}, bench.volume.open, bench.volume.time}, look, bench.resources, boxes);
  warnOfIdle(bench, scene, bench.frame, {"--algorithm", "--partition", "--occlusion"});
  Session& session = *scene.session;
  // A curve or an opacity that was asked for is measured as it is.
  if (look.transfer_file.empty() && !look.opacity)
    session.setTransferFunction(scaleOpacity(scene.look.transfer, kSurfaceFactor));
  session.forgetLastFrame(scheduleOf(bench));
  json row{{"volume", withoutSecrets(file)}, {"threshold", threshold ? json(*threshold) : json()}};
  const auto speeds = speedsOf(session, bench.frame, bench.frames);
  std::array<FrameReport, kWays.size()> counted;
  for (size_t way = 0; way < kWays.size(); ++way) {
    counted[way] = countedFrame(session, optionsOf(bench.frame, kWays[way]));
    row["fps"][kWays[way].name] = speeds[way];
    row["samples"][kWays[way].name] = counted[way].samples_taken;
  }
  const FrameReport& ess = counted[1];
  const FrameReport& clipped = counted[4];
  const auto percentOf = [](auto part, auto whole) {
    return whole == 0 ? 0 : 100 * static_cast<double>(part) / static_cast<double>(whole);
  };
  row["culled_percent"] = percentOf(clipped.occlusion.cells_culled, clipped.occlusion.cells);
  row["clipped_percent"] = percentOf(clipped.occlusion.cells_clipped, clipped.occlusion.cells);
  row["map_updates"] = {{"wanted", clipped.occlusion.updates_wanted},
                        {"made", clipped.occlusion.updates}};
  row["stopped_percent"] =
      percentOf(clipped.samples_drawn - clipped.samples_taken, ess.samples_taken);
  row["skipped_percent"] = 100 - percentOf(clipped.samples_taken, ess.samples_taken);
  const auto fps = [&](const char* way) { return row["fps"][way].get<double>(); };
  row["speedup"] = {{"ess", fps("ess") / fps("basic")},
                    {"cc", fps("ess_cc") / fps("ess")},
                    {"ess_cc", fps("ess_cc") / fps("basic")}};
  row["map_cost_percent"] = 100 * (fps("ess") / fps("ess_m") - 1);
  row["updates"] = json::array();
  for (const double turn : kAdaptTurns)
    if (bench.adapt_frames > 0) row["updates"].push_back(updatesOf(session, bench, turn));
  return row;
}

// {"rows": [...], "mean": {...}}: one object a volume, the names of the interface. Percentages are
// of what ESS draws: culled and clipped of its cells, skipped of its samples; `stopped_percent` of
// its samples, those in boxes that ESS+CC drew but did not take, since the ray had ended or the
// pixel was opaque; `map_updates` those that ESS+CC wanted and made. Under `updates`: the numbers
// of map updates wanted and made, frame by frame, of `adapt_frames` frames of each of four views.
//
// Transfer functions of a threshold or of none become surface-like: 80 times as opaque. Each way
// draws its frames in a row, since the number of updates adapts from frame to frame. Throws Error.
json benchOcclusion(const OcclusionBench& bench) {
  requireNoLightAround(bench);
  json rows = json::array();
  for (const std::string& word : bench.volume.inputs) rows.push_back(rowOf(bench, word));
  json mean;
  const auto meanOf = [&rows](const json::json_pointer& at) {
    double sum = 0;
    for (const json& row : rows) sum += row[at].get<double>();
    return sum / static_cast<double>(rows.size());
  };
  for (const char* at :
       {"/culled_percent", "/clipped_percent", "/stopped_percent", "/skipped_percent",
        "/map_cost_percent", "/speedup/ess", "/speedup/cc", "/speedup/ess_cc"})
    mean[json::json_pointer(at)] = meanOf(json::json_pointer(at));
  return {{"rows", rows}, {"mean", mean}};
}

void printOcclusion(const json& report) {
  say("{:<28} {:>7} {:>7} {:>7} {:>7} {:>7} {:>7}   {:>6} {:>6} {:>6} {:>7}   {:>5} {:>5} {:>6} "
      "{:>6}\n",
      "volume", "basic", "ESS", "ESS+CC", "ESS+M", "ESS+C", "own", "culled", "clip", "stop",
      "skipped", "ESS", "CC", "ESS+CC", "map %");
  const auto printParts = [](const json& row) {
    const auto number = [&row](const char* at) {
      return row[json::json_pointer(at)].get<double>();
    };
    say("   {:>6.1f} {:>6.1f} {:>6.1f} {:>7.1f}   {:>5.2f} {:>5.2f} {:>6.2f} {:>6.1f}\n",
        number("/culled_percent"), number("/clipped_percent"), number("/stopped_percent"),
        number("/skipped_percent"), number("/speedup/ess"), number("/speedup/cc"),
        number("/speedup/ess_cc"), number("/map_cost_percent"));
  };
  for (const json& row : report["rows"]) {
    const auto fps = [&row](const char* way) { return row["fps"][way].get<double>(); };
    say("{:<28} {:>7.2f} {:>7.2f} {:>7.2f} {:>7.2f} {:>7.2f} {:>7.2f}",
        row["volume"].get<std::string>(), fps("basic"), fps("ess"), fps("ess_cc"), fps("ess_m"),
        fps("ess_c"), fps("own"));
    printParts(row);
  }
  say("{:<76}", "mean");
  printParts(report["mean"]);
}

}  // namespace

Bench addOcclusionBench(CLI::App& app) {
  const auto bench = litBench<OcclusionBench>();
  CLI::App* occlusion =
      app.add_subcommand("occlusion",
                         "Li's Table 2: growing boxes without and with occlusion culling and "
                         "clipping, surface-like\n\n"
                         "  sluice bench occlusion bonsai.nii.gz@40 engine.nii.gz@80");
  addFrames(*occlusion, *bench, kFramesOfEachWay);
  const OptionGroup output(*occlusion, kOutputHeading);
  output.number("--adapt-frames", "N", bench->adapt_frames, {0, 100'000},
                "Frames of each of four views whose numbers of map updates are listed (Figure 6)");
  output.number("--updates", "N", bench->updates, {1, 64},
                "Updates of the opacity map in the first frame, from which the number adapts in a "
                "window of 3 to either side; Li's is 9");
  return {occlusion,
          [bench](const Show& show) { return show(benchOcclusion(*bench), printOcclusion); }};
}

}  // namespace sluice
