// sluice simulate: replays a recorded trace, or the requests that a turn around a volume would
// make, through policies and cache sizes.
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <optional>
#include <utility>

#include "cache/model/page_geometry.h"
#include "cache/report/report_html.h"
#include "cache/simulate/prefetch.h"
#include "cache/simulate/simulation_report.h"
#include "src/base/atomic_file.h"
#include "src/base/bytes.h"
#include "src/base/error.h"
#include "tools/command_line/console.h"
#include "tools/command_line/shared_options.h"
#include "tools/commands.h"
#include "tools/pages/report_file.h"
#include "tools/replay.h"
#include "tools/scene.h"

namespace sluice {
namespace {

struct Arguments {
  TurnArguments turn;
  std::optional<TraceFormat> format;
  uint64_t page_bytes = 4096;
  std::vector<PolicyKind> policies;
  std::vector<uint64_t> sizes;
  std::string machine;
  bool pins = true;
  std::optional<PrefetchModel> prefetch;
  std::string html_file, csv_file, export_file, report_file;
  bool by_page = false;
  bool force = false;
  bool json = false;

  bool isTrace() const { return format || isTraceFile(turn.volume.inputs.front()); }
};

// Says so where a file is neither: opening a pipe would wait for someone to write into it.
void refusePipe(const std::string& name) {
  std::error_code none;
  const std::filesystem::file_status status = std::filesystem::status(name, none);
  if (std::filesystem::is_fifo(status) || std::filesystem::is_socket(status) ||
      std::filesystem::is_character_file(status))
    fail(
        "{}: expected a trace or a volume, found a pipe or a device; copy what it gives into a "
        "file",
        name);
}

Outputs outputsOf(const Arguments& arguments) {
  Outputs outputs(arguments.force);
  outputs.reads(arguments.turn.volume.inputs);
  outputs.reads(arguments.turn.look.transfer_file);
  outputs.writes("--html", arguments.html_file, FileKind::kHtml);
  outputs.writes("--report", arguments.report_file, reportKind(arguments.report_file));
  outputs.writes("--csv", arguments.csv_file, FileKind::kText);
  outputs.writes("--export", arguments.export_file, FileKind::kTrace);
  return outputs;
}

std::unique_ptr<ReplaySource> sourceOf(const Arguments& arguments) {
  const std::string& file = arguments.turn.volume.inputs.front();
  const Outputs outputs = outputsOf(arguments);
  outputs.checkNames();
  refusePipe(file);
  if (!arguments.isTrace()) return openTurn(arguments.turn, outputs);
  outputs.check();
  return openTraceFile(file, arguments.format, arguments.page_bytes);
}

std::vector<PolicyKind> policiesOf(const Arguments& arguments) {
  std::vector<PolicyKind> kinds = arguments.policies;
  if (kinds.empty()) {
    kinds.assign(onlinePolicies().begin(), onlinePolicies().end());
    kinds.push_back(PolicyKind::kBelady);
    kinds.push_back(PolicyKind::kBeladyPages);
  }
  return kinds;
}

// The cache that facts, plots and reading ahead are of.
SimulationConfig chosenConfig(const Arguments& arguments, const ReplaySource& source) {
  SimulationConfig chosen;
  chosen.policy = arguments.turn.resources.policy;
  chosen.seed = arguments.turn.resources.seed;
  chosen.pin_clusters = arguments.pins && !arguments.by_page;
  if (arguments.turn.resources.pages) {
    chosen.pages = static_cast<uint64_t>(*arguments.turn.resources.pages);
  } else if (!arguments.machine.empty()) {
    chosen.pages = static_cast<uint64_t>(findPageConfiguration(arguments.machine)->geometry.pages);
  } else {
    chosen.pages = arguments.sizes.empty() ? source.defaultPages() : arguments.sizes.front();
  }
  return chosen;
}

// Page by page where that is asked for, within the memory that the program may take.
PreparedTrace asRequested(PreparedTrace chunks, const Arguments& arguments) {
  if (!arguments.by_page) return chunks;
  constexpr uint64_t kBytesARequest = 8, kBytesAPage = 64;
  const uint64_t budget = memoryBudget(arguments.turn.resources);
  if (chunks.page_requests > budget / (2 * kBytesARequest) ||
      chunks.distinct_pages > budget / (2 * kBytesAPage))
    fail(
        "{}: --by-page needs {} for {} page requests of {} pages; give as much as --memory or "
        "replay whole chunks",
        arguments.turn.volume.inputs.front(),
        formatBytes(2 * std::max(chunks.page_requests * kBytesARequest,
                                 chunks.distinct_pages * kBytesAPage)),
        chunks.page_requests, chunks.distinct_pages);
  return splitIntoPages(chunks);
}

// The trace of the chosen cache and the rows of the table.
struct Simulated {
  PreparedTrace chosen_trace;
  std::vector<uint64_t> sizes;
  std::vector<SimulationRow> rows;
  bool is_one_trace = true;  // the same requests at every size
};

std::vector<SimulationRow> rowsAt(uint64_t pages, const Arguments& arguments, ReplaySource& source,
                                  const SimulationConfig& chosen, Simulated& simulated) {
  const std::optional<uint64_t> planned = source.plannedPages(pages);
  std::optional<PreparedTrace> other;
  if (planned != source.plannedPages(chosen.pages)) {
    other = asRequested(source.requests(pages), arguments);
    simulated.is_one_trace = false;
  }
  std::vector<SimulationRow> rows = simulateTable(other ? *other : simulated.chosen_trace,
                                                  policiesOf(arguments), {&pages, 1}, chosen);
  for (SimulationRow& row : rows) row.planned_pages = planned;
  return rows;
}

Simulated simulateAll(const Arguments& arguments, ReplaySource& source,
                      const SimulationConfig& chosen) {
  Simulated result;
  result.chosen_trace = asRequested(source.requests(chosen.pages), arguments);
  result.sizes = arguments.sizes;
  if (result.sizes.empty()) {
    result.sizes = defaultSizes(result.chosen_trace, chosen.pages);
    std::erase_if(result.sizes, [&](uint64_t pages) { return pages < source.leastPages(); });
  }
  for (const uint64_t pages : result.sizes) {
    const auto rows = rowsAt(pages, arguments, source, chosen, result);
    result.rows.insert(result.rows.end(), rows.begin(), rows.end());
  }
  return result;
}

void writeText(const std::string& file, const std::string& text) {
  AtomicFile out(file);
  out.write(text);
  out.commit();
}

void writeHtml(const std::string& file, const Arguments& arguments, ReplaySource& source,
               const SimulationConfig& chosen, Simulated& simulated) {
  std::vector<SimulationRow> rows = simulated.rows;
  // The report shows the chosen size, asked for in the table or not.
  if (std::count(simulated.sizes.begin(), simulated.sizes.end(), chosen.pages) == 0) {
    const auto more = rowsAt(chosen.pages, arguments, source, chosen, simulated);
    rows.insert(rows.end(), more.begin(), more.end());
  }
  writeText(file, htmlReport(makeReport(simulated.chosen_trace, source.title(), std::move(rows),
                                        simulated.is_one_trace, chosen)));
}

void exportTrace(const Trace& trace, const std::string& file) {
  const auto writer = makeTraceWriter(file, traceFormatOf(file), trace.page_bytes);
  for (const TraceRecord& record : trace.records) writer->write(record);
  writer->finish();
}

void printTable(const std::string& title, const Simulated& simulated,
                const SimulationConfig& chosen) {
  say("{}\n", title);
  for (const auto& [what, value] : factsOf(simulated.chosen_trace, chosen))
    say("  {}: {}\n", what, value);
  say("{:<13} {:>8} {:>8} {:>10} {:>10} {:>10} {:>10} {:>10} {:>10} {:>10} {:>9} {:>7}\n", "policy",
      "pages", "planned", "requests", "hits", "misses", "compulsory", "capacity", "conflict",
      "moved", "seconds", "failed");
  bool any_failed = false;
  for (const SimulationRow& row : simulated.rows) {
    any_failed |= row.failures > 0;
    say("{:<13} {:>8} {:>8} {:>10} {:>10} {:>10} {:>10} {:>10} {:>10} {:>10} {:>9.4f} {:>7}{}\n",
        name(row.policy), row.pages,
        row.planned_pages ? fmt::format("{}", *row.planned_pages) : "-", row.requests, row.hits,
        row.misses, row.compulsory, row.capacity, row.conflict, formatBytes(row.bytes.moved),
        row.modelled_seconds, row.failures, row.failures > 0 ? " !" : "");
  }
  if (any_failed)
    say("! requests that do not fit the cache: the renderer would stop there; each costs its "
        "bytes every time\n");
}

nlohmann::json prefetchJson(const Trace& trace, const Arguments& arguments,
                            const SimulationConfig& chosen) {
  if (!trace.carries_clusters)
    fail("{}: --prefetch models reading ahead of clusters, and this trace carries none",
         arguments.turn.volume.inputs.front());
  const PrefetchResult result = simulatePrefetch(
      trace, {*arguments.prefetch, chosen.policy, chosen.pages, chosen.seed, arguments.pins});
  return {{"model", name(*arguments.prefetch)},
          {"accuracy", result.accuracy()},
          {"coverage", result.coverage()},
          {"pollution", result.pollution()},
          {"misses", result.misses},
          {"misses_without", result.misses_without}};
}

nlohmann::json reportOf(const Simulated& simulated, const SimulationConfig& chosen,
                        const nlohmann::json& prefetch) {
  nlohmann::json report = nlohmann::json::parse(toJson(simulated.rows));
  report["command"] = "simulate";
  report["page_bytes"] = simulated.chosen_trace.page_bytes;
  report["chosen"] = {{"policy", name(chosen.policy)}, {"pages", chosen.pages}};
  report["pinned"] = chosen.pin_clusters && !simulated.chosen_trace.visits.empty();
  report["resized"] = simulated.chosen_trace.resized;
  if (!prefetch.is_null()) report["prefetch"] = prefetch;
  return report;
}

int run(const Arguments& arguments) {
  const std::unique_ptr<ReplaySource> source = sourceOf(arguments);
  const SimulationConfig chosen = chosenConfig(arguments, *source);
  Simulated simulated = simulateAll(arguments, *source, chosen);
  nlohmann::json prefetch;
  if (arguments.prefetch || !arguments.export_file.empty()) {
    const Trace records = source->records(chosen.pages);
    if (arguments.prefetch) prefetch = prefetchJson(records, arguments, chosen);
    if (!arguments.export_file.empty()) exportTrace(records, arguments.export_file);
  }
  if (!arguments.html_file.empty())
    writeHtml(arguments.html_file, arguments, *source, chosen, simulated);
  const nlohmann::json report = reportOf(simulated, chosen, prefetch);
  if (isPage(arguments.report_file))
    writeHtml(arguments.report_file, arguments, *source, chosen, simulated);
  else if (!arguments.report_file.empty())
    writeReport(arguments.report_file, report);
  if (!arguments.csv_file.empty()) writeText(arguments.csv_file, toCsv(simulated.rows));
  for (const std::string& line : source->warnings()) printWarning(line);
  if (arguments.json) {
    say("{}\n", report.dump(2));
    return 0;
  }
  if (arguments.turn.resources.quiet) return 0;
  printTable(source->title(), simulated, chosen);
  if (!prefetch.is_null())
    say("prefetch {}: accuracy {:.3f}, coverage {:.3f}, pollution {:.4f}\n",
        name(*arguments.prefetch), prefetch["accuracy"].get<double>(),
        prefetch["coverage"].get<double>(), prefetch["pollution"].get<double>());
  for (const std::string& file :
       {arguments.html_file, arguments.report_file, arguments.csv_file, arguments.export_file})
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

// What does not go together is a usage error, before anything is read.
void checkArguments(const CLI::App& app, const Arguments& arguments,
                    const std::vector<std::string>& of_volumes) {
  const std::vector<std::string>& inputs = arguments.turn.volume.inputs;
  if (inputs.size() > 1 && arguments.format)
    throw CLI::ValidationError(inputs[1], "one trace is replayed at a time");
  for (size_t i = 0; inputs.size() > 1 && i < inputs.size(); ++i)
    if (isTraceFile(inputs[i]))
      throw CLI::ValidationError(inputs[i],
                                 "one trace is replayed at a time, and nothing beside it");
  const bool is_trace = arguments.isTrace();
  for (const std::string& name : of_volumes)
    if (is_trace && app.count(name) > 0)
      throw CLI::ValidationError(name, "is for volumes, and " + inputs.front() + " is a trace");
  if (!is_trace && app.count("--page-bytes") > 0)
    throw CLI::ValidationError("--page-bytes",
                               "is for traces, and " + inputs.front() + " is a volume; see --page");
}

std::optional<std::vector<uint64_t>> parseSizes(const std::string& given) {
  constexpr uint64_t kMostPages = uint64_t{1} << 40;
  std::vector<uint64_t> sizes;
  for (size_t at = 0; at <= given.size();) {
    const size_t comma = std::min(given.find(',', at), given.size());
    const auto size = parseIn<uint64_t>(given.substr(at, comma - at), {1, kMostPages});
    if (!size) return std::nullopt;
    sizes.push_back(*size);
    at = comma + 1;
  }
  return sizes;
}

}  // namespace

Command addSimulate(CLI::App& program) {
  auto arguments = std::make_shared<Arguments>();
  CLI::App* app = program.add_subcommand(
      "simulate",
      "Replays a trace, or a turn around a volume, through policies and cache sizes\n\n"
      "  sluice simulate bonsai.nii.gz --threshold 40 --page 32x64x2 --pages 256 "
      "--html report.html");
  TurnArguments& turn = arguments->turn;
  const size_t before = app->get_options().size();
  addVolumeOptions(*app, turn.volume);
  addPictureOptions(*app, turn.look, turn.frame, turn.fit);
  // What is left out of a frame depends on its picture or on the clock.
  for (const char* name : {"--occlusion", "--time-limit"})
    app->remove_option(app->get_option(name));
  const OptionGroup replay(*app, "Simulation");
  addFramesOption(replay, turn.frames, "Volume: views of the turn");
  replay.flag("--fixed-plan", turn.is_plan_fixed,
              "Volume: replays the chunks planned for --pages at every size; else each size is "
              "planned anew, as render does");
  std::vector<std::string> of_volumes = optionsSince(*app, before);
  of_volumes.insert(of_volumes.end(), {"--page", "--block"});
  addResourceOptions(*app, turn.resources);
  replay.choice(
      "--format",
      wordsOf<TraceFormat>(std::array{TraceFormat::kText, TraceFormat::kBinary, TraceFormat::kCsv,
                                      TraceFormat::kOracleGeneral, TraceFormat::kDin},
                           [](TraceFormat format) { return name(format); }),
      arguments->format, "Trace: its format, where the name does not say");
  replay.bytes("--page-bytes", arguments->page_bytes,
               "Trace: bytes of a page where the format does not say (4096)");
  std::vector<PolicyKind> kinds(onlinePolicies().begin(), onlinePolicies().end());
  kinds.push_back(PolicyKind::kBelady);
  kinds.push_back(PolicyKind::kBeladyPages);
  const auto policies = wordsOf<PolicyKind>(kinds, [](PolicyKind kind) { return name(kind); });
  replay.choices("--policies", policies, arguments->policies,
                 "Rows of the table (all): " + listed(namesOf(policies)));
  replay.parsed(
      "--sizes", "PAGES,...", "whole numbers with commas between, each from 1 to 2^40", parseSizes,
      [arguments](const std::vector<uint64_t>& sizes) { arguments->sizes = sizes; },
      "Cache sizes in pages (powers of two to what holds all)");
  Words<std::string> machines;
  for (const PageConfiguration& machine : pageConfigurations())
    machines.emplace_back(machine.name, machine.name);
  replay
      .choice("--machine", machines, arguments->machine,
              "Cache size of a named machine: " + listed(namesOf(machines)))
      ->excludes(app->get_option("--pages"));
  replay.choice("--pin", Words<bool>{{"auto", true}, {"off", false}}, arguments->pins,
                "Whether the chunks of a cluster stay until the next one, as in the renderer: "
                "where the trace carries clusters, or never");
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
  output.text("--csv", "FILE", arguments->csv_file, "The table");
  output.text("--export", "FILE", arguments->export_file,
              "The requests (of a volume: to a cache of --pages), also for other simulators: "
              ".txt, .csv, .oracleGeneral, .din, else compact binary");
  addForceOption(output, arguments->force);
  addQuietOption(output, arguments->turn.resources.quiet);
  addJsonOption(output, arguments->json);
  app->parse_complete_callback(
      [app, arguments, of_volumes] { checkArguments(*app, *arguments, of_volumes); });
  return [arguments] {
    if (arguments->turn.resources.pages)
      arguments->turn.fixed_pages = static_cast<uint64_t>(*arguments->turn.resources.pages);
    return run(*arguments);
  };
}

}  // namespace sluice
