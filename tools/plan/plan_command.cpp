// sluice plan: the cost of a picture, level by level and algorithm by algorithm, from the min-max
// arrays alone: no voxel is read, unless the partition into growing boxes is asked for.
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <memory>
#include <optional>

#include "io/web/address.h"
#include "src/base/error.h"
#include "src/base/threads/clock.h"
#include "src/base/values/bytes.h"
#include "src/library/drawing/device_choice.h"
#include "src/library/drawing/picture_cost.h"
#include "src/library/opening/thick_source.h"
#include "tools/command_line/console.h"
#include "tools/command_line/interrupt.h"
#include "tools/command_line/progress_line.h"
#include "tools/commands/commands.h"
#include "tools/options/idle_options.h"
#include "tools/options/picture_checks.h"
#include "tools/options/shared_options.h"
#include "tools/outputs/cut_report.h"
#include "tools/outputs/report.h"
#include "tools/pages/report_file.h"
#include "tools/plan/plan_boxes.h"
#include "tools/plan/plan_forecast.h"
#include "tools/plan/plan_server.h"
#include "tools/plan/planned_channel.h"
#include "tools/scene/open_scene.h"
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
        withoutSecrets(arguments.volume.inputs.front()));
  const CullingOptions options =
      cullingOptions(culling.culling, arguments.frame, *functions, memory_bytes);
  const SeriesOpacityPtr opacity = functions->opacity();
  return std::make_unique<PlannedCulling>(
      opacity, volume.source->layout(), options, pool,
      opacity->bytes() +
          CulledBlocks::mostBytes(*opacity, arguments.frame.size, options, pool.threads()));
}

// The channels, and the camera fitted to them.
struct PlannedPicture {
  std::vector<PlannedChannel> channels;
  Camera camera;
};

PlannedPicture openPlanned(const PlanArguments& arguments, FinestLevel finest,
                           const Outputs& outputs, WorkerPool& pool) {
  const FrameOptions& frame = arguments.frame;
  PlannedPicture planned;
  std::vector<FittedVolume> fitted;
  std::vector<const ShownChannel*> shown;
  for (IndexedVolume& volume : openIndexedChannels(
           arguments.volume, arguments.look, arguments.resources, frame, finest, pool, outputs)) {
    TransferFunction transfer = lookFor(volume, arguments.look, frame.mode).transfer;
    planned.channels.push_back({std::move(volume), std::move(transfer)});
  }
  for (const PlannedChannel& channel : planned.channels) {
    fitted.push_back({channel.volume, channel.volume.step(), channel.transfer});
    shown.push_back(&channel.volume.channel);
  }
  requireShown(arguments.look, shown);
  std::vector<const IndexedVolume*> volumes;
  for (const PlannedChannel& channel : planned.channels) volumes.push_back(&channel.volume);
  requireBlendable(arguments.look, frame, volumes);
  std::vector<Camera> cameras{frame.camera};
  fitCameras(cameras, arguments.fit, {std::move(fitted), frame, arguments.look.this_step}, {},
             arguments.resources, pool);
  planned.camera = cameras.front();
  return planned;
}

PictureArguments pictureOf(const PlanArguments& arguments) {
  return {arguments.look, arguments.frame, arguments.culling, arguments.levels,
          arguments.resources};
}

// The same refusals as of a picture that is drawn, and those of a plan. Throws Error.
void check(const PlanArguments& arguments) {
  checkPicture(pictureOf(arguments));
  if (arguments.culling.culling == Culling::kAuto)
    fail("--culling auto measures pictures; plan takes none, pof, opof or toc");
  if (arguments.frame.partition == Partition::kBoxes)
    refuseLevels(arguments.levels, "--partition boxes plans the finest level alone");
}

// The arguments of each of so many channels, which share the memory as a scene's do.
PlanArguments shareOf(PlanArguments arguments, size_t channels) {
  if (channels == 1) return arguments;
  arguments.resources.memory_bytes = memoryBudget(arguments.resources) / channels;
  if (arguments.frame.cut) arguments.frame.cut = shareOf(*arguments.frame.cut, channels);
  return arguments;
}

// The pages of a channel, and what is held in addition to the levels.
void shareOut(const PlanArguments& arguments, PlannedChannel& channel,
              const PlannedCulling* culling, WorkerPool& pool) {
  IndexedVolume& volume = channel.volume;
  channel.others_bytes = othersBytes(volume, channel.transfer, arguments.frame, pool) +
                         (culling != nullptr ? culling->most_bytes : 0);
  volume.page.pages =
      besideShare(volume, arguments.resources, arguments.frame.partition,
                  pictureDemand(arguments.resources, arguments.frame), channel.others_bytes)
          .pages;
}

