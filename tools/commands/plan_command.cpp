// sluice plan: the cost of a picture, level by level and algorithm by algorithm, from the min-max
// arrays alone: no voxel is read, unless the partition into growing boxes is asked for.
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <memory>
#include <optional>

#include "src/base/error.h"
#include "src/base/threads/clock.h"
#include "src/base/values/bytes.h"
#include "src/index/box_store.h"
#include "src/index/volume_boxes.h"
#include "src/library/drawing/picture_cost.h"
#include "tools/command_line/console.h"
#include "tools/command_line/interrupt.h"
#include "tools/command_line/progress_line.h"
#include "tools/commands/commands.h"
#include "tools/commands/plan_forecast.h"
#include "tools/options/shared_options.h"
#include "tools/outputs/report.h"
#include "tools/pages/report_file.h"
#include "tools/scene/scene.h"
#include "tools/scene/series.h"
#include "tools/scene/workers.h"

namespace sluice {
namespace {

struct PlanArguments {
  VolumeArguments volume;
  LookArguments look;
  FrameOptions frame;
  LevelArguments levels;
  CullingArguments culling;
  ResourceArguments resources;
  FitChoice fit;
  std::string report_file;
  bool force = false;
  bool json = false;
};

// The blocks of a series that others hide, from the functions that `prepare` made.
struct PlannedCulling {
  PlannedCulling(const SeriesOpacityPtr& functions, const VolumeLayout& layout,
                 const CullingOptions& options, WorkerPool& pool, uint64_t bytes)
      : blocks(functions, layout, options, pool), most_bytes(bytes) {}

