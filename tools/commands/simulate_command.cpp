// sluice simulate: replays recorded traces, or the requests that a turn around a volume would
// make, through policies and cache sizes.
#include <algorithm>
#include <memory>
#include <set>
#include <string>
#include <utility>

#include "cache/model/page_geometry.h"
#include "io/web/address.h"
#include "src/base/files/atomic_file.h"
#include "src/base/sources/synth_name.h"
#include "src/base/values/bytes.h"
#include "tools/command_line/console.h"
#include "tools/command_line/parse.h"
#include "tools/commands/commands.h"
#include "tools/options/picture_checks.h"
#include "tools/options/shared_options.h"
#include "tools/options/view_arguments.h"
#include "tools/outputs/simulation_output.h"
#include "tools/pages/report_file.h"
#include "tools/pages/simulation_page.h"

namespace sluice {
namespace {

void writeText(const std::string& file, const std::string& text) {
  AtomicFile out(file);
  out.write(text);
  out.commit();
}

void writePage(const std::string& file, const std::vector<SimulatedRun>& runs) {
  std::vector<SimulationReport> reports;
  reports.reserve(runs.size());
  for (const SimulatedRun& run : runs) reports.push_back(*run.report);
  writeText(file, simulationPage(reports, sumOfChannels(runs)));
}

int run(const SimulateArguments& arguments) {
  const std::vector<SimulatedRun> runs = simulateRuns(arguments);
  if (!arguments.html_file.empty()) writePage(arguments.html_file, runs);
  const nlohmann::json report = simulationJson(runs, arguments);
  if (isPage(arguments.report_file))
    writePage(arguments.report_file, runs);
  else if (!arguments.report_file.empty())
    writeReport(arguments.report_file, report);
  std::set<std::string> said;
  for (const SimulatedRun& run : runs)
    for (const std::string& line : run.warnings)
      if (!arguments.turn.resources.quiet && said.insert(line).second) printWarning(line);
  const bool prints_csv = arguments.csv_file == "-";
  if (!arguments.csv_file.empty()) {
    const std::string csv = simulationCsv(runs);
    if (prints_csv)
      sayText(csv);
    else
      writeText(arguments.csv_file, csv);
  }
  if (arguments.json) sayJson(report);
  if (arguments.json || prints_csv || arguments.turn.resources.quiet) return 0;
  for (const SimulatedRun& run : runs) printSimulation(run, arguments);
  printSum(runs);
  std::vector<std::string> files{arguments.html_file, arguments.report_file, arguments.csv_file};
  for (const SimulatedRun& run : runs) files.push_back(run.export_file);
  for (const std::string& file : files)
    if (!file.empty()) say("{}\n", file);
  return 0;
}

// The names of options added since there were `before` of them.
std::vector<std::string> optionsSince(const CLI::App& app, size_t before) {
  std::vector<std::string> names;
  const std::vector<const CLI::Option*> all = app.get_options();
  for (size_t i = before; i < all.size(); ++i)
    if (!all[i]->get_positional()) names.push_back(all[i]->get_name());
  return names;
}

// Reports options that contradict each other as usage errors, before anything is read.
void checkArguments(const CLI::App& app, const SimulateArguments& arguments,
                    const std::vector<std::string>& of_volumes) {
  const std::vector<std::string>& inputs = arguments.turn.volume.inputs;
  const bool any_trace =
      arguments.format || std::any_of(inputs.begin(), inputs.end(),
                                      [](const std::string& name) { return isTraceFile(name); });
  for (size_t i = 0; any_trace && !arguments.format && i < inputs.size(); ++i)
    if (!isTraceFile(inputs[i]))
      throw CLI::ValidationError(
          inputs[i], "is not known as a trace, and traces can be combined with traces only");
  for (const std::string& name : inputs)
    if (arguments.format && (isSynthSpec(name) || isAddress(name)))
      throw CLI::ValidationError("--format", "is for traces, and " + name + " is a volume");
  const bool is_trace = arguments.isTrace();
  for (const std::string& name : of_volumes)
    if (is_trace && app.count(name) > 0)
      throw CLI::ValidationError(name, "is for volumes, and " + inputs.front() + " is a trace");
  if (!is_trace && app.count("--page-bytes") > 0)
    throw CLI::ValidationError("--page-bytes",
                               "is for traces, and " + inputs.front() + " is a volume; see --page");
  for (const char* name : {"--export", "--prefetch"})
    if (arguments.runs() > 1 && app.count(name) > 0)
      throw CLI::ValidationError(name, "is for one trace or page size at a time");
  for (const char* name : {"--policies", "--html", "--csv", "--export", "--prefetch", "--by-page"})
    if (arguments.sample_rate && app.count(name) > 0)
      throw CLI::ValidationError(name, "does not go with --sample, which estimates LRU only");
  if (arguments.sample_rate && isPage(arguments.report_file))
    throw CLI::ValidationError("--report", "with --sample is JSON, not a page");
  if (arguments.csv_file == "-" && arguments.json)
    throw CLI::ValidationError("--csv", "- and --json both want the standard output");
}

// "4096" or "10M" pages.
std::optional<uint64_t> parsePages(const std::string& word) {
  constexpr uint64_t kMostPages = uint64_t{1} << 40;
  const bool is_bytes = word.ends_with('B') || word.ends_with('b');
  const bool is_whole = word.find('.') == std::string::npos;
  const std::optional<uint64_t> pages = parseBytes(word);
  if (is_bytes || !is_whole || !pages || *pages < 1 || *pages > kMostPages) return std::nullopt;
  return pages;
}

}  // namespace

Command addSimulate(CLI::App& program) {
  auto arguments = std::make_shared<SimulateArguments>();
  CLI::App* app = program.add_subcommand(
      "simulate",
      "Replays traces, or a turn around a volume, through policies and cache sizes\n\n"
      "VOLUME may be a trace that render --trace recorded, or one of another program.\n\n"
      "  sluice simulate bonsai.nii.gz --threshold 40 --page 32x64x2 --pages 256 "
      "--html report.html");
  TurnArguments& turn = arguments->turn;
  const size_t before = app->get_options().size();
  addVolumeOptions(*app, turn.volume);
  addOverOption(*app, turn.volume);
  const AskedView asked = addPictureOptions(*app, turn.look, turn.frame, turn.fit);
  addFrameOptions(*app, asked, turn.frame);
  addLevelOptions(*app, asked, turn.frame, turn.resources);
  // It leaves out data depending on the picture, which a simulation lacks, as it lacks a clock for
  // --time-limit.
  app->remove_option(app->get_option("--occlusion"));
  const OptionGroup replay(*app, "Simulation");
  addFramesOption(replay, turn.frames, "Volume: views of the turn");
  replay.flag("--fixed-plan", turn.is_plan_fixed,
              "Volume: replays the chunks planned for --pages at every size; without it, each size "
              "has a plan of its own, as in render");
  std::vector<std::string> of_volumes = optionsSince(*app, before);
  of_volumes.insert(of_volumes.end(), {"--page", "--block"});
  addResourceOptions(*app, turn.resources);
  app->remove_option(app->get_option("--page"));
  OptionGroup(*app, kMachineHeading)
      .parsed(
          "--page", "AxBxC,...", kPageSizes,
          [](const std::string& words) { return parseList<Vec3i>(words, parsePageOption); },
          [arguments](const std::vector<Vec3i>& pages) {
            arguments->page_sizes.insert(arguments->page_sizes.end(), pages.begin(), pages.end());
          },
          "Volume: page sizes in voxels, a table for each (the 64 KiB page of the voxel type)")
      ->trigger_on_parse();
  replay.choice(
      "--format",
      wordsOf<TraceFormat>(std::array{TraceFormat::kText, TraceFormat::kBinary, TraceFormat::kCsv,
                                      TraceFormat::kOracleGeneral, TraceFormat::kDin},
                           [](TraceFormat format) { return name(format); }),
      arguments->format,
      "Trace: its format, if the name does not tell; gzip and zstd are unpacked");
  replay.bytes("--page-bytes", arguments->page_bytes,
               "Trace: bytes of a page, if the format does not tell (4096)");
  const auto policies =
      wordsOf<PolicyKind>(allPolicies(), [](PolicyKind kind) { return name(kind); });
  replay.choices("--policies", policies, arguments->policies,
                 "Rows of the table (all): " + listed(namesOf(policies)));
  replay.parsed(
      "--sizes", "PAGES,...",
      "whole numbers with commas between, as in 256 or 10M, each from 1 to 2^40",
      [](const std::string& word) { return parseList<uint64_t>(word, parsePages); },
      [arguments](const std::vector<uint64_t>& sizes) { arguments->sizes = sizes; },
      "Cache sizes in pages; 1K is 1024 pages (powers of two up to the size that holds all)");
  Words<std::string> machines;
  for (const PageConfiguration& machine : pageConfigurations())
    machines.emplace_back(machine.name, machine.name);
  replay
      .choice("--machine", machines, arguments->machine,
              "Cache size of a named machine: " + listed(namesOf(machines)))
      ->excludes(app->get_option("--pages"));
  replay.choice("--pin", Words<bool>{{"auto", true}, {"off", false}}, arguments->pins,
                "Whether the chunks of a cluster stay until the next cluster, as in the renderer: "
                "if the trace has clusters, or never");
  replay.number("--sample", "RATE", arguments->sample_rate, {0, 1, true},
                "Only LRU's approximate miss ratios, from this share of the chunks (SHARDS); the "
                "trace need not fit in memory");
  replay.flag("--by-page", arguments->by_page,
              "Every page is an entry of its own; nothing is pinned");
  const auto models =
      wordsOf<PrefetchModel>(std::array{PrefetchModel::kNextCluster, PrefetchModel::kNextTimeStep,
                                        PrefetchModel::kLastOrder},
                             [](PrefetchModel model) { return name(model); });
  replay.choice("--prefetch", models, arguments->prefetch, "Also models reading ahead");
  const OptionGroup output(*app, kOutputHeading);
  output.text("--html", "FILE", arguments->html_file, "Self-contained report with plots");
  addReportOption(output, arguments->report_file);
  output.text("--csv", "FILE", arguments->csv_file, "The table; - is the standard output");
  output.text(
      "--export", "FILE", arguments->export_file,
      "The requests (of a volume: to a cache of --pages; of several channels a file each, as "
      "t_0.txt for t.txt), also for other simulators: .txt, .csv, .oracleGeneral, .din, else "
      "compact binary");
  addForceOption(output, arguments->force);
  addQuietOption(output, arguments->turn.resources.quiet);
  addJsonOption(output, arguments->json);
  app->parse_complete_callback(
      [app, arguments, of_volumes] { checkArguments(*app, *arguments, of_volumes); });
  return [arguments, app, asked] {
    const TurnArguments& turned = arguments->turn;
    const CullingArguments none;
    checkPicture({turned.look, turned.frame, none, turned.resources},
                 viewState(*asked, turned.volume, turned.look));
    checkPlainOptions(turned.volume, turned.look, turned.frame);
    arguments->turn.given = givenOptions(*app);
    arguments->turn.given.erase("--seed");  // --policies may have the random policy
    if (arguments->turn.resources.pages)
      arguments->turn.fixed_pages = static_cast<uint64_t>(*arguments->turn.resources.pages);
    return run(*arguments);
  };
}

}  // namespace sluice
