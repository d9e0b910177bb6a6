// sluice bench culling: the results of Gao 2004 on culling over a series: blocks drawn per step
// with culling and without (Figure 7), coherent blocks (Figure 9), pixels checked (Figure 10), the
// optimum against POF and OPOF over 18 views (Figure 11), fusion thresholds (Table 1), blocks a
// rank (Figure 12), and the time of the whole series.
#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <memory>
#include <numeric>

#include "src/base/files/descriptor.h"
#include "src/base/threads/clock.h"
#include "src/library/opening/step_ranges.h"
#include "src/parallel/dealing.h"
#include "src/visibility/occlusion/early_termination.h"
#include "src/volume/voxels/device_reader.h"
#include "tools/bench/bench.h"
#include "tools/bench/culling_print.h"
#include "tools/command_line/console.h"
#include "tools/options/shared_options.h"
#include "tools/scene/open_scene.h"
#include "tools/scene/series.h"

namespace sluice {
namespace {

using nlohmann::json;

struct CullingBench : BenchArguments {
  CullingArguments culling;
  int views = 18;              // views of a turn
  bool no_optimum = false;     // early ray termination at block level: reads every step whole
  bool no_series = false;      // drawn with each way of culling, from cold files
  bool no_thresholds = false;  // Table 1: makes the functions five times
};

constexpr std::array<double, 5> kDifferences = {0, 1e-5, 1e-4, 1e-3, 1e-2};  // Table 1
constexpr std::array<std::pair<const char*, Culling>, 3> kCullings = {
    {{"none", Culling::kNone}, {"opof", Culling::kOpof}, {"toc", Culling::kToc}}};

// Data that all parts of the bench use.
struct Opened {
  explicit Opened(const CullingBench& bench)
      : pool(bench.resources.threads),
        volume(openIndexed(bench.volume, bench.resources, needsOf(bench.look, Mode::kComposite),
                           pool)),
        look(lookFor(volume, bench.look, Mode::kComposite)) {
    ProgressMeter progress;
    for (int64_t time = 0; time < volume.source->layout().time_steps; ++time)
      steps.push_back(stepOfSeries(volume, time, passOf(pool, progress, bench.resources)));
    shown = std::make_shared<const Look>(makeLook(steps.front(), look.transfer, Mode::kComposite));
  }
  const VolumeLayout& layout() const { return volume.source->layout(); }
  BlockQuestion question(const FrameOptions& frame, size_t step) const {
    return {steps[step], shown, cropCells(frame, layout().dims), resolve(frame, layout())};
  }