PlannedPart partOf(const PlanArguments& arguments, const PlannedChannel& channel) {
  return {channel.volume, channel.volume.step(), channel.transfer, arguments.frame,
          channel.volume.page};
}

// Requires: shareOut(), and the blocks are chosen if the channels are blended.
void planChannel(const PlanArguments& arguments, PlannedChannel& channel, PlannedCulling* culling,
                 TexelPlace texels, WorkerPool& pool) {
  const IndexedVolume& volume = channel.volume;
  if (channel.shown.blocks == nullptr)
    channel.shown = plannedBlocks(partOf(arguments, channel),
                                  culling != nullptr ? &culling->blocks : nullptr, pool);
  channel.costs = algorithmCosts(volume, channel.shown, arguments.frame, volume.page, pool);
  if (arguments.frame.partition == Partition::kBoxes)
    channel.boxes = planBoxes({arguments.frame, arguments.resources, arguments.volume.time}, volume,
                              channel.shown, pool);
  const AlgorithmCost& chosen = channel.costs[static_cast<size_t>(arguments.frame.algorithm)];
  channel.forecast = forecastOf({volume, channel.shown, volume.page, chosen, channel.others_bytes,
                                 arguments.frame, arguments.resources, texels});
}

bool blends(const PlanArguments& arguments, const std::vector<PlannedChannel>& channels) {
  return arguments.look.combine == Combine::kBlend && channels.size() > 1;
}

bool haveOneCut(const FrameOptions& frame, const std::vector<PlannedChannel>& channels) {
  std::vector<LayerLook> layers;
  layers.reserve(channels.size());
  for (const PlannedChannel& channel : channels)
    layers.push_back({&channel.volume, &channel.transfer});
  return haveOneCut(frame, layers);
}

// Blended channels have clusters of the same blocks, see blended_frame.h.
void evenOut(std::vector<PlannedChannel>& channels) {
  std::vector<std::pair<const IndexedVolume*, PageGeometry*>> pages;
  pages.reserve(channels.size());
  for (PlannedChannel& channel : channels)
    pages.emplace_back(&channel.volume, &channel.volume.page);
  evenOutPages(pages);
}

// The plan of a picture of which nothing is known before all of the volume is read.
int printPassAlone(const PlanArguments& arguments, const PassForecast& pass, const CLI::App& app) {
  nlohmann::json report{{"command", "plan"}, {"options", optionsJson(app)}};
  addStoreJson(report, {}, pass);
  if (!arguments.report_file.empty()) writeReport(arguments.report_file, report);
  if (arguments.json)
    sayJson(report);
  else if (!arguments.resources.quiet)
    say("{}\n", passLine(arguments.volume, pass));
  return kDone;
}

// A plan does not light its picture, so that it knows nothing of idle lights.
void warnOfIdleOptions(const PlanArguments& arguments, const std::vector<PlannedChannel>& channels,
                       const CLI::App& app) {
  const PlannedChannel& first = channels.front();
  PictureFacts facts{arguments.look, arguments.frame, arguments.culling, arguments.resources};
  facts.shows_labels = first.transfer.labels;
  facts.layers = channels.size();
  facts.time_steps = storedLayout(*first.volume.source).time_steps;
  for (const std::string& line : idleOptions(givenOptions(app), facts))
    printWarning(fmt::format("{}: {}", first.volume.name, line));
}