  CulledBlocks blocks;
  const uint64_t most_bytes;  // of the functions and of the estimate
};

std::unique_ptr<PlannedCulling> plannedCulling(const PlanArguments& arguments,
                                               const IndexedVolume& volume,
                                               const TransferFunction& transfer, WorkerPool& pool) {
  const CullingArguments& culling = arguments.culling;
  if (culling.culling == Culling::kNone) return nullptr;
  const uint64_t memory_bytes = memoryBudget(arguments.resources);
  ProgressMeter progress;
  std::optional<SeriesFunctions> functions =
      keptSeriesFunctions(volume, transfer, seriesOptions(culling, volume),
                          {pool, progress, memory_bytes, interruption()});
  if (!functions)
    fail(
        "{}: the series is not prepared for this look, which --culling needs; sluice prepare does "
        "it",
        arguments.volume.inputs.front());
  const CullingOptions options =
      cullingOptions(culling.culling, arguments.frame, *functions, memory_bytes);
  const SeriesOpacityPtr opacity = functions->opacity();
  return std::make_unique<PlannedCulling>(
      opacity, volume.source->layout(), options, pool,
      opacity->bytes() +
          CulledBlocks::mostBytes(*opacity, arguments.frame.size, options, pool.threads()));
}

void print(const AlgorithmCosts& costs, Algorithm algorithm, double classify_seconds,
           const PageGeometry& page) {
  say("{:<13} {:>8} {:>9} {:>12} {:>7}   pages of {}, {} in the cache\n", "algorithm", "chunks",
      "pages", "bytes", "binds", printPageSize(page.size_vox), page.pages);
  for (size_t i = 0; i < costs.size(); ++i)
    say("{:<13} {:>8} {:>9} {:>12} {:>7}\n", name(kAlgorithms[i]), costs[i].chunks, costs[i].pages,
        formatBytes(costs[i].bytes), costs[i].binds);
  const AlgorithmCost& chosen = costs[static_cast<size_t>(algorithm)];
  say("{} cluster{} of {} x {} blocks; classified in {:.2f} ms, planned in {:.2f} ms\n",
      chosen.clusters, chosen.clusters == 1 ? "" : "s", chosen.cluster_blocks.x,
      chosen.cluster_blocks.y, 1e3 * classify_seconds, 1e3 * chosen.seconds);
}

// Growing boxes, compared with the two partitions that they lie between: one object box a block,
// and bricks that know the transfer function.
struct PlannedBoxes {
  PartitionCost cost;
  int64_t object_boxes = 0, object_cells = 0;
  int64_t pieces_kept = 0;  // pieces of the index
  double seconds = 0;
};

PlannedBoxes planBoxes(const PlanArguments& arguments, const IndexedVolume& volume,
                       const PlannedBlocks& shown, WorkerPool& pool) {
  const SliceRanges& ranges = volume.index->ranges;
  const Box3 crop = cropCells(arguments.frame, ranges.layout.dims);
  PlannedBoxes planned;
  for (const ObjectBlock& block : shown.blocks->blocks) {
    ++planned.object_boxes;
    planned.object_cells += block.cells.count();
  }
  Stopwatch watch;
  ProgressMeter progress =
      arguments.resources.quiet ? ProgressMeter() : ProgressMeter(progressLine("growing boxes"));
  // The pass is made for the bricks; the boxes that a picture needs are kept on the way.
  BoxIndexWriter index(*volume.source, volume.places, arguments.volume.time, ranges);
  planned.cost = partitionCost(
      *volume.source, arguments.volume.time, ranges, shown.look->table, crop, pool, progress,
      std::min(memoryBudget(arguments.resources) / 2, kMostGrowingBytes),
      [&](int64_t block, const BoxTree& tree) { index.add(block, tree); }, interruption());
  planned.pieces_kept = index.piecesWritten();
  planned.seconds = watch.lap();
  return planned;
}

void print(const PlannedBoxes& planned) {
  const PartitionCost& cost = planned.cost;
  const auto share = [&](int64_t cells) {
    return cost.perfect_cells == 0
               ? 0.0
               : static_cast<double>(cells) / static_cast<double>(cost.perfect_cells);
  };
  say("\n{:<16} {:>9} {:>14} {:>9}   cells that a frame samples\n", "partition", "visible", "cells",
      "of 8^3");
  say("{:<16} {:>9} {:>14} {:>9.2f}\n", "object boxes", planned.object_boxes, planned.object_cells,
      share(planned.object_cells));
  say("{:<16} {:>9} {:>14} {:>9.2f}\n", "growing boxes", cost.visible_boxes, cost.visible_cells,
      share(cost.visible_cells));
  say("{:<16} {:>9} {:>14} {:>9.2f}\n", "bricks of 8^3", cost.perfect_bricks, cost.perfect_cells,
      share(cost.perfect_cells));
  say("{} boxes grown, {} in BSP trees ({} uniform, {} gradient, {} other) with {} textures; "
      "{} blocks read and partitioned in {:.2f} s\n",
      cost.grown, cost.boxes, cost.types[0], cost.types[1], cost.types[2], cost.textures,
      cost.blocks, planned.seconds);
}

nlohmann::json boxesJson(const PlannedBoxes& planned) {
  const PartitionCost& cost = planned.cost;
  return {{"boxes", cost.boxes},
          {"grown_boxes", cost.grown},
          {"textures", cost.textures},
          {"uniform_boxes", cost.types[0]},
          {"gradient_boxes", cost.types[1]},
          {"other_boxes", cost.types[2]},
          {"visible_boxes", cost.visible_boxes},
          {"visible_cells", cost.visible_cells},
          {"object_boxes", planned.object_boxes},
          {"object_cells", planned.object_cells},
          {"perfect_bricks", cost.perfect_bricks},
          {"perfect_cells", cost.perfect_cells},
          {"blocks_read", cost.blocks},
          {"index_pieces", planned.pieces_kept},
          {"seconds", planned.seconds}};
}

nlohmann::json reportOf(const AlgorithmCosts& costs, const AlgorithmCost& chosen,
                        const Forecast& forecast, const std::optional<PlannedBoxes>& boxes,
                        const IndexedVolume& volume, const TransferFunction& transfer,
                        const PlannedBlocks& shown, const CLI::App& app) {
  nlohmann::json report{{"command", "plan"},
                        {"options", optionsJson(app)},
                        {"volume", volumeJson(volume)},
                        {"transfer", transfer.name},
                        {"blocks",
                         {{"white", shown.blocks->white},
                          {"grey", shown.blocks->grey},
                          {"black", shown.blocks->black}}},
                        {"clusters", chosen.clusters},
                        {"read", readJson(forecast)},
                        {"memory", memoryJson(forecast)},
                        {"classify_seconds", shown.seconds},
                        {"plan_seconds", chosen.seconds},
                        {"seconds", shown.seconds + chosen.seconds}};
  for (size_t i = 0; i < costs.size(); ++i)
    report["algorithms"][std::string(name(kAlgorithms[i]))] = {{"chunks", costs[i].chunks},
                                                               {"pages", costs[i].pages},
                                                               {"bytes", costs[i].bytes},
                                                               {"binds", costs[i].binds}};
  if (boxes) report["partition"] = boxesJson(*boxes);
  if (shown.blocks->cut) report["cut"] = cutJson(*shown.blocks->cut);
  return report;
}

// A volume with its look and the camera fitted to it.
struct PlannedVolume {
  IndexedVolume volume;
  TransferFunction transfer;
  Camera camera;
};

PlannedVolume openPlanned(const PlanArguments& arguments, FinestLevel finest,
                          const Outputs& outputs, WorkerPool& pool) {
  const FrameOptions& frame = arguments.frame;
  PlannedVolume planned;
  planned.volume = openIndexed(arguments.volume, arguments.resources,
                               pictureNeeds(arguments.look, frame, finest), pool, outputs);
  planned.transfer = lookFor(planned.volume, arguments.look, frame.mode).transfer;
  std::vector<Camera> cameras{frame.camera};
  fitCameras(
      cameras, arguments.fit,
      {planned.volume, planned.volume.step(), planned.transfer, frame, arguments.look.this_step},
      {}, arguments.resources, pool);
  planned.camera = cameras.front();
  return planned;
}

// Whether the plan is of a picture with culling. Throws Error if it cannot be.
bool checkCulling(const PlanArguments& arguments) {
  const Culling culling = arguments.culling.culling;
  if (culling == Culling::kNone) return false;
  if (culling == Culling::kAuto)
    fail("--culling auto measures pictures; plan takes none, pof, opof or toc");
  if (!traitsOf(arguments.frame.mode).hides)
    fail("--culling needs --mode composite, since other modes hide nothing");
  refuseLevels(arguments.levels, "--culling plans the finest level alone");
  return true;
}

int run(const PlanArguments& asked, const CLI::App& app) {
  PlanArguments arguments = asked;
  Workers pool(arguments.resources.threads);
  if (arguments.frame.partition == Partition::kBoxes)
    refuseLevels(arguments.levels, "--partition boxes plans the finest level alone");
  if (checkCulling(arguments))
    arguments.look.whole_series = true;
  else
    arguments.frame.cut = cutOptions(arguments.levels, arguments.resources, arguments.look,
                                     arguments.frame, PictureRow::kOne);
  Outputs outputs(arguments.force);
  outputs.reads(arguments.volume.inputs);
  outputs.reads(arguments.look.transfer_file);
  outputs.writes("--report", arguments.report_file, reportKind(arguments.report_file));
  PlannedVolume planned = openPlanned(arguments, FinestLevel::kMayWait, outputs, pool);
  if (mustReadFinest(planned.volume, planned.transfer, arguments.frame, {&planned.camera, 1}, pool))
    planned = openPlanned(arguments, FinestLevel::kRead, outputs, pool);
  IndexedVolume& volume = planned.volume;
  const TransferFunction& transfer = planned.transfer;
  arguments.frame.camera = planned.camera;
  const std::unique_ptr<PlannedCulling> culling = plannedCulling(arguments, volume, transfer, pool);
  const PlannedBlocks shown =
      plannedBlocks(volume, volume.step(), transfer, arguments.frame, volume.page,
                    culling ? &culling->blocks : nullptr, pool);
  const uint64_t others =
      othersBytes(volume, transfer, arguments.frame, pool) + (culling ? culling->most_bytes : 0);
  volume.page.pages = besideShare(volume, arguments.resources, arguments.frame.partition,
                                  pictureDemand(arguments.resources, arguments.frame), others)
                          .pages;
  const AlgorithmCosts costs = algorithmCosts(volume, shown, arguments.frame, volume.page, pool);
  const AlgorithmCost& chosen = costs[static_cast<size_t>(arguments.frame.algorithm)];
  std::optional<PlannedBoxes> boxes;
  if (arguments.frame.partition == Partition::kBoxes)
    boxes = planBoxes(arguments, volume, shown, pool);
  const Forecast forecast = forecastOf(volume, *shown.blocks, volume.page, chosen.bytes, others,
                                       arguments.frame, arguments.resources);
  nlohmann::json report = reportOf(costs, chosen, forecast, boxes, volume, transfer, shown, app);
  if (culling) report["culling"] = countsJson(culling->blocks.counts());
  if (!arguments.report_file.empty()) {
    PagePictures pictures;
    if (isPage(arguments.report_file) && !isCoarser(*shown.blocks))
      addBlocks(pictures, volume.step().ranges->layout.grid, *shown.blocks);
    writeReport(arguments.report_file, report, pictures);
  }
  if (arguments.json) {
    sayJson(report);
  } else if (!arguments.resources.quiet) {
    print(costs, arguments.frame.algorithm, shown.seconds, volume.page);
    if (isCoarser(*shown.blocks)) say("{}\n", cutLine(*shown.blocks->cut));
    printForecast(forecast);
    if (culling)
      say("culling: {} of {} blocks that are not empty can be seen\n",
          culling->blocks.counts().blocks_visible, culling->blocks.counts().blocks_nonempty);
    if (volume.stand_in) say("{}\n", volume.standInNote());
    if (!volume.stand_in && volume.index->state != "read")
      say("index {}: this plan has read the whole volume for it, {}\n", volume.index->state,
          volume.index->path.empty() ? "and so will the next one" : "the next one reads no voxel");
    if (boxes) print(*boxes);
  }
  return 0;
}

}  // namespace

Command addPlan(CLI::App& program) {
  auto arguments = std::make_shared<PlanArguments>();
  CLI::App* app = program.add_subcommand(
      "plan",
      "Prints what a picture will read, load and hold, without reading a voxel\n\n"
      "  sluice plan bonsai.nii.gz --threshold 40 --page 32x64x2 --pages 256\n"
      "  sluice plan bonsai.nii.gz --threshold 40 --partition boxes");
  addVolumeOptions(*app, arguments->volume);
  addPictureOptions(*app, arguments->look, arguments->frame, arguments->fit);
  addCullingOptions(*app, arguments->culling, true);
  addLevelOptions(*app, arguments->levels, arguments->resources);
  addResourceOptions(*app, arguments->resources);
  const OptionGroup output(*app, kOutputHeading);
  addReportOption(output, arguments->report_file);
  addForceOption(output, arguments->force);
  addQuietOption(output, arguments->resources.quiet);
  addJsonOption(output, arguments->json);
  return [arguments, app] { return run(*arguments, *app); };
}

}  // namespace sluice
