// sluice prepare: the opacity functions of a series and the tree of its coherent spans, made ahead
// and kept with its index.
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <memory>
#include <numeric>

#include "src/base/error.h"
#include "src/base/values/bytes.h"
#include "tools/command_line/console.h"
#include "tools/command_line/environment.h"
#include "tools/command_line/usage.h"
#include "tools/commands/commands.h"
#include "tools/options/shared_options.h"
#include "tools/outputs/report.h"
#include "tools/scene/series.h"
#include "tools/scene/workers.h"

namespace sluice {
namespace {

struct PrepareArguments {
  VolumeArguments volume;
  LookArguments look;
  FrameOptions frame;
  ResourceArguments resources;
  CullingArguments culling;
  bool json = false;
};

nlohmann::json reportOf(const SeriesFunctions& functions, const CLI::App& app) {
  const KeptSeries& kept = *functions.kept;
  const SeriesPassReport& pass = kept.report;
  const auto shareOf = [](int64_t part, int64_t all) {
    return all == 0 ? 1 : static_cast<double>(part) / static_cast<double>(all);
  };
  nlohmann::json coherent = nlohmann::json::array();
  for (size_t i = 0; i < pass.blocks.size(); ++i)
    coherent.push_back(shareOf(pass.coherent[i], pass.blocks[i]));
  return {{"command", "prepare"},
          {"options", optionsJson(app)},
          {"steps", kept.opacity.steps},
          {"blocks", kept.opacity.blockCount()},
          {"blocks_nonempty", kept.nonempty},
          {"functions", kept.opacity.functions.size()},
          {"spans", kept.opacity.spans.size()},
          {"bytes", functions.bytes},
          {"tree_bytes", kept.opacity.tree->bytes()},
          {"worker_bytes", pass.worker_bytes},
          {"coherent_share", pass.coherentShare()},
          {"coherent_share_of_steps", coherent},
          {"seconds",
           {{"read", pass.read_seconds},
            {"functions", pass.functions_seconds},
            {"fusion", pass.fusion_seconds},
            {"tree", pass.tree_seconds}}},
          {"exponent", functions.exponent},
          {"exponents", functions.exponents},
          {"state", name(functions.origin)},
          {"path", functions.path.string()}};
}

void print(const SeriesFunctions& functions, double difference) {
  const KeptSeries& kept = *functions.kept;
  const int64_t nonempty = std::accumulate(kept.nonempty.begin(), kept.nonempty.end(), int64_t{0});
  say("{} time steps of {} blocks, {} not empty a step; {} functions for {} spans, {}, {}\n",
      kept.opacity.steps, kept.opacity.blockCount(), nonempty / kept.opacity.steps,
      kept.opacity.functions.size(), kept.opacity.spans.size(), formatBytes(functions.bytes),
      name(functions.origin));
  say("{:.1f} % of the blocks stay as they were from step to step (difference {})\n",
      100 * kept.report.coherentShare(), difference);
  say("made in {:.2f} s of reading, {:.2f} of fusion, {:.2f} of functions, {:.2f} of the tree\n",
      kept.report.read_seconds, kept.report.fusion_seconds, kept.report.functions_seconds,
      kept.report.tree_seconds);
  if (!functions.path.empty()) say("{}\n", functions.path.string());
}

int run(PrepareArguments& arguments, const CLI::App& app) {
  arguments.look.whole_series = true;
  if (!arguments.look.surfaces.empty())
    failUsage("prepare knows nothing of surfaces; leave out --iso");
  checkBasis(arguments.culling);
  Workers pool(arguments.resources.threads);
  const IndexedVolume volume = openIndexed(arguments.volume, arguments.resources,
                                           needsOf(arguments.look, Mode::kComposite), pool);
  const ChosenLook look = lookFor(volume, arguments.look, Mode::kComposite);
  for (const std::string& warning : look.warnings)
    if (!arguments.resources.quiet) printWarning(warning);
  const SeriesFunctions functions =
      openFunctions(volume, look.transfer, arguments.culling, arguments.resources, pool);
  if (arguments.json)
    sayJson(reportOf(functions, app));
  else if (!arguments.resources.quiet)
    print(functions, arguments.culling.difference);
  // A later picture would have to compute them again, and a script would not know.
  if (functions.path.empty() && !indexWish(arguments.resources.index_dir).disabled)
    failSystem("the functions were computed, but not kept: {}", functions.note);
  return 0;
}

}  // namespace

Command addPrepare(CLI::App& program) {
  auto arguments = std::make_shared<PrepareArguments>();
  arguments->look.first_picture = true;
  CLI::App* app = program.add_subcommand(
      "prepare",
      "Computes the opacity functions of a series for render --culling\n\n"
      "An opacity function tells how much a block hides, seen from any direction. The functions "
      "apply to the given transfer function and are kept with the index.\n\n"
      "  sluice prepare 'step_%03d.nrrd' --threshold 40");
  addVolumeOptions(*app, arguments->volume);
  addLookOptions(*app, std::make_shared<ViewState>(), arguments->look, arguments->frame);
  addCullingOptions(*app, arguments->culling, false);
  addReadingOptions(*app, arguments->resources);
  const OptionGroup output(*app, kOutputHeading);
  addQuietOption(output, arguments->resources.quiet);
  addJsonOption(output, arguments->json);
  takeIdleOptions(*app);
  return [arguments, app] { return run(*arguments, *app); };
}

}  // namespace sluice