int run(const PlanArguments& asked, const CLI::App& app) {
  PlanArguments arguments = asked;
  checkBasis(arguments.culling);
  Workers pool(arguments.resources.threads);
  check(arguments);
  arguments.look.whole_series = arguments.culling.culling != Culling::kNone;
  // A picture with a time limit is a row of pictures that get better.
  const bool refines = arguments.frame.time_limit_s && arguments.levels.level != 0;
  arguments.frame.cut =
      cutOf(pictureOf(arguments), refines, refines ? PictureRow::kMore : PictureRow::kOne);
  Outputs outputs(arguments.force);
  outputs.reads(arguments.volume.inputs);
  outputs.reads(arguments.volume.over);
  outputs.reads(filesOf(arguments.look));
  outputs.writes("--report", arguments.report_file, reportKind(arguments.report_file));
  outputs.checkNames();
  std::optional<PassForecast> pass =
      passOverServer(arguments.volume, arguments.look, arguments.resources, arguments.frame);
  if (pass && pass->is_all) return printPassAlone(arguments, *pass, app);
  if (pass && !arguments.resources.quiet) printNotice(passLine(arguments.volume, *pass));
  PlannedPicture planned = openPlanned(arguments, FinestLevel::kMayWait, outputs, pool);
  const bool must_read = std::ranges::any_of(planned.channels, [&](const PlannedChannel& channel) {
    return mustReadFinest(channel.volume, channel.transfer,
                          planned.channels.front().volume.source->layout(), arguments.frame,
                          {&planned.camera, 1}, pool);
  });
  if (must_read && pass) {
    for (PlannedChannel& channel : planned.channels) addFinestLevel(*pass, channel.volume);
  }
  if (must_read && !pass) planned = openPlanned(arguments, FinestLevel::kRead, outputs, pool);
  std::vector<PlannedChannel>& channels = planned.channels;
  PlannedChannel& first = channels.front();
  if (!arguments.resources.quiet) warnOfIdleOptions(arguments, channels, app);
  arguments.frame.camera = planned.camera;
  if (channels.size() > 1 && arguments.culling.culling != Culling::kNone)
    fail("{}: --culling looks at one channel, {}", first.volume.name,
         notOne(channels.size(), channels.back().volume.channel));
  const std::unique_ptr<PlannedCulling> culling =
      plannedCulling(arguments, first.volume, first.transfer, pool);
  PlanArguments share = shareOf(arguments, channels.size());
  const bool is_blended = blends(arguments, channels);
  if (is_blended && !haveOneCut(arguments.frame, channels)) share.frame.cut.reset();
  // A device that draws decides how much memory is the least that works.
  const TexelPlace texels = texelPlaceOf(arguments.resources.device, pool);
  const auto argumentsOf = [&](const PlannedChannel& channel) {
    PlanArguments own = share;
    own.frame =
        frameOfLayer(channel.volume, channel.transfer, first.volume.source->layout(), own.frame);
    if (is_blended) own.frame.cut = share.frame.cut;  // one for all channels
    own.volume.time = channel.volume.time;
    return own;
  };
  for (PlannedChannel& channel : channels)
    shareOut(argumentsOf(channel), channel, culling.get(), pool);
  if (is_blended) evenOut(channels);
  // Before a block is listed.
  try {
    for (const PlannedChannel& channel : channels)
      requireRoomToPlan(channel.volume, channel.others_bytes, argumentsOf(channel).frame,
                        share.resources, texels);
  } catch (const Error& error) {
    failOfShare(error, channels.size());
  }
  if (is_blended) {
    std::vector<PlannedPart> parts;
    parts.reserve(channels.size());
    for (const PlannedChannel& channel : channels)
      parts.push_back(partOf(argumentsOf(channel), channel));
    std::vector<PlannedBlocks> shown = plannedTogether(parts, pool);
    for (size_t i = 0; i < shown.size(); ++i) channels[i].shown = std::move(shown[i]);
  }
  for (PlannedChannel& channel : channels)
    planChannel(argumentsOf(channel), channel, culling.get(), texels, pool);
  const Algorithm algorithm = arguments.frame.algorithm;
  nlohmann::json report = reportOf(channels, algorithm);
  report["command"] = "plan";
  report["options"] = optionsJson(app);
  addStoreJson(report, sumOf(channels).forecast, pass);
  if (culling) report["culling"] = countsJson(culling->blocks.counts());
  if (!arguments.report_file.empty()) {
    PagePictures pictures;
    if (isPage(arguments.report_file) && !isCoarser(*first.shown.blocks))
      addBlocks(pictures, first.volume.step().ranges->layout.grid, *first.shown.blocks);
    writeReport(arguments.report_file, report, pictures);
  }
  if (arguments.json) {
    sayJson(report);
    return 0;
  }
  if (arguments.resources.quiet) return 0;
  for (const PlannedChannel& channel : channels) {
    if (channels.size() > 1) say("{}\n", channel.volume.channel.title());
    print(channel, algorithm);
  }
  const Forecast sum = sumOf(channels).forecast;
  printForecast(sum);
  if (sum.stored) printStore(*sum.stored, first.volume.source->distantReads() > 0);
  if (pass && must_read) say("{}\n", passLine(arguments.volume, *pass));
  if (culling)
    say("culling: {} of {} blocks that are not empty can be seen\n",
        culling->blocks.counts().blocks_visible, culling->blocks.counts().blocks_nonempty);
  for (const PlannedChannel& channel : channels) printIndex(channel);
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
  addOverOption(*app, arguments->volume);
  addPictureOptions(*app, arguments->look, arguments->frame, arguments->fit);
  addFrameOptions(*app, arguments->frame);
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
