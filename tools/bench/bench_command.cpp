// sluice bench: speeds of this machine and of the renderer, as medians.
#include <fmt/format.h>

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <sstream>

#include "cache/simulate/bench_simulate.h"
#include "src/slicing/slicing_cost.h"
#include "tools/bench/algorithms_bench.h"
#include "tools/bench/bench_report.h"
#include "tools/bench/culling_bench.h"
#include "tools/bench/cut_bench.h"
#include "tools/bench/frame_bench.h"
#include "tools/bench/levels_bench.h"
#include "tools/bench/occlusion_bench.h"
#include "tools/bench/packing_bench.h"
#include "tools/bench/ranks_bench.h"
#include "tools/bench/skipping_bench.h"
#include "tools/bench/threshold_bench.h"
#include "tools/bench/view_bench.h"
#include "tools/command_line/console.h"
#include "tools/command_line/environment.h"
#include "tools/commands/commands.h"
#include "tools/options/shared_options.h"
#include "tools/options/view_arguments.h"
#include "tools/outputs/report.h"
#include "tools/pages/report_file.h"
#include "tools/scene/rank_agreement.h"
#include "tools/scene/ranks.h"

namespace sluice {
namespace {

using nlohmann::json;

// Outputs a bench's report as the options ask; the result is the exit status.
using Print = void (*)(const json&);
using Show = std::function<int(json report, Print print)>;

// A subcommand of bench, and the function that runs it.
struct Bench {
  CLI::App* app;
  std::function<int(const Show&)> run;
};

// The picture that every bench draws by default, comparable over versions and with other renderers.
constexpr const char* kPlainPicture =
    "By default pictures are plain: --view plain at azimuth 30 and elevation 20, fitted to the "
    "volume's sphere, unlit, with a step of 1. Without --threshold the ramp begins at a fifth of "
    "the value range.\n\n";

VolumesBench volumesBench(const FrameBench& bench) {
  return {bench.volume.inputs, bench.look,        bench.frame, bench.resources,
          bench.volume.open,   bench.volume.time, bench.frames};
}

json simulatorReport() {
  const SimulateBenchResult result = benchSimulate({});
  return {{"requests_per_second", {{"lru", result.lru}, {"curve", result.curve}}}};
}

void printSimulator(const json& report) {
  const json& rates = report["requests_per_second"];
  say("LRU {:.1f}, exact curve {:.1f} million page requests a second on one core\n",
      rates["lru"].get<double>() / 1e6, rates["curve"].get<double>() / 1e6);
}

json slicingReport() {
  constexpr int kViews = 9;
  constexpr uint64_t kSeed = 1;
  const SlicingCost cost = slicingCost(kViews, kSeed);
  return {{"slices", cost.slices},
          {"plain_ns", cost.plain_ns},
          {"incremental_ns", cost.incremental_ns},
          {"ratio", cost.ratio()}};
}

void printSlicing(const json& report) {
  say("{:.1f} ns a slice incrementally, {:.1f} ns from scratch: {:.2f} of it; {} slices a view\n",
      report["incremental_ns"].get<double>(), report["plain_ns"].get<double>(),
      report["ratio"].get<double>(), report["slices"].get<int64_t>());
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

// Options of the pictures, for every bench that draws.
template <class Arguments>
AskedView addPictures(CLI::App& app, Arguments& arguments) {
  auto asked = std::make_shared<ViewState>();
  addVolumeOptions(app, arguments.volume);
  addLookOptions(app, asked, arguments.look, arguments.frame);
  addViewOptions(app, asked, arguments.frame);
  addResourceOptions(app, arguments.resources);
  return asked;
}

// A bench over any set of volumes, frame by frame.
void addFrames(CLI::App& app, FrameBench& bench, const char* which) {
  addPictures(app, bench);
  addFramesOption(OptionGroup(app, kOutputHeading), bench.frames, which);
}

constexpr const char* kFramesOfEachWay = "Frames measured for each variant, after 2 warm ones";
constexpr const char* kFrames = "Frames measured, after 2 warm ones";

Bench addLimit(CLI::App& app) {
  auto bench = std::make_shared<FrameBench>();
  CLI::App* limit = app.add_subcommand(
      "limit",
      "Measures this machine's sampling rate with full-screen slices of one resident texture");
  const OptionGroup machine(*limit, kMachineHeading);
  addThreadsOption(machine, bench->resources.threads);
  addDeviceOptions(machine, bench->resources.device);
  addFramesOption(OptionGroup(*limit, kOutputHeading), bench->frames, kFrames);
  return {limit, [bench](const Show& show) { return show(benchLimit(*bench), printLimit); }};
}

Bench addRender(CLI::App& app, const FrameOptions& plain) {
  auto bench = std::make_shared<FrameBench>();
  bench->frame = plain;
  CLI::App* render = app.add_subcommand(
      "render",
      std::string(
          "Measures the median frame of a turn, warm, and its share of the sampling rate\n\n") +
          kPlainPicture + "  sluice bench render bonsai.nii.gz --threshold 40");
  addFrames(*render, *bench, kFrames);
  return {render, [bench](const Show& show) { return show(benchFrames(*bench), printFrames); }};
}

// The paper's machine and picture, unless told otherwise.
Bench addAlgorithms(CLI::App& app, const FrameOptions& plain) {
  auto bench = std::make_shared<FrameBench>();
  bench->frame = plain;
  bench->resources.page_vox = {32, 64, 2};
  bench->resources.pages = 256;
  bench->frame.size = {400, 400};
  CLI::App* algorithms = app.add_subcommand(
      "algorithms", std::string("Tong's Table 1: I conventional, II clipped, III trimmed, IV "
                                "merged\n\n") +
                        kPlainPicture +
                        "  sluice bench algorithms bonsai.nii.gz@40 engine.nii.gz@80");
  addFrames(*algorithms, *bench, kFramesOfEachWay);
  return {algorithms, [bench](const Show& show) {
            return show(benchAlgorithms(volumesBench(*bench)), printAlgorithms);
          }};
}

// Lit, modulated by the gradient, half a voxel between slices, as Li's.
std::shared_ptr<FrameBench> litBench(const FrameOptions& plain) {
  auto bench = std::make_shared<FrameBench>();
  bench->frame = plain;
  bench->frame.step_vox = 0.5;
  bench->look.shade = bench->look.modulate = true;
  return bench;
}

Bench addSkipping(CLI::App& app, const FrameOptions& plain) {
  const auto bench = litBench(plain);
  CLI::App* skipping =
      app.add_subcommand("skipping",
                         "Li's Table 1: every block whole against the visible growing boxes, lit "
                         "and modulated by the gradient, half a voxel between slices\n\n"
                         "  sluice bench skipping bonsai.nii.gz@40 engine.nii.gz@80");
  addFrames(*skipping, *bench, kFramesOfEachWay);
  return {skipping, [bench](const Show& show) {
            return show(benchSkipping(volumesBench(*bench)), printSkipping);
          }};
}

Bench addOcclusion(CLI::App& app, const FrameOptions& plain) {
  const auto bench = litBench(plain);
  auto occlusion_bench = std::make_shared<OcclusionBench>();
  CLI::App* occlusion =
      app.add_subcommand("occlusion",
                         "Li's Table 2: growing boxes without and with occlusion culling and "
                         "clipping, surface-like\n\n"
                         "  sluice bench occlusion bonsai.nii.gz@40 engine.nii.gz@80");
  addFrames(*occlusion, *bench, kFramesOfEachWay);
  const OptionGroup output(*occlusion, kOutputHeading);
  output.number("--adapt-frames", "N", occlusion_bench->adapt_frames, {0, 100'000},
                "Frames of each of four views whose numbers of map updates are listed (Figure 6)");
  output.number("--updates", "N", occlusion_bench->updates, {1, 64},
                "Updates of the opacity map in the first frame, from which the number adapts in a "
                "window of 3 to either side; Li's is 9");
  return {occlusion, [=](const Show& show) {
            occlusion_bench->volumes = volumesBench(*bench);
            return show(benchOcclusion(*occlusion_bench), printOcclusion);
          }};
}

Bench addCulling(CLI::App& app, const FrameOptions& plain) {
  auto bench = std::make_shared<CullingBench>();
  bench->frame = plain;
  CLI::App* culling = app.add_subcommand(
      "culling",
      "Gao's figures and table for a series: blocks with and without culling, the optimum, changes "
      "from step to step, thresholds of fusion, and the time of the series\n\n"
      "  sluice bench culling 'step_%03d.nrrd' --threshold 40");
  addPictures(*culling, *bench);
  addCullingOptions(*culling, bench->culling, false);
  const OptionGroup output(*culling, kOutputHeading);
  output.number("--views", "N", bench->views, {1, 360}, "Views of a turn");
  output.flag("--no-optimum", bench->no_optimum,
              "Leaves out the optimum by early ray termination, which reads every step");
  output.flag("--no-thresholds", bench->no_thresholds,
              "Leaves out the thresholds of fusion, which compute all functions five times");
  output.flag("--no-series", bench->no_series, "Does not draw the series");
  return {culling, [bench](const Show& show) { return show(benchCulling(*bench), printCulling); }};
}

Bench addLevels(CLI::App& app, const FrameOptions& plain) {
  auto bench = std::make_shared<FrameBench>();
  bench->frame = plain;
  CLI::App* levels = app.add_subcommand(
      "levels",
      std::string("What coarser levels of resolution cost and save: their error against level 0 "
                  "with four samples a pixel along each axis, bytes, samples and seconds\n\n") +
          kPlainPicture +
          "  sluice bench levels synth:phantom,dims=512x512x512,levels=4 "
          "--size 256x256");
  addFrames(*levels, *bench, kFramesOfEachWay);
  return {levels, [bench](const Show& show) { return show(benchLevels(*bench), printLevels); }};
}

Bench addCut(CLI::App& app, const FrameOptions& plain) {
  auto bench = std::make_shared<CutBench>();
  bench->frame = plain;
  CLI::App* cut = app.add_subcommand(
      "cut",
      "Measures planning pictures of a huge volume with levels of resolution: its min-max arrays "
      "come from a function, and no voxel is read\n\n"
      "  sluice bench cut --dims 16821,7494,2070");
  constexpr NumberRange<double> kDims{128, 65536};
  const Vec3i& dims = bench->dims;
  OptionGroup(*cut, "Volume")
      .numbers(
          "--dims", "X,Y,Z", 3, kDims,
          [bench](const std::vector<double>& values) {
            for (int a = 0; a < 3; ++a)
              bench->dims[a] = static_cast<int64_t>(values[static_cast<size_t>(a)]);
          },
          "Voxels along each axis; a million blocks of 64 take 400 MB of memory",
          fmt::format("{},{},{}", dims.x, dims.y, dims.z));
  addThreadsOption(OptionGroup(*cut, kMachineHeading), bench->threads);
  addFramesOption(OptionGroup(*cut, kOutputHeading), bench->frames, "Plans measured for each kind");
  return {cut, [bench](const Show& show) { return show(benchCut(*bench), printCut); }};
}

Bench addRanks(CLI::App& app, const FrameOptions& plain) {
  auto bench = std::make_shared<RanksBench>();
  bench->frame = plain;
  CLI::App* ranks =
      app.add_subcommand("ranks",
                         "Measures pictures shared among ranks: those of mpirun, or in-process "
                         "ranks of one thread each\n\n"
                         "  mpirun -n 2 sluice bench ranks bonsai.nii.gz --threshold 40");
  addPictures(*ranks, *bench);
  const OptionGroup output(*ranks, kOutputHeading);
  output.parsed(
      "--ranks", "N,...", "numbers from 1 to 64 with commas between", rankCounts,
      [bench](const std::vector<int>& counts) { bench->ranks = counts; },
      "Ranks to measure if no launcher sets their number", "1,2");
  addFramesOption(output, bench->frames, kFrames);
  return {ranks, [bench, ranks](const Show& show) {
            return onRanks([&](Team* team) {
              if (team != nullptr) expectSameCommand(*team, *ranks);
              return show(benchRanks(*bench, team), printRanks);
            });
          }};
}

Bench addThreshold(CLI::App& app, const FrameOptions& plain) {
  auto bench = std::make_shared<ThresholdBench>();
  bench->frame = plain;
  bench->changes = 24;
  CLI::App* threshold = app.add_subcommand(
      "threshold",
      std::string(
          "Measures from a changed threshold to the finished picture: small and large steps, a "
          "random walk and a band; in memory, out of core and cold; and a full rebuild\n\n") +
          kPlainPicture + "  sluice bench threshold bonsai.nii.gz --threshold 40");
  addPictures(*threshold, *bench);
  OptionGroup(*threshold, kOutputHeading)
      .number("--changes", "N", bench->changes, {1, 100'000}, "Changes of each kind");
  return {threshold,
          [bench](const Show& show) { return show(benchThreshold(*bench), printThreshold); }};
}

Bench addWindow(CLI::App& app) {
  auto bench = std::make_shared<FrameBench>();
  auto events = std::make_shared<int>(120);
  auto drag = std::make_shared<DragKind>(DragKind::kThreshold);
  CLI::App* view = app.add_subcommand(
      "view", std::string("Measures the first picture and a drag without a window: from an event "
                          "to its picture, and whether the loop ever waits\n\n") +
                  kPlainPicture +
                  "  sluice bench view bonsai.nii.gz --threshold 40 --size 800x600");
  const AskedView options = addPictures(*view, *bench);
  const OptionGroup output(*view, kOutputHeading);
  output.number("--events", "N", *events, {2, 100'000}, "Events of each of three drags");
  output.choice("--drag",
                Words<DragKind>{{"threshold", DragKind::kThreshold}, {"view", DragKind::kView}},
                *drag, "What the hand moves");
  return {view, [bench, events, drag, options](const Show& show) {
            const ViewState state = viewState(*options, bench->volume, bench->look);
            const IndexWish wish = indexWish(bench->resources.index_dir);
            ViewBench asked;
            if (!wish.disabled) asked.drawing.index_folder = wish.folder.string();
            asked.volume =
                viewedVolume(bench->volume, bench->resources, asked.drawing.index_folder);
            asked.drawing.renderer = rendererOptions(bench->resources);
            asked.drawing.state.look = state.look;
            asked.drawing.state.view = state.view;
            asked.drawing.state.step_vox = state.step_vox;
            asked.width = bench->frame.size.width;
            asked.height = bench->frame.size.height;
            asked.threshold = bench->look.threshold.value_or(0);
            asked.events = *events;
            asked.drag = *drag;
            return show(benchView(asked), printView);
          }};
}

Bench addPacking(CLI::App& app) {
  auto bench = std::make_shared<FrameBench>();
  CLI::App* packing = app.add_subcommand(
      "packing", "Measures compression of a volume's blocks in memory, by codec, on one core");
  addVolumeOptions(*packing, bench->volume);
  addResourceOptions(*packing, bench->resources);
  return {packing, [bench](const Show& show) {
            return show(benchPacking(bench->volume, bench->resources), printPacking);
          }};
}

Bench addSimulator(CLI::App& app) {
  return {app.add_subcommand("simulate",
                             "Measures the simulator's page requests per second, on one core"),
          [](const Show& show) { return show(simulatorReport(), printSimulator); }};
}

Bench addSlicing(CLI::App& app) {
  return {
      app.add_subcommand(
          "slicing",
          "Measures cutting boxes by a view's slices, incrementally and from scratch, on one core"),
      [](const Show& show) { return show(slicingReport(), printSlicing); }};
}

// A report may not replace a file that the bench reads by name, nor a file that is no report.
// --force is not for benches, since only the volume's reader would know all files that it reads.
Outputs outputsOf(const CLI::App& app, const std::string& report) {
  Outputs outputs;
  for (const CLI::Option* option : app.get_options()) {
    const std::string type = option->get_type_name();
    const bool is_read = type == "VOLUME" || type == "FILE" || type == "FILE,...";
    if (!is_read || option->check_lname("report")) continue;
    for (const std::string& word : option->results()) {
      std::stringstream names(word);
      for (std::string name; std::getline(names, name, ',');)
        outputs.reads(std::filesystem::path(name));
    }
  }
  outputs.writes("--report", report, reportKind(report));
  return outputs;
}

// The destination of a report.
struct ReportOutput {
  std::string file;
  bool json = false;
};

}  // namespace

Command addBench(CLI::App& program) {
  FrameOptions plain;
  plain.camera.azimuth_deg = 30;
  plain.camera.elevation_deg = 20;
  CLI::App* app =
      program.add_subcommand("bench", std::string("Measures speeds\n\n") + kPlainPicture +
                                          "  sluice bench render bonsai.nii.gz --threshold 40");
  app->require_subcommand(1);
  const std::vector<Bench> benches{addLimit(*app),
                                   addRender(*app, plain),
                                   addSimulator(*app),
                                   addSlicing(*app),
                                   addAlgorithms(*app, plain),
                                   addSkipping(*app, plain),
                                   addOcclusion(*app, plain),
                                   addCulling(*app, plain),
                                   addLevels(*app, plain),
                                   addCut(*app, plain),
                                   addRanks(*app, plain),
                                   addThreshold(*app, plain),
                                   addPacking(*app),
                                   addWindow(*app)};
  auto output = std::make_shared<ReportOutput>();
  for (const Bench& bench : benches) {
    const OptionGroup group(*bench.app, kOutputHeading);
    addReportOption(group, output->file);
    addJsonOption(group, output->json);
  }
  const Command compare = addBenchReport(*app);
  return [=] {
    for (const Bench& bench : benches) {
      if (!bench.app->parsed()) continue;
      outputsOf(*bench.app, output->file).check();
      return bench.run([&](json report, Print print) -> int {
        report.update(
            {{"command", "bench " + bench.app->get_name()}, {"options", optionsJson(*bench.app)}});
        if (!output->file.empty()) writeReport(output->file, report);
        if (output->json)
          sayJson(report);
        else
          print(report);
        return kDone;
      });
    }
    return compare();
  };
}

}  // namespace sluice
