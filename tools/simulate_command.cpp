// sluice simulate: replays a recorded trace, or the requests that a turn around a volume would
// make, through policies and cache sizes.
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <fstream>
#include <memory>

#include "cache/miss_ratio_curve.h"
#include "cache/prefetch.h"
#include "cache/report_html.h"
#include "cache/simulation_report.h"
#include "src/base/atomic_file.h"
#include "src/base/bytes.h"
#include "src/base/error.h"
#include "src/render/frame_setup.h"
#include "src/texture/chunk_names.h"
#include "src/texture/requests.h"
#include "tools/commands.h"
#include "tools/options.h"
#include "tools/parse.h"
#include "tools/scene.h"
#include "tools/trace_files.h"

namespace sluice {
namespace {

struct Arguments {
  VolumeArguments volume;
  LookArguments look;
  FrameOptions frame;
  ResourceArguments resources;
  int64_t frames = 36;
  std::string format;
  uint64_t page_bytes = 4096;
  std::vector<std::string> policies;
  std::vector<uint64_t> sizes;
  std::string machine;
  std::string prefetch;
  std::string html_file, csv_file, export_file;
  bool by_page = false;
  bool json = false;
};

struct Replay {
  Trace trace;
  uint64_t chosen_pages = 0;
  std::string title;
};

bool isTraceFile(const std::string& name, const std::string& format) {
  if (!format.empty()) return true;
  const std::string extension = std::filesystem::path(name).extension().string();
  if (extension == ".csv" || extension == ".din" ||
      name.find(".oracleGeneral") != std::string::npos)
    return true;
  // Ours begin with their name.
  std::ifstream file(name, std::ios::binary);
  std::string start(7, '\0');
  return file.read(start.data(), 7) && (start == "sluice-" || start == "SLTRACE");
}

// The requests of a turn of `frames` views, from plans alone.
Replay turnAround(const Arguments& arguments) {
  WorkerPool pool(arguments.resources.threads);
  const IndexedVolume volume =
      openIndexed(arguments.volume, arguments.resources, needsGradients(arguments.look), pool);
  const TransferFunction transfer = transferFor(volume, arguments.look);
  const PlannedFrame planned =
      planFrame(volume, transfer, arguments.frame, arguments.volume.time, pool);
  ChunkNames chunk_names;
  const std::vector<uint64_t> names = chunk_names.namesOf(planned.plan);
  Replay replay;
  replay.title = volume.source->layout().name;
  replay.chosen_pages = static_cast<uint64_t>(volume.page.pages);
  replay.trace.page_bytes = static_cast<uint64_t>(volume.page.pageBytes());
  Camera camera = arguments.frame.camera;
  for (int64_t frame = 0; frame < arguments.frames; ++frame) {
    camera.azimuth_deg = arguments.frame.camera.azimuth_deg +
                         360.0 * static_cast<double>(frame) / static_cast<double>(arguments.frames);
    const View view =
        resolve(camera, volume.source->layout(), arguments.frame.size, arguments.frame.step_vox);
    const auto requests =
        frameRequests(planned.plan, names, eyePosition(view, volume.source->layout()), frame);
    replay.trace.records.insert(replay.trace.records.end(), requests.begin(), requests.end());
  }
  return replay;
}

Replay readTrace(const Arguments& arguments) {
  const std::string& file = arguments.volume.inputs.front();
  std::optional<TraceFormat> format;
  if (!arguments.format.empty()) format = parseTraceFormat(arguments.format);
  Replay replay;
  replay.title = file;
  replay.trace = readAll(*openTrace(file, format, arguments.page_bytes));
  replay.chosen_pages = static_cast<uint64_t>(arguments.resources.pages.value_or(256));
  return replay;
}

std::vector<PolicyKind> policiesOf(const Arguments& arguments) {
  std::vector<PolicyKind> kinds;
  for (const std::string& word : arguments.policies) {
    const auto kind = parsePolicy(word);
    if (!kind) fail("--policies {}: no policy of that name", word);
    kinds.push_back(*kind);
  }
  if (kinds.empty()) {
    kinds.assign(onlinePolicies().begin(), onlinePolicies().end());
    kinds.push_back(PolicyKind::kBelady);
    kinds.push_back(PolicyKind::kBeladyPages);
  }
  return kinds;
}

void writeText(const std::string& file, const std::string& text) {
  AtomicFile out(file);
  out.write(text);
  out.commit();
}

void exportTrace(const Trace& trace, const std::string& file) {
  const auto writer = makeTraceWriter(file, traceFormatOf(file), trace.page_bytes);
  for (const TraceRecord& record : trace.records) writer->write(record);
  writer->finish();
}

void printTable(const SimulationReport& report) {
  fmt::print("{}\n", report.title);
  for (const auto& [what, value] : report.facts) fmt::print("  {}: {}\n", what, value);
  fmt::print("{:<13} {:>8} {:>10} {:>10} {:>10} {:>10} {:>10} {:>10} {:>10} {:>9}\n", "policy",
             "pages", "requests", "hits", "misses", "compulsory", "capacity", "conflict", "moved",
             "seconds");
  for (const SimulationRow& row : report.rows)
    fmt::print("{:<13} {:>8} {:>10} {:>10} {:>10} {:>10} {:>10} {:>10} {:>10} {:>9.4f}\n",
               name(row.policy), row.pages, row.requests, row.hits, row.misses, row.compulsory,
               row.capacity, row.conflict, formatBytes(row.bytes.moved), row.modelled_seconds);
}

nlohmann::json prefetchJson(const Trace& trace, const Arguments& arguments, uint64_t pages) {
  const auto model = parsePrefetchModel(arguments.prefetch);
  if (!model)
    fail("--prefetch {}: next-cluster, next-time-step and last-order are known",
         arguments.prefetch);
  const PrefetchResult result = simulatePrefetch(
      trace, {*model, arguments.resources.policy, pages, arguments.resources.seed});
  return {{"model", arguments.prefetch},   {"accuracy", result.accuracy()},
          {"coverage", result.coverage()}, {"pollution", result.pollution()},
          {"misses", result.misses},       {"misses_without", result.misses_without}};
}

int run(const Arguments& arguments) {
  const bool from_trace = isTraceFile(arguments.volume.inputs.front(), arguments.format);
  Replay replay = from_trace ? readTrace(arguments) : turnAround(arguments);
  if (!arguments.machine.empty()) {
    const PageConfiguration* machine = findPageConfiguration(arguments.machine);
    if (machine == nullptr)
      fail("--machine {}: octane, octane-4mb, sparse-8, sparse-16 and sparse-32 are known",
           arguments.machine);
    replay.chosen_pages = static_cast<uint64_t>(machine->geometry.pages);
  }
  if (!arguments.export_file.empty()) exportTrace(replay.trace, arguments.export_file);

  const PreparedTrace prepared =
      prepare(replay.trace, arguments.by_page ? Granularity::kPages : Granularity::kChunks);
  const std::vector<uint64_t> sizes =
      arguments.sizes.empty() ? defaultSizes(prepared, replay.chosen_pages) : arguments.sizes;
  SimulationConfig chosen;
  chosen.policy = arguments.resources.policy;
  chosen.pages = replay.chosen_pages;
  chosen.pin_clusters = !arguments.by_page;
  chosen.seed = arguments.resources.seed;
  SimulationReport report =
      makeReport(replay.trace, replay.title, policiesOf(arguments), sizes, chosen);
  if (arguments.by_page) {
    report.rows = simulateTable(prepared, policiesOf(arguments), sizes, chosen);
    report.lru = lruCurve(prepared);
  }
  if (!arguments.html_file.empty()) writeText(arguments.html_file, htmlReport(report));
  if (!arguments.csv_file.empty()) writeText(arguments.csv_file, toCsv(report.rows));
  if (arguments.json) {
    nlohmann::json json = nlohmann::json::parse(toJson(report.rows));
    json["command"] = "simulate";
    json["page_bytes"] = replay.trace.page_bytes;
    json["chosen"] = {{"policy", name(chosen.policy)}, {"pages", chosen.pages}};
    if (!arguments.prefetch.empty())
      json["prefetch"] = prefetchJson(replay.trace, arguments, replay.chosen_pages);
    fmt::print("{}\n", json.dump(2));
    return 0;
  }
  printTable(report);
  if (!arguments.prefetch.empty()) {
    const auto json = prefetchJson(replay.trace, arguments, replay.chosen_pages);
    fmt::print("prefetch {}: accuracy {:.3f}, coverage {:.3f}, pollution {:.4f}\n",
               arguments.prefetch, json["accuracy"].get<double>(), json["coverage"].get<double>(),
               json["pollution"].get<double>());
  }
  for (const std::string& file : {arguments.html_file, arguments.csv_file, arguments.export_file})
    if (!file.empty()) fmt::print("{}\n", file);
  return 0;
}

}  // namespace

Command addSimulate(CLI::App& program) {
  auto arguments = std::make_shared<Arguments>();
  CLI::App* app = program.add_subcommand(
      "simulate",
      "Replays a trace, or a turn around a volume, through policies and cache sizes\n\n"
      "  sluice simulate bonsai.nii.gz --threshold 40 --page 32x64x2 --pages 256 "
      "--html report.html");
  addVolumeOptions(*app, arguments->volume);
  addLookOptions(*app, arguments->look);
  addViewOptions(*app, arguments->frame);
  addResourceOptions(*app, arguments->resources);
  app->add_option("--frames", arguments->frames, "Volume: views of the turn")
      ->capture_default_str()
      ->check(CLI::Range(1, 1000000));
  app->add_option("--format", arguments->format,
                  "Trace: text, binary, csv, oracleGeneral or din, where the name does not say")
      ->check(CLI::IsMember({"text", "binary", "csv", "oracleGeneral", "din"}));
  addParsed(*app, "--page-bytes", "Trace: bytes of a page where the format does not say (4096)",
            "BYTES", parseBytes, [arguments](uint64_t bytes) {
              if (bytes == 0) throw CLI::ValidationError("--page-bytes", "must be above 0");
              arguments->page_bytes = bytes;
            });
  app->add_option("--policies", arguments->policies, "Rows of the table (all)")
      ->delimiter(',')
      ->type_name("NAMES");
  app->add_option("--sizes", arguments->sizes, "Cache sizes in pages (powers of two)")
      ->delimiter(',')
      ->check(CLI::Range(uint64_t{1}, uint64_t{1} << 40))
      ->type_name("PAGES");
  app->add_option(
      "--machine", arguments->machine,
      "Cache size of a named machine: octane, octane-4mb, sparse-8, sparse-16, sparse-32");
  app->add_flag("--by-page", arguments->by_page, "Every page is an entry of its own");
  app->add_option("--prefetch", arguments->prefetch,
                  "Also models reading ahead: next-cluster, next-time-step or last-order")
      ->type_name("MODEL");
  app->add_option("--html", arguments->html_file, "Self-contained report with plots")
      ->type_name("FILE");
  app->add_option("--csv", arguments->csv_file, "The table")->type_name("FILE");
  app->add_option("--export", arguments->export_file,
                  "The trace, for another simulator: .txt, .csv, .oracleGeneral, .din")
      ->type_name("FILE");
  app->add_flag("--json", arguments->json, "One JSON object");
  return [arguments] { return run(*arguments); };
}

}  // namespace sluice
