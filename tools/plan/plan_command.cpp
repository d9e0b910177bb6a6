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
#include "src/library/drawing/cost/planned_channels.h"
#include "src/library/drawing/scene/device_choice.h"
#include "src/library/opening/channel_looks.h"
#include "tools/command_line/console.h"
#include "tools/command_line/progress_line.h"
#include "tools/command_line/usage.h"
#include "tools/commands/commands.h"
#include "tools/options/picture_checks.h"
#include "tools/options/shared_options.h"
#include "tools/options/view_arguments.h"
#include "tools/outputs/cut_report.h"
#include "tools/outputs/report.h"
#include "tools/pages/report_file.h"
#include "tools/plan/plan_boxes.h"
#include "tools/plan/plan_forecast.h"
#include "tools/plan/plan_report.h"
#include "tools/plan/plan_server.h"
#include "tools/scene/open_scene.h"
#include "tools/scene/opened_picture.h"
#include "tools/scene/series.h"
#include "tools/scene/workers.h"

namespace sluice {
namespace {

struct PlanArguments {
  VolumeArguments volume;
  LookArguments look;
  FrameOptions frame;
  CullingArguments culling;
  ResourceArguments resources;
  FitChoice fit;
  AskedView asked;
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
                          passOf(pool, progress, arguments.resources));
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

OpenedPicture openPlanned(const PlanArguments& arguments, FinestLevel finest,
                          const Outputs& outputs, WorkerPool& pool) {
  return openPicture({arguments.volume,
                      arguments.look,
                      arguments.frame,
                      arguments.resources,
                      arguments.fit,
                      {arguments.frame.camera}},
                     finest, outputs, pool);
}

PictureArguments pictureOf(const PlanArguments& arguments) {
  return {arguments.look, arguments.frame, arguments.culling, arguments.resources};
}

// The same refusals as of a picture that is drawn, and those of a plan. Throws a usage error.
void check(const PlanArguments& arguments) {
  checkPicture(pictureOf(arguments), viewState(*arguments.asked, arguments.volume, arguments.look));
  checkPlainOptions(arguments.volume, arguments.look, arguments.frame);
  if (arguments.culling.culling == Culling::kAuto)
    failUsage("--culling auto measures pictures; plan takes none, pof, opof or toc");
  if (arguments.frame.partition == Partition::kBoxes)
    refuseLevels(arguments.frame.cut, "--partition boxes plans the finest level alone");
}

// The plan of a picture of which nothing is known before all of the volume is read.
int printPassAlone(const PlanArguments& arguments, const PassForecast& pass, const CLI::App& app) {
  nlohmann::json report{
      {"command", "plan"}, {"options", optionsJson(app)}, {"warnings", nlohmann::json::array()}};
  addStoreJson(report, {}, pass);
  if (!arguments.report_file.empty()) writeReport(arguments.report_file, report);
  if (arguments.json)
    sayJson(report);
  else if (!arguments.resources.quiet)
    say("{}\n", passLine(arguments.volume, pass));
  return kDone;
}

// The growing boxes of each channel; empty if none are asked for.
std::vector<PlannedBoxes> boxesOf(const std::vector<PlannedChannel>& channels,
                                  ResourceArguments resources, WorkerPool& pool) {
  std::vector<PlannedBoxes> boxes;
  boxes.reserve(channels.size());
  for (const PlannedChannel& channel : channels) {
    const ChannelShare& share = channel.share;
    if (share.frame.partition != Partition::kBoxes) return {};
    static_cast<MachineOptions&>(resources) = share.machine;
    boxes.push_back(planBoxes({share.frame, resources, share.look.volume->time}, *share.look.volume,
                              channel.shown, pool));
  }
  return boxes;
}

int run(const PlanArguments& asked, const CLI::App& app) {
  PlanArguments arguments = asked;
  checkBasis(arguments.culling);
  Workers pool(arguments.resources.threads);
  check(arguments);
  // A device that draws decides which pictures it can draw, and how much memory is the least.
  const DeviceLimits device = limitsOf(arguments.resources.device, pool);
  requirePictureSize(arguments.frame.size, device);
  // Functions of opacity hold for one transfer function of all steps.
  arguments.look.whole_series = arguments.culling.culling != Culling::kNone ||
                                looksAtAllSteps(arguments.look, arguments.frame, arguments.fit);
  // A picture with a time limit is a row of pictures that get better.
  const bool refines = arguments.frame.time_limit_s && arguments.frame.cut;
  arguments.frame.cut =
      cutOf(pictureOf(arguments), refines, refines ? PictureRow::kMore : PictureRow::kOne);
  Outputs outputs(arguments.force);
  outputs.reads(arguments.volume.inputs);
  outputs.reads(arguments.volume.asked.over);
  outputs.reads(filesOf(arguments.look));
  outputs.writes("--report", arguments.report_file, reportKind(arguments.report_file));
  outputs.checkNames();
  std::optional<PassForecast> pass =
      passOverServer(arguments.volume, arguments.look, arguments.resources, arguments.frame);
  if (pass && pass->is_all) return printPassAlone(arguments, *pass, app);
  if (pass && !arguments.resources.quiet) printNotice(passLine(arguments.volume, *pass));
  // The pass over the finest level waits until it is known whether the picture shows it.
  OpenedPicture opened = openPlanned(arguments, FinestLevel::kMayWait, outputs, pool);
  const bool must_read = mustReadFinest(opened, arguments.frame, pool);
  // Over the network the pass is forecast and not made: its bytes are what is asked about.
  if (must_read && pass) {
    for (IndexedVolume& volume : opened.volumes) addFinestLevel(*pass, volume);
  }
  if (must_read && !pass) opened = openPlanned(arguments, FinestLevel::kRead, outputs, pool);
  const std::vector<LayerLook> looks = opened.looks();
  const IndexedVolume& first = opened.volumes.front();
  arguments.frame.camera = opened.cameras.front();
  const std::vector<std::string> warnings =
      optionWarnings(givenOptions(app), arguments.look, arguments.frame, arguments.culling,
                     arguments.resources, opened);
  if (!arguments.resources.quiet)
    for (const std::string& line : warnings) printWarning(line);
  if (looks.size() > 1 && arguments.culling.culling != Culling::kNone)
    fail("{}: --culling looks at one channel, {}", first.name,
         notOne(looks.size(), opened.volumes.back().channel));
  const std::unique_ptr<PlannedCulling> culling =
      plannedCulling(arguments, first, opened.transfers.front(), pool);
  const Combine combine = combineOf(arguments.look, arguments.frame, looks);
  const std::vector<PlannedChannel> channels = plannedChannels(
      channelShares(looks, combine, arguments.frame, arguments.resources,
                    culling != nullptr ? culling->most_bytes : 0, pool),
      combine, culling != nullptr ? &culling->blocks : nullptr, device.texels, pool);
  const std::vector<PlannedBoxes> boxes = boxesOf(channels, arguments.resources, pool);
  const PlanToReport plan{channels, boxes, arguments.frame.algorithm};
  const VisibleBlocks& shown = *channels.front().shown.blocks;
  nlohmann::json report = reportOf(plan);
  report["command"] = "plan";
  report["options"] = optionsJson(app);
  report["warnings"] = warnings;
  for (const auto& notes : {standInNotes(opened), notesOf(opened)})
    for (const std::string& note : notes) report["warnings"].push_back(note);
  addStoreJson(report, sumOf(channels).forecast, pass);
  if (culling) report["culling"] = countsJson(culling->blocks.counts());
  if (!arguments.report_file.empty()) {
    PagePictures pictures;
    if (isPage(arguments.report_file) && !isCoarser(shown))
      addBlocks(pictures, first.step().ranges->layout.grid, shown);
    writeReport(arguments.report_file, report, pictures);
  }
  if (arguments.json) {
    sayJson(report);
    return 0;
  }
  if (arguments.resources.quiet) return 0;
  printTables(plan);
  const Forecast sum = sumOf(channels).forecast;
  printForecast(sum);
  if (sum.stored) printStore(*sum.stored, first.source->distantReads() > 0);
  if (pass && must_read) say("{}\n", passLine(arguments.volume, *pass));
  if (culling)
    say("culling: {} of {} blocks that are not empty can be seen\n",
        culling->blocks.counts().blocks_visible, culling->blocks.counts().blocks_nonempty);
  printIndices(plan);
  return 0;
}

}  // namespace

Command addPlan(CLI::App& program) {
  auto arguments = std::make_shared<PlanArguments>();
  CLI::App* app = program.add_subcommand(
      "plan",
      "Prints what a picture will read, load and hold, before it is drawn\n\n"
      "It reads no voxel, but for the index of a volume that has none.\n\n"
      "  sluice plan bonsai.nii.gz --threshold 40 --page 32x64x2 --pages 256\n"
      "  sluice plan bonsai.nii.gz --threshold 40 --partition boxes");
  addVolumeOptions(*app, arguments->volume);
  addOverOption(*app, arguments->volume);
  const AskedView asked =
      addPictureOptions(*app, arguments->look, arguments->frame, arguments->fit);
  arguments->asked = asked;
  addFrameOptions(*app, asked, arguments->frame);
  addTimeLimit(*app, asked, arguments->frame);
  addCullingOptions(*app, arguments->culling, true);
  addLevelOptions(*app, asked, arguments->frame, arguments->resources);
  addResourceOptions(*app, arguments->resources);
  const OptionGroup output(*app, kOutputHeading);
  addReportOption(output, arguments->report_file);
  addForceOption(output, arguments->force);
  addQuietOption(output, arguments->resources.quiet);
  addJsonOption(output, arguments->json);
  return [arguments, app] { return run(*arguments, *app); };
}

}  // namespace sluice
