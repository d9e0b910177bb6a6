#include "tools/commands/simulation_run.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <memory>

#include "cache/model/page_geometry.h"
#include "src/base/error.h"
#include "src/base/values/bytes.h"
#include "tools/pages/report_file.h"
#include "tools/scene/open_scene.h"

namespace sluice {
namespace {

// Throws Error if a file is neither: opening a pipe would wait for someone to write into it.
void refusePipe(const std::string& name) {
  std::error_code none;
  const std::filesystem::file_status status = std::filesystem::status(name, none);
  if (std::filesystem::is_fifo(status) || std::filesystem::is_socket(status) ||
      std::filesystem::is_character_file(status))
    fail(
        "{}: expected a trace or a volume, found a pipe or a device; copy its contents into a file",
        name);
}

std::vector<PolicyKind> policiesOf(const SimulateArguments& arguments) {
  std::vector<PolicyKind> kinds = arguments.policies;
  if (kinds.empty()) {
    kinds.assign(onlinePolicies().begin(), onlinePolicies().end());
    kinds.push_back(PolicyKind::kBelady);
    kinds.push_back(PolicyKind::kBeladyPages);
  }
  return kinds;
}

// The cache that facts, plots and reading ahead are of.
SimulationConfig chosenConfig(const SimulateArguments& arguments, const ReplaySource& source) {
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

// A run while it is computed.
class Run {
 public:
  Run(const SimulateArguments& arguments, ReplaySource& source)
      : arguments_(arguments), source_(source) {
    result_.title = source.title();
    result_.chosen = chosenConfig(arguments, source);
  }

  SimulatedRun simulate() {
    trace_ = asRequested(source_.requests(result_.chosen.pages));
    result_.page_bytes = trace_.page_bytes;
    result_.resized = trace_.resized;
    result_.is_pinned = result_.chosen.pin_clusters && !trace_.visits.empty();
    result_.facts = factsOf(trace_, result_.chosen);
    result_.sizes = arguments_.sizes;
    if (result_.sizes.empty()) {
      result_.sizes = defaultSizes(trace_, result_.chosen.pages);
      std::erase_if(result_.sizes, [&](uint64_t pages) { return pages < source_.leastPages(); });
    }
    for (const uint64_t pages : result_.sizes) addRows(pages, result_.rows);
    if (is_one_trace_) result_.lru = LruCurve{lruCurve(trace_)};
    if (arguments_.wantsPage()) makePage();
    if (arguments_.prefetch || !arguments_.export_file.empty()) useRecords();
    result_.warnings = source_.warnings();
    return std::move(result_);
  }

  // LRU alone, from a sample: the trace is never in memory.
  SimulatedRun sample() {
    const double rate = *arguments_.sample_rate;
    ShardsEstimator shards = ShardsEstimator::fixedRate(rate, result_.chosen.seed);
    result_.page_bytes = source_.visit(result_.chosen.pages, [&](const TraceRecord& record) {
      shards.request(record.chunk, record.pages);
    });
    if (shards.sampledChunks() == 0)
      fail("{}: --sample {} took none of its chunks; give a larger rate", result_.title, rate);
    result_.lru = LruCurve{shards.curve(), shards.rate(), shards.sampledChunks()};
    result_.sizes = arguments_.sizes;
    if (result_.sizes.empty())
      for (uint64_t pages = 1;; pages *= 2) {
        result_.sizes.push_back(pages);
        if (pages >= result_.lru->curve.steps.back().pages) break;
      }
    result_.facts = {
        {"Page requests", fmt::format("{:.0f}", result_.lru->curve.requests)},
        {"Page", formatBytes(result_.page_bytes)},
        {"Sampled chunks", fmt::format("{}, at a rate of {:g}", shards.sampledChunks(), rate)},
        {"Expected error", fmt::format("at most {:.3f} of the miss ratio, as a mean over sizes",
                                       result_.lru->curve.stated_error)}};
    result_.warnings = source_.warnings();
    return std::move(result_);
  }

 private:
  // Page by page if that is asked for, within the memory that the program may take.
  PreparedTrace asRequested(PreparedTrace chunks) const {
    if (!arguments_.by_page) return chunks;
    constexpr uint64_t kBytesARequest = 8, kBytesAPage = 64;
    const uint64_t budget = memoryBudget(arguments_.turn.resources);
    if (chunks.page_requests > budget / (2 * kBytesARequest) ||
        chunks.distinct_pages > budget / (2 * kBytesAPage))
      fail(
          "{}: --by-page needs {} for {} page requests of {} pages; give as much as --memory or "
          "replay whole chunks",
          result_.title,
          formatBytes(2 * std::max(chunks.page_requests * kBytesARequest,
                                   chunks.distinct_pages * kBytesAPage)),
          chunks.page_requests, chunks.distinct_pages);
    return splitIntoPages(chunks);
  }

  void addRows(uint64_t pages, std::vector<SimulationRow>& rows) {
    const std::optional<uint64_t> planned = source_.plannedPages(pages);
    std::optional<PreparedTrace> other;
    if (planned != source_.plannedPages(result_.chosen.pages)) {
      other = asRequested(source_.requests(pages));
      is_one_trace_ = false;
    }
    const size_t before = rows.size();
    const std::vector<SimulationRow> more =
        simulateTable(other ? *other : trace_, policiesOf(arguments_), {&pages, 1}, result_.chosen);
    rows.insert(rows.end(), more.begin(), more.end());
    for (size_t i = before; i < rows.size(); ++i) rows[i].planned_pages = planned;
  }

  void makePage() {
    std::vector<SimulationRow> rows = result_.rows;
    // The page shows the chosen size, asked for in the table or not.
    if (std::count(result_.sizes.begin(), result_.sizes.end(), result_.chosen.pages) == 0)
      addRows(result_.chosen.pages, rows);
    result_.report =
        makeReport(trace_, result_.title, std::move(rows), is_one_trace_, result_.chosen);
  }

  void useRecords() {
    const Trace records = source_.records(result_.chosen.pages);
    if (arguments_.prefetch) {
      if (!records.carries_clusters)
        fail("{}: --prefetch models reading ahead of clusters, and this trace carries none",
             result_.title);
      result_.prefetch =
          simulatePrefetch(records, {*arguments_.prefetch, result_.chosen.policy,
                                     result_.chosen.pages, result_.chosen.seed, arguments_.pins});
    }
    if (arguments_.export_file.empty()) return;
    const auto writer = makeTraceWriter(arguments_.export_file,
                                        traceFormatOf(arguments_.export_file), records.page_bytes);
    for (const TraceRecord& record : records.records) writer->write(record);
    writer->finish();
  }

  const SimulateArguments& arguments_;
  ReplaySource& source_;
  SimulatedRun result_;
  PreparedTrace trace_;       // for the chosen cache
  bool is_one_trace_ = true;  // the same requests at every size
};

SimulatedRun runOf(const SimulateArguments& arguments, ReplaySource& source, std::string trace,
                   std::string page) {
  Run run(arguments, source);
  SimulatedRun result = arguments.sample_rate ? run.sample() : run.simulate();
  if (!page.empty()) result.title += ", pages of " + page;
  if (result.report) result.report->title = result.title;
  for (SimulationRow& row : result.rows) {
    row.trace = trace;
    row.page = page;
  }
  result.trace = std::move(trace);
  result.page = std::move(page);
  return result;
}

}  // namespace

bool SimulateArguments::wantsPage() const {
  return !html_file.empty() || isPage(report_file);
}

size_t SimulateArguments::runs() const {
  return isTrace() ? turn.volume.inputs.size() : std::max<size_t>(1, page_sizes.size());
}

Outputs outputsOf(const SimulateArguments& arguments) {
  Outputs outputs(arguments.force);
  outputs.reads(arguments.turn.volume.inputs);
  outputs.reads(arguments.turn.look.transfer_file);
  outputs.writes("--html", arguments.html_file, FileKind::kPage);
  outputs.writes("--report", arguments.report_file, reportKind(arguments.report_file));
  if (arguments.csv_file != "-") outputs.writes("--csv", arguments.csv_file, FileKind::kTable);
  outputs.writesTrace("--export", arguments.export_file);
  return outputs;
}

std::vector<SimulatedRun> simulateRuns(const SimulateArguments& arguments) {
  const std::vector<std::string>& inputs = arguments.turn.volume.inputs;
  const Outputs outputs = outputsOf(arguments);
  outputs.checkNames();
  refusePipe(inputs.front());
  const bool is_named = arguments.runs() > 1;
  std::vector<SimulatedRun> runs;
  if (arguments.isTrace()) {
    outputs.check();
    for (const std::string& file : inputs) {
      const auto source = openTraceFile(file, arguments.format, arguments.page_bytes);
      runs.push_back(runOf(arguments, *source, is_named ? file : "", ""));
    }
    return runs;
  }
  std::vector<std::optional<Vec3i>> sizes(arguments.page_sizes.begin(), arguments.page_sizes.end());
  if (sizes.empty()) sizes.emplace_back();
  for (const std::optional<Vec3i>& size : sizes) {
    TurnArguments turn = arguments.turn;
    if (size) turn.resources.page_vox = *size;
    const auto source = openTurn(turn, outputs);
    runs.push_back(runOf(arguments, *source, "", is_named ? printPageSize(*size) : ""));
  }
  return runs;
}

}  // namespace sluice