  Workers pool;
  IndexedVolume volume;
  ChosenLook look;
  std::vector<TimeStep> steps;
  LookPtr shown;
};

// Views of a turn, the bench's own first.
FrameOptions viewOf(const CullingBench& bench, int view) {
  FrameOptions frame = bench.frame;
  frame.camera.azimuth_deg += 360.0 * view / bench.views;
  return frame;
}

std::vector<std::byte> wholeStep(const Opened& opened, int64_t time) {
  const Box3 all = boxOf(opened.layout().dims);
  std::vector<std::byte> voxels(static_cast<size_t>(all.count()) *
                                bytesPerVoxel(opened.volume.map.type));
  DeviceReader(*opened.volume.source).read(time, {all, voxels});
  return voxels;
}

// Non-empty blocks that early ray termination sees.
int64_t optimumOf(Opened& opened, const CullingBench& bench, const FrameOptions& frame,
                  const std::vector<std::byte>& voxels, size_t step) {
  const View view = resolve(frame, opened.layout());
  const std::vector<bool> reached =
      reachedByRays({opened.layout().dims, opened.volume.map.type, voxels},
                    opened.volume.layout.cells(), opened.shown->table,
                    estimateView(view, opened.layout()), hidingThreshold(bench.frame), opened.pool);
  const auto classified = ClassifiedBlocks(opened.pool).choose(opened.question(frame, step));
  return std::count_if(
      classified->blocks.begin(), classified->blocks.end(),
      [&](const ObjectBlock& block) { return reached[static_cast<size_t>(block.name.block)]; });
}

CulledBlocks culledBy(Opened& opened, const CullingBench& bench, const SeriesFunctions& functions,
                      Culling culling) {
  return {functions.opacity(), opened.layout(),
          cullingOptions(culling, bench.frame, functions, memoryBudget(bench.resources)),
          opened.pool};
}

// The paper's own form: opacity in proportion to the thickness.
CulledBlocks culledLinearly(Opened& opened, const CullingBench& bench,
                            const SeriesFunctions& functions) {
  CullingOptions options =
      cullingOptions(Culling::kOpof, bench.frame, functions, memoryBudget(bench.resources));
  options.form = OpacityForm::kLinearOpof;
  return {functions.opacity(), opened.layout(), options, opened.pool};
}

// Figures 7, 9 and 10 under one view.
json rowsOf(Opened& opened, const CullingBench& bench, const SeriesFunctions& functions) {
  json rows = json::array();
  std::array<CulledBlocks, 4> ways = {culledBy(opened, bench, functions, Culling::kPof),
                                      culledLinearly(opened, bench, functions),
                                      culledBy(opened, bench, functions, Culling::kOpof),
                                      culledBy(opened, bench, functions, Culling::kToc)};
  constexpr std::array<const char*, 4> kNames = {"pof", "linear_opof", "opof", "toc"};
  const SeriesPassReport& pass = functions.kept->report;
  for (size_t step = 0; step < opened.steps.size(); ++step) {
    json row{{"time", step}};
    for (size_t way = 0; way < ways.size(); ++way) {
      ways[way].choose(opened.question(bench.frame, step));
      const CullingCounts& counts = ways[way].counts();
      row["blocks_nonempty"] = counts.blocks_nonempty;
      row["visible"][kNames[way]] = counts.blocks_visible;
      row["estimate_seconds"][kNames[way]] = counts.estimate_seconds;
      row["pixels_checked"][kNames[way]] = counts.pixels_checked;
      row["changed_blocks"] = counts.changed_blocks;
    }
    if (!bench.no_optimum)
      row["visible"]["optimum"] = optimumOf(opened, bench, bench.frame,
                                            wholeStep(opened, static_cast<int64_t>(step)), step);
    if (step > 0) {
      const int64_t blocks = pass.blocks[step - 1], coherent = pass.coherent[step - 1];
      row["compared_blocks"] = blocks;
      row["coherent_blocks"] = coherent;
      row["coherent_share"] =
          blocks == 0 ? 1.0 : static_cast<double>(coherent) / static_cast<double>(blocks);
    }
    rows.push_back(row);
  }
  return rows;
}

// Figure 11.
json viewsOf(Opened& opened, const CullingBench& bench, const SeriesFunctions& functions) {
  json rows = json::array();
  const size_t step = opened.steps.size() / 2;
  const auto voxels =
      !bench.no_optimum ? wholeStep(opened, static_cast<int64_t>(step)) : std::vector<std::byte>();
  for (int view = 0; view < bench.views; ++view) {
    const FrameOptions frame = viewOf(bench, view);
    json row{{"azimuth", frame.camera.azimuth_deg}, {"time", step}};
    for (const auto& [name, culling] :
         {std::pair{"pof", Culling::kPof}, {"opof", Culling::kOpof}}) {
      CulledBlocks culled = culledBy(opened, bench, functions, culling);
      culled.choose(opened.question(frame, step));
      row["blocks_nonempty"] = culled.counts().blocks_nonempty;
      row["visible"][name] = culled.counts().blocks_visible;
    }
    CulledBlocks linear = culledLinearly(opened, bench, functions);
    linear.choose(opened.question(frame, step));
    row["visible"]["linear_opof"] = linear.counts().blocks_visible;
    if (!bench.no_optimum)
      row["visible"]["optimum"] = optimumOf(opened, bench, frame, voxels, step);
    rows.push_back(row);
  }
  return rows;
}

// Figure 7: the mean of all views, a step.
json averageOf(Opened& opened, const CullingBench& bench, const SeriesFunctions& functions) {
  std::vector<double> nonempty(opened.steps.size()), visible(opened.steps.size());
  for (int view = 0; view < bench.views; ++view) {
    const FrameOptions frame = viewOf(bench, view);
    CulledBlocks culled = culledBy(opened, bench, functions, Culling::kToc);
    for (size_t step = 0; step < opened.steps.size(); ++step) {
      culled.choose(opened.question(frame, step));
      nonempty[step] += static_cast<double>(culled.counts().blocks_nonempty) / bench.views;
      visible[step] += static_cast<double>(culled.counts().blocks_visible) / bench.views;
    }
  }
  json rows = json::array();
  for (size_t step = 0; step < nonempty.size(); ++step)
    rows.push_back(
        {{"time", step}, {"blocks_nonempty", nonempty[step]}, {"visible", visible[step]}});
  return rows;
}

// Figure 12: visible blocks of each rank, by dealing them out; nothing runs on several.
json ranksOf(Opened& opened, const CullingBench& bench, const SeriesFunctions& functions) {
  std::vector<VisibleBlocksPtr> steps;
  CulledBlocks culled = culledBy(opened, bench, functions, Culling::kToc);
  for (size_t step = 0; step < opened.steps.size(); ++step)
    steps.push_back(culled.choose(opened.question(bench.frame, step)));
  const auto ratio = [](const std::vector<int64_t>& counts) {
    const auto sum = static_cast<double>(std::accumulate(counts.begin(), counts.end(), int64_t{0}));
    const auto most = static_cast<double>(*std::max_element(counts.begin(), counts.end()));
    return sum > 0 ? most * static_cast<double>(counts.size()) / sum : 1;
  };
  const BlockLayout& layout = opened.volume.layout;
  json rows = json::array();
  for (const int ranks : {2, 4, 8, 16, 32}) {
    const Dealing dealing = dealBlocks(layout, ranks);
    std::vector<int64_t> all(static_cast<size_t>(ranks)), dealt_once(all.size());
    json of_steps = json::array();
    double worst = 1;
    for (size_t step = 0; step < steps.size(); ++step) {
      std::vector<int64_t> counts(all.size());
      for (const int32_t rank : dealPicture(dealing, layout, *steps[step]))
        ++counts[static_cast<size_t>(rank)];
      for (const ObjectBlock& block : steps[step]->blocks)
        ++dealt_once[static_cast<size_t>(dealing.rankOf(layout.indexOf(block.name.block)))];
      for (size_t r = 0; r < all.size(); ++r) all[r] += counts[r];
      worst = std::max(worst, ratio(counts));
      of_steps.push_back({{"time", step}, {"blocks", counts}, {"most_to_mean", ratio(counts)}});
    }
    rows.push_back({{"ranks", ranks},
                    {"hand_blocks", dealing.hand},
                    {"blocks", all},
                    {"most_to_mean", ratio(all)},
                    {"most_to_mean_of_worst_step", worst},
                    {"most_to_mean_dealt_once", ratio(dealt_once)},
                    {"steps", of_steps}});
  }
  return rows;
}

// The size if each representative block had a function of its own, even if others share it.
uint64_t unsharedBytes(const SeriesOpacity& series) {
  uint64_t sum = 0;
  for (const CoherentSpan& span : series.spans)
    sum += sizeof(span) + series.functions[static_cast<size_t>(span.function)].bytes();
  return sum;
}

// Table 1.
json fusionOf(Opened& opened, const CullingBench& bench) {
  json rows = json::array();
  for (const double difference : kDifferences) {
    SeriesOptions options = seriesOptions(bench.culling, opened.volume);
    options.difference = difference;
    options.anew = true;
    ProgressMeter progress;
    const SeriesFunctions functions =
        seriesFunctions(opened.volume, opened.look.transfer, options,
                        passOf(opened.pool, progress, bench.resources));
    CulledBlocks culled = culledBy(opened, bench, functions, Culling::kToc);
    int64_t visible = 0;
    for (size_t step = 0; step < opened.steps.size(); ++step) {
      culled.choose(opened.question(bench.frame, step));
      visible += culled.counts().blocks_visible;
    }
    const SeriesPassReport& pass = functions.kept->report;
    rows.push_back({{"difference", difference},
                    {"precompute_seconds", pass.functions_seconds + pass.tree_seconds},
                    {"read_seconds", pass.read_seconds},
                    {"fusion_seconds", pass.fusion_seconds},
                    {"bytes", functions.bytes},
                    {"bytes_unshared", unsharedBytes(functions.kept->opacity)},
                    {"spans", functions.kept->opacity.spans.size()},
                    {"coherent_share", pass.coherentShare()},
                    {"visible_blocks", visible}});
  }
  return rows;
}

// Of the tree of coherent spans (section 5).
json treeOf(const SeriesFunctions& functions) {
  const std::optional<TocTree>& tree = functions.kept->opacity.tree;
  return {{"seconds", functions.kept->report.tree_seconds},
          {"bytes", tree ? tree->bytes() : 0},
          {"nodes", tree ? tree->nodes() : 0}};
}

// So that the next read comes from the disk.
void dropFromMemory(const std::vector<std::string>& files) {
  for (const std::string& file : files) {
    const Descriptor opened(open(file.c_str(), O_RDONLY | O_CLOEXEC));
    if (!opened) continue;
    // Only pages that are on the disk can be dropped.
    fdatasync(opened.get());
    posix_fadvise(opened.get(), 0, 0, POSIX_FADV_DONTNEED);
  }
}

// The whole series with each way, from cold files; pictures are not written.
void drawSeries(const CullingBench& bench, json& report) {
  for (const auto& [name, culling] : kCullings) {
    CullingArguments how = bench.culling;
    how.culling = culling;
    Scene scene = openScene(bench.volume, bench.look, bench.resources, bench.frame);
    if (culling == Culling::kNone) warnOfIdle(bench, scene, bench.frame);
    Series series(scene, how, bench.resources, bench.frame);
    scene.session->setOptions(bench.frame);
    dropFromMemory(scene.volume.source->files());
    const uint64_t before = scene.volume.source->storedBytesRead();
    const Stopwatch watch;
    const int64_t steps = scene.volume.source->layout().time_steps;
    for (int64_t time = 0; time < steps; ++time) {
      // The next step is told, so that it is read while this one is drawn.
      series.show(time, time + 1 < steps ? std::optional(time + 1) : std::nullopt);
      scene.session->frameReport();
    }
    report["series_seconds"][name] = watch.seconds();
    report["series_read_bytes"][name] = scene.volume.source->storedBytesRead() - before;
  }
}

// The names of the interface, and in addition `views` [{`azimuth`, `blocks_nonempty`, `visible`}]
// of the first step and `average` [{`time`, `blocks_nonempty`, `visible`}] over all views, and
// `ranks` [{`ranks`, `blocks` of each over all steps, `most_to_mean`, `most_to_mean_dealt_once`,
// `steps`}]. Throws Error.
json benchCulling(const CullingBench& asked) {
  checkBasis(asked.culling);
  CullingBench bench = asked;
  // Functions of opacity are made for one transfer function of all steps.
  bench.look.whole_series = true;
  Opened opened(bench);
  const SeriesFunctions functions = openFunctions(opened.volume, opened.look.transfer,
                                                  bench.culling, bench.resources, opened.pool);
  json report{{"rows", rowsOf(opened, bench, functions)},
              {"views", viewsOf(opened, bench, functions)},
              {"average", averageOf(opened, bench, functions)},
              {"ranks", ranksOf(opened, bench, functions)},
              {"coherent_share", functions.kept->report.coherentShare()},
              {"function_bytes", functions.bytes},
              {"tree", treeOf(functions)}};
  if (!bench.no_thresholds) report["fusion"] = fusionOf(opened, bench);
  if (!bench.no_series)
    drawSeries(bench, report);
  else if (bench.app->count("--quality") > 0)
    printWarning(opened.volume.name +
                 ": --quality changes nothing with --no-series, which draws no picture");
  return report;
}

}  // namespace

Bench addCullingBench(CLI::App& app) {
  auto bench = std::make_shared<CullingBench>();
  bench->frame = plainFrame();
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

}  // namespace sluice
