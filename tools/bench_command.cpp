// sluice bench: speeds of this machine and of the renderer, as medians.
#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <sstream>

#include "cache/simulate/bench_simulate.h"
#include "src/base/clock.h"
#include "src/render/sampling_limit.h"
#include "src/slicing/slicing_cost.h"
#include "tools/algorithms_bench.h"
#include "tools/command_line/console.h"
#include "tools/command_line/shared_options.h"
#include "tools/commands.h"
#include "tools/culling_bench.h"
#include "tools/occlusion_bench.h"
#include "tools/packing_bench.h"
#include "tools/ranks.h"
#include "tools/ranks_bench.h"
#include "tools/report.h"
#include "tools/skipping_bench.h"
#include "tools/threshold_bench.h"

namespace sluice {
namespace {

struct Arguments {
  VolumeArguments volume;
  LookArguments look;
  FrameOptions frame;
  ResourceArguments resources;
  int frames = 9;
  bool json = false;
};
constexpr int kWarmFrames = 2;
// What every bench draws: comparable over versions, and with other renderers.
constexpr const char* kPlainPicture =
    "Unless told otherwise pictures are plain: --view plain at azimuth 30 and elevation 20, fitted "
    "to the volume's sphere, unlit, a step of 1, and without --threshold a ramp from a fifth of "
    "the value range on.\n\n";

int runLimit(const Arguments& arguments) {
  Workers pool(arguments.resources.threads);
  const auto device = makeDevice(arguments.resources.device, pool);
  const double rate = samplingLimit(*device, arguments.frame.size, arguments.frames);
  if (arguments.json) {
    const nlohmann::json report{{"samples_per_second", rate},
                                {"device", nameOf(*device)},
                                {"backend", device->backend()},
                                {"renderer", device->renderer()}};
    say("{}\n", report.dump(2));
  } else {
    say("{:.1f} million samples a second ({}, {})\n", rate / 1e6, device->backend(),
        device->renderer());
  }
  return 0;
}

int runRender(const Arguments& arguments, const CLI::App& app) {
  Scene scene(arguments.volume, arguments.look, arguments.resources, arguments.frame.partition);
  FrameOptions options = arguments.frame;
  const auto turnTo = [&](int frame) {
    options.camera.azimuth_deg =
        arguments.frame.camera.azimuth_deg + 360.0 * std::max(0, frame) / arguments.frames;
    scene.session->setOptions(options);
  };
  std::vector<double> seconds;
  // Of all threads: other work on the machine makes it longer by little.
  double processor_seconds = 0;
  for (int i = -kWarmFrames; i < arguments.frames; ++i) {
    turnTo(i);
    const double before = processorSeconds();
    const double frame_seconds = scene.session->frameReport().seconds;
    if (i < 0) continue;
    processor_seconds += (processorSeconds() - before) / arguments.frames;
    seconds.push_back(frame_seconds);
  }
  // Counting takes time: the same frames again.
  double drawn = 0, taken = 0, object = 0;
  RenderedFrame last;
  options.count_samples = options.counts_leaps = true;
  for (int i = 0; i < arguments.frames; ++i) {
    turnTo(i);
    last.report = scene.session->frameReport();
    drawn += static_cast<double>(last.report.samples_drawn) / arguments.frames;
    taken += static_cast<double>(last.report.samples_taken) / arguments.frames;
    object += static_cast<double>(last.report.samples_object) / arguments.frames;
  }
  // In the same process and moment, since machines drift.
  const double limit = samplingLimit(*scene.device, options.size, arguments.frames);
  const auto [least, most] = std::minmax_element(seconds.begin(), seconds.end());
  const double middle = median(seconds);
  // Cells outside the object boxes are drawn in vain; inside them only what was taken counts.
  const double share = std::min(taken, object) / middle / limit;
  if (arguments.json) {
    nlohmann::json report = sceneJson(scene, {last});
    report.update({{"command", "bench render"},
                   {"options", optionsJson(app)},
                   {"frame_seconds", {{"median", middle}, {"min", *least}, {"max", *most}}},
                   {"frame_processor_seconds", processor_seconds},
                   {"samples_drawn", drawn},
                   {"samples_taken", taken},
                   {"samples_object", object},
                   {"limit_samples_per_second", limit},
                   {"share_of_limit", share}});
    say("{}\n", report.dump(2));
  } else {
    say("frame {:.4f} s (least {:.4f}, most {:.4f}), warm, {} frames of a turn\n", middle, *least,
        *most, arguments.frames);
    say("{:.4f} s of the processor's time a frame, all threads\n", processor_seconds);
    say("{:.2f} million samples drawn, {:.2f} million taken, {:.2f} million inside object boxes\n",
        drawn / 1e6, taken / 1e6, object / 1e6);
    say("{:.2f} of this machine's {:.1f} million samples a second\n", share, limit / 1e6);
  }
  return 0;
}

VolumesBench volumesBench(const Arguments& arguments) {
  return {arguments.volume.inputs, arguments.look,        arguments.frame, arguments.resources,
          arguments.volume.open,   arguments.volume.time, arguments.frames};
}

// As JSON, with what was asked, or for people.
int show(nlohmann::json report, const Arguments& arguments, const CLI::App& app,
         void (*print)(const nlohmann::json&)) {
  if (arguments.json) {
    report.update({{"command", "bench " + app.get_name()}, {"options", optionsJson(app)}});
    say("{}\n", report.dump(2));
  } else {
    print(report);
  }
  return 0;
}

int runThreshold(const Arguments& arguments, int changes, const CLI::App& app) {
  return show(benchThreshold({arguments.volume, arguments.look, arguments.frame,
                              arguments.resources, changes}),
              arguments, app, printThreshold);
}

int runPacking(const Arguments& arguments) {
  const nlohmann::json report = benchPacking(arguments.volume, arguments.resources);
  if (arguments.json) {
    say("{}\n", report.dump(2));
  } else {
    printPacking(report);
  }
  return 0;
}

int runSimulate(bool as_json) {
  const SimulateBenchResult result = benchSimulate({});
  if (as_json) {
    const nlohmann::json report{
        {"requests_per_second", {{"lru", result.lru}, {"curve", result.curve}}}};
    say("{}\n", report.dump(2));
  } else {
    say("LRU {:.1f}, exact curve {:.1f} million page requests a second on one core\n",
        result.lru / 1e6, result.curve / 1e6);
  }
  return 0;
}

int runSlicing(bool as_json) {
  constexpr int kViews = 9;
  constexpr uint64_t kSeed = 1;
  const SlicingCost cost = slicingCost(kViews, kSeed);
  if (as_json) {
    const nlohmann::json report{{"command", "bench slicing"},
                                {"slices", cost.slices},
                                {"plain_ns", cost.plain_ns},
                                {"incremental_ns", cost.incremental_ns},
                                {"ratio", cost.ratio()}};
    say("{}\n", report.dump(2));
  } else {
    say("{:.1f} ns a slice incrementally, {:.1f} ns from scratch: {:.2f} of it; {} slices a view\n",
        cost.incremental_ns, cost.plain_ns, cost.ratio(), cost.slices);
  }
  return 0;
}

// "1,2,4".
std::optional<std::vector<int>> rankCounts(const std::string& word) {
  constexpr int kMostRanks = 64;
  if (word.ends_with(',')) return std::nullopt;
  std::vector<int> counts;
  std::stringstream rest(word);
  for (std::string part; std::getline(rest, part, ',');) {
    const auto count = parseIn<int>(part, {1, kMostRanks});
    if (!count) return std::nullopt;
    counts.push_back(*count);
  }
  if (counts.empty()) return std::nullopt;
  return counts;
}

int runRanks(const RanksBench& bench, const Arguments& arguments, const CLI::App& app) {
  return onRanks(
      [&](Team* team) { return show(benchRanks(bench, team), arguments, app, printRanks); });
}

// Of the benches over any set of volumes.
void addVolumesOptions(CLI::App& app, Arguments& arguments) {
  addVolumeOptions(app, arguments.volume);
  addLookOptions(app, arguments.look, arguments.frame);
  addViewOptions(app, arguments.frame);
  addResourceOptions(app, arguments.resources);
  const OptionGroup output(app, kOutputHeading);
  addFramesOption(output, arguments.frames, "Frames measured of each way, after 2 warm ones");
  addJsonOption(output, arguments.json);
}

}  // namespace

Command addBench(CLI::App& program) {
  auto arguments = std::make_shared<Arguments>();
  arguments->frame.camera.azimuth_deg = 30;
  arguments->frame.camera.elevation_deg = 20;
  CLI::App* app =
      program.add_subcommand("bench", std::string("Measures speeds\n\n") + kPlainPicture +
                                          "  sluice bench render bonsai.nii.gz --threshold 40");
  app->require_subcommand(1);

  CLI::App* limit = app->add_subcommand(
      "limit", "This machine's sampling rate: full-screen slices of one resident texture");
  const OptionGroup limit_machine(*limit, kMachineHeading);
  addThreadsOption(limit_machine, arguments->resources.threads);
  addDeviceOptions(limit_machine, arguments->resources.device);
  CLI::App* render = app->add_subcommand(
      "render",
      std::string("The median frame of a turn, warm, and its share of the sampling rate\n\n") +
          kPlainPicture + "  sluice bench render bonsai.nii.gz --threshold 40");
  addVolumeOptions(*render, arguments->volume);
  addLookOptions(*render, arguments->look, arguments->frame);
  addViewOptions(*render, arguments->frame);
  addResourceOptions(*render, arguments->resources);
  CLI::App* simulate =
      app->add_subcommand("simulate", "The simulator's page requests a second, on one core");
  addJsonOption(OptionGroup(*simulate, kOutputHeading), arguments->json);
  CLI::App* slicing = app->add_subcommand(
      "slicing",
      "Cutting boxes by a view's slices, incrementally against from scratch, on one core");
  addJsonOption(OptionGroup(*slicing, kOutputHeading), arguments->json);
  // The paper's machine and picture, unless told otherwise.
  auto paper = std::make_shared<Arguments>(*arguments);
  paper->resources.page_vox = {32, 64, 2};
  paper->resources.pages = 256;
  paper->frame.size = {400, 400};
  CLI::App* algorithms = app->add_subcommand(
      "algorithms", std::string("Tong's Table 1: I conventional, II clipped, III trimmed, IV "
                                "merged\n\n") +
                        kPlainPicture +
                        "  sluice bench algorithms bonsai.nii.gz@40 engine.nii.gz@80");
  addVolumesOptions(*algorithms, *paper);
  auto lit = std::make_shared<Arguments>(*arguments);
  lit->frame.step_vox = 0.5;
  lit->look.shade = lit->look.modulate = true;
  CLI::App* skipping =
      app->add_subcommand("skipping",
                          "Li's Table 1: every block whole against the visible growing boxes, lit "
                          "and modulated by the gradient, half a voxel between slices\n\n"
                          "  sluice bench skipping bonsai.nii.gz@40 engine.nii.gz@80");
  addVolumesOptions(*skipping, *lit);
  auto surface = std::make_shared<Arguments>(*lit);
  auto adapt_frames = std::make_shared<int>(0);
  CLI::App* occlusion =
      app->add_subcommand("occlusion",
                          "Li's Table 2: growing boxes without and with occlusion culling and "
                          "clipping, surface-like\n\n"
                          "  sluice bench occlusion bonsai.nii.gz@40 engine.nii.gz@80");
  addVolumesOptions(*occlusion, *surface);
  OptionGroup(*occlusion, kOutputHeading)
      .number("--adapt-frames", "N", *adapt_frames, {0, 100'000},
              "Frames of each of four views whose numbers of map updates are listed (Figure 6)");
  auto culled = std::make_shared<CullingBench>();
  culled->frame = arguments->frame;
  CLI::App* culling = app->add_subcommand(
      "culling",
      "Gao's figures and table for a series: blocks with culling and without, the optimum, what "
      "changes from step to step, thresholds of fusion, and the time of the series\n\n"
      "  sluice bench culling 'step_%03d.raw' --threshold 40");
  addVolumeOptions(*culling, culled->volume);
  addLookOptions(*culling, culled->look, culled->frame);
  addViewOptions(*culling, culled->frame);
  addCullingOptions(*culling, culled->culling, false);
  addResourceOptions(*culling, culled->resources);
  const OptionGroup culling_output(*culling, kOutputHeading);
  culling_output.number("--views", "N", culled->views, {1, 360}, "Views of a turn");
  culling_output.flag("--no-optimum", culled->no_optimum,
                      "Without the limit that early ray termination sets, which reads every step");
  culling_output.flag("--no-thresholds", culled->no_thresholds,
                      "Without thresholds of fusion, which make all functions five times");
  culling_output.flag("--no-series", culled->no_series, "Without drawing the series");
  addJsonOption(culling_output, arguments->json);
  auto shared_out = std::make_shared<RanksBench>();
  shared_out->frame = arguments->frame;
  CLI::App* ranks = app->add_subcommand(
      "ranks",
      "What sharing a picture out among ranks brings: those of mpirun, or alone ranks of one "
      "thread each\n\n"
      "  mpirun -n 2 sluice bench ranks bonsai.nii.gz --threshold 40");
  addVolumeOptions(*ranks, shared_out->volume);
  addLookOptions(*ranks, shared_out->look, shared_out->frame);
  addViewOptions(*ranks, shared_out->frame);
  addResourceOptions(*ranks, shared_out->resources);
  const OptionGroup ranks_output(*ranks, kOutputHeading);
  ranks_output.parsed(
      "--ranks", "N,...", "numbers from 1 to 64 with commas between", rankCounts,
      [shared_out](const std::vector<int>& counts) { shared_out->ranks = counts; },
      "Ranks to measure where no launcher says how many", "1,2");
  addFramesOption(ranks_output, shared_out->frames, "Frames measured, after 2 warm ones");
  addJsonOption(ranks_output, arguments->json);
  auto changes = std::make_shared<int>(24);
  CLI::App* threshold = app->add_subcommand(
      "threshold",
      std::string(
          "From a changed threshold to the finished picture: small and large steps, a "
          "random walk and a band; in memory, out of core and cold; and a full rebuild\n\n") +
          kPlainPicture + "  sluice bench threshold bonsai.nii.gz --threshold 40");
  addVolumeOptions(*threshold, arguments->volume);
  addLookOptions(*threshold, arguments->look, arguments->frame);
  addViewOptions(*threshold, arguments->frame);
  addResourceOptions(*threshold, arguments->resources);
  const OptionGroup threshold_output(*threshold, kOutputHeading);
  threshold_output.number("--changes", "N", *changes, {1, 100'000}, "Changes of each kind");
  addJsonOption(threshold_output, arguments->json);
  CLI::App* packing = app->add_subcommand(
      "packing", "What compressing a volume's blocks in memory brings, by codec, on one core");
  addVolumeOptions(*packing, arguments->volume);
  addResourceOptions(*packing, arguments->resources);
  addJsonOption(OptionGroup(*packing, kOutputHeading), arguments->json);
  for (CLI::App* each : {limit, render}) {
    const OptionGroup output(*each, kOutputHeading);
    addFramesOption(output, arguments->frames, "Frames measured, after 2 warm ones");
    addJsonOption(output, arguments->json);
  }
  return [=] {
    if (limit->parsed()) return runLimit(*arguments);
    if (simulate->parsed()) return runSimulate(arguments->json);
    if (packing->parsed()) return runPacking(*arguments);
    if (culling->parsed()) return show(benchCulling(*culled), *arguments, *culling, printCulling);
    if (ranks->parsed()) return runRanks(*shared_out, *arguments, *ranks);
    if (threshold->parsed()) return runThreshold(*arguments, *changes, *threshold);
    if (slicing->parsed()) return runSlicing(arguments->json);
    if (skipping->parsed()) {
      return show(benchSkipping(volumesBench(*lit)), *lit, *skipping, printSkipping);
    }
    if (occlusion->parsed()) {
      return show(benchOcclusion(volumesBench(*surface), *adapt_frames), *surface, *occlusion,
                  printOcclusion);
    }
    if (algorithms->parsed()) {
      return show(benchAlgorithms(volumesBench(*paper)), *paper, *algorithms, printAlgorithms);
    }
    return runRender(*arguments, *render);
  };
}

}  // namespace sluice
