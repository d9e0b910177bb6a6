// sluice plan: what a picture will cost, level by level and algorithm by algorithm, from the
// min-max arrays alone: no voxel is read.
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <memory>

#include "src/base/bytes.h"
#include "src/render/frame_setup.h"
#include "src/texture/requests.h"
#include "tools/commands.h"
#include "tools/report.h"
#include "tools/scene.h"

namespace sluice {
namespace {

struct Arguments {
  VolumeArguments volume;
  LookArguments look;
  FrameOptions frame;
  ResourceArguments resources;
  bool json = false;
};

constexpr std::array<Algorithm, 4> kAlgorithms = {Algorithm::kConventional, Algorithm::kClipped,
                                                  Algorithm::kTrimmed, Algorithm::kMerged};

struct Cost {
  Algorithm algorithm;
  PlannedFrame planned;
  int64_t binds = 0;
};

void print(const std::vector<Cost>& costs, const PageGeometry& page) {
  fmt::print("{:<13} {:>8} {:>9} {:>12} {:>7}   pages of {}, {} in the cache\n", "algorithm",
             "chunks", "pages", "bytes", "binds", printPageSize(page.size_vox), page.pages);
  for (const Cost& cost : costs)
    fmt::print("{:<13} {:>8} {:>9} {:>12} {:>7}\n", name(cost.algorithm),
               cost.planned.plan.chunks.size(), cost.planned.plan.pageCount(),
               formatBytes(cost.planned.plan.bytes()), cost.binds);
  const Cost& last = costs.back();
  fmt::print("{} clusters of {} x {} blocks; classified in {:.2f} ms, planned in {:.2f} ms\n",
             last.planned.plan.clusters.size(), last.planned.plan.cluster_blocks.x,
             last.planned.plan.cluster_blocks.y, 1e3 * last.planned.classify_seconds,
             1e3 * last.planned.plan_seconds);
}

int run(const Arguments& arguments, const CLI::App& app) {
  WorkerPool pool(arguments.resources.threads);
  const IndexedVolume volume =
      openIndexed(arguments.volume, arguments.resources, arguments.look.shade, pool);
  const TransferFunction transfer = transferFor(volume, arguments.look);
  const View view = resolve(arguments.frame.camera, volume.source->layout(), arguments.frame.size,
                            arguments.frame.step_vox);
  const EyePosition eye = eyePosition(view, volume.source->layout());
  std::vector<Cost> costs;
  for (const Algorithm algorithm : kAlgorithms) {
    FrameOptions options = arguments.frame;
    options.algorithm = algorithm;
    Cost cost{algorithm, planFrame(volume, transfer, options, arguments.volume.time, pool), 0};
    cost.binds = bindCount(cost.planned.plan, eye);
    costs.push_back(std::move(cost));
  }
  if (!arguments.json) {
    print(costs, volume.page);
    return 0;
  }
  const PlannedFrame& chosen = costs[static_cast<size_t>(arguments.frame.algorithm)].planned;
  nlohmann::json report{{"command", "plan"},
                        {"options", optionsJson(app)},
                        {"volume", volumeJson(volume)},
                        {"transfer", transfer.name},
                        {"clusters", chosen.plan.clusters.size()},
                        {"classify_seconds", chosen.classify_seconds},
                        {"plan_seconds", chosen.plan_seconds},
                        {"seconds", chosen.classify_seconds + chosen.plan_seconds}};
  for (const Cost& cost : costs)
    report["algorithms"][std::string(name(cost.algorithm))] = {
        {"chunks", cost.planned.plan.chunks.size()},
        {"pages", cost.planned.plan.pageCount()},
        {"bytes", cost.planned.plan.bytes()},
        {"binds", cost.binds}};
  fmt::print("{}\n", report.dump(2));
  return 0;
}

}  // namespace

Command addPlan(CLI::App& program) {
  auto arguments = std::make_shared<Arguments>();
  CLI::App* app = program.add_subcommand(
      "plan",
      "What a frame will load, by algorithm, without reading a voxel\n\n"
      "  sluice plan bonsai.nii.gz --threshold 40 --page 32x64x2 --pages 256");
  addVolumeOptions(*app, arguments->volume);
  addLookOptions(*app, arguments->look);
  addViewOptions(*app, arguments->frame);
  addResourceOptions(*app, arguments->resources);
  app->add_flag("--json", arguments->json, "One JSON object");
  return [arguments, app] { return run(*arguments, *app); };
}

}  // namespace sluice
