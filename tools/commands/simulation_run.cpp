#include "tools/commands/simulation_run.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <memory>

#include "cache/model/page_geometry.h"
#include "io/formats.h"
#include "src/base/error.h"
#include "src/base/values/bytes.h"
#include "src/library/drawing/files/channel_traces.h"
#include "src/library/opening/channel_looks.h"
#include "tools/pages/report_file.h"

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

std::span<const PolicyKind> policiesOf(const SimulateArguments& arguments) {
  return arguments.policies.empty() ? allPolicies() : arguments.policies;
}

// The size that is asked for of the cache that facts, plots and reading ahead are of.
uint64_t chosenPages(const SimulateArguments& arguments, const ReplaySource& source) {
  if (arguments.turn.resources.pages) return static_cast<uint64_t>(*arguments.turn.resources.pages);
  if (!arguments.machine.empty())
    return static_cast<uint64_t>(findPageConfiguration(arguments.machine)->geometry.pages);
  return arguments.sizes.empty() ? source.defaultPages() : arguments.sizes.front();
}

SimulationConfig chosenConfig(const SimulateArguments& arguments, uint64_t pages) {
  SimulationConfig chosen;
  chosen.policy = arguments.turn.resources.policy;
  chosen.seed = arguments.turn.resources.seed;
  chosen.pin_clusters = arguments.pins && !arguments.by_page;
  chosen.pages = pages;
  return chosen;
}

// A run while it is computed.
class Run {
 public:
  Run(const SimulateArguments& arguments, ReplaySource& source, std::string export_file)
      : arguments_(arguments), source_(source), export_file_(std::move(export_file)) {
    result_.title = source.title();
    result_.asked_chosen = chosenPages(arguments, source);
    result_.chosen = chosenConfig(arguments, source.cachePages(result_.asked_chosen));
  }

  SimulatedRun simulate() {
    trace_ = asRequested(source_.requests(result_.asked_chosen));
    result_.page_bytes = trace_.page_bytes;
    result_.resized = trace_.resized;
    result_.is_pinned = result_.chosen.pin_clusters && !trace_.visits.empty();
    result_.facts = factsOf(trace_, result_.chosen);
    result_.asked = arguments_.sizes;
    if (result_.asked.empty()) {
      result_.asked = defaultSizes(trace_, result_.asked_chosen);
      std::erase_if(result_.asked, [&](uint64_t pages) { return pages < source_.leastPages(); });
    }
    for (const uint64_t asked : result_.asked) {
      addRows(asked, result_.rows);
      result_.sizes.push_back(source_.cachePages(asked));
    }
    if (is_one_trace_) result_.lru = LruCurve{lruCurve(trace_)};
    if (arguments_.wantsPage()) makePage();
    if (arguments_.prefetch || !export_file_.empty()) useRecords();
    result_.warnings = source_.warnings();
    result_.opening_notes = source_.openingNotes();
    return std::move(result_);
  }

  // LRU alone, from a sample: the trace is never in memory.
  SimulatedRun sample() {
    const double rate = *arguments_.sample_rate;
    ShardsEstimator shards = ShardsEstimator::fixedRate(rate, result_.chosen.seed);
    result_.page_bytes = source_.visit(result_.asked_chosen, [&](const TraceRecord& record) {
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
    result_.opening_notes = source_.openingNotes();
    return std::move(result_);
  }

 private:
  // Page by page if that is asked for, within the memory that the program may take.
  PreparedTrace asRequested(PreparedTrace chunks) const {
    if (!arguments_.by_page) return chunks;
    constexpr uint64_t kBytesARequest = 8, kBytesAPage = 64;
    const uint64_t budget = memoryBudget(arguments_.turn.resources);
    // Divided, since the products may overflow.
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

  void addRows(uint64_t asked, std::vector<SimulationRow>& rows) {
    const std::optional<uint64_t> planned = source_.plannedPages(asked);
    std::optional<PreparedTrace> other;
    if (planned != source_.plannedPages(result_.asked_chosen)) {
      other = asRequested(source_.requests(asked));
      is_one_trace_ = false;
    }
    const size_t before = rows.size();
    const uint64_t pages = source_.cachePages(asked);
    const std::vector<SimulationRow> more =
        simulateTable(other ? *other : trace_, policiesOf(arguments_), {&pages, 1}, result_.chosen);
    rows.insert(rows.end(), more.begin(), more.end());
    for (size_t i = before; i < rows.size(); ++i) rows[i].planned_pages = planned;
  }

  void makePage() {
    std::vector<SimulationRow> rows = result_.rows;
    // The page shows the chosen size, asked for in the table or not.
    if (std::count(result_.asked.begin(), result_.asked.end(), result_.asked_chosen) == 0)
      addRows(result_.asked_chosen, rows);
    result_.report =
        makeReport(trace_, result_.title, std::move(rows), is_one_trace_, result_.chosen);
  }

  void useRecords() {
    const Trace records = source_.records(result_.asked_chosen);
    if (arguments_.prefetch) {
      if (!records.carries_clusters)
        fail("{}: --prefetch models reading ahead of clusters, and this trace carries none",
             result_.title);
      result_.prefetch =
          simulatePrefetch(records, {*arguments_.prefetch, result_.chosen.policy,
                                     result_.chosen.pages, result_.chosen.seed, arguments_.pins});
    }
    if (export_file_.empty()) return;
    const auto writer =
        makeTraceWriter(export_file_, traceFormatOf(export_file_), records.page_bytes);
    for (const TraceRecord& record : records.records) writer->write(record);
    writer->finish();
  }

  const SimulateArguments& arguments_;
  ReplaySource& source_;
  const std::string export_file_;  // may be empty
  SimulatedRun result_;
  PreparedTrace trace_;       // for the chosen cache
  bool is_one_trace_ = true;  // the same requests at every size
};

// The values in the rows of a run; those that tell nothing apart are empty.
struct RunLabels {
  std::string trace = {}, page = {}, channel = {};
};

SimulatedRun runOf(const SimulateArguments& arguments, ReplaySource& source, RunLabels labels,
                   std::string export_file) {
  Run run(arguments, source, export_file);
  SimulatedRun result = arguments.sample_rate ? run.sample() : run.simulate();
  if (!labels.page.empty()) result.title += ", pages of " + labels.page;
  if (result.report) result.report->title = result.title;
  for (SimulationRow& row : result.rows) {
    row.trace = labels.trace;
    row.page = labels.page;
    row.channel = labels.channel;
  }
  result.trace = std::move(labels.trace);
  result.page = std::move(labels.page);
  result.channel = std::move(labels.channel);
  result.export_file = std::move(export_file);
  return result;
}

using Turns = std::vector<std::unique_ptr<ReplaySource>>;

// The file of each turn for --export, checked like files that the user names.
std::vector<std::string> exportFiles(const SimulateArguments& arguments, const Turns& turns) {
  const std::string& asked = arguments.export_file;
  if (asked.empty() || turns.size() == 1) return std::vector<std::string>(turns.size(), asked);
  std::vector<const ShownChannel*> channels;
  channels.reserve(turns.size());
  for (const auto& turn : turns) channels.push_back(turn->channel());
  std::vector<std::string> files = channelTraces(asked, channels);
  SimulateArguments others = arguments;
  others.export_file.clear();
  Outputs outputs = outputsOf(others);
  for (const std::string& file : files) outputs.writesTrace("--export", file);
  for (const auto& turn : turns) outputs.check(turn->files());
  return files;
}

// The positions in the runs' sizes of the sizes to add up: those that each run has.
std::vector<std::vector<size_t>> commonSizes(std::span<const SimulatedRun> runs) {
  std::vector<std::vector<size_t>> sizes;
  const auto addIfAll = [&](const auto& askedOf) {
    std::vector<size_t> at;
    for (const SimulatedRun& run : runs) {
      const auto found = std::ranges::find(run.asked, askedOf(run));
      if (found == run.asked.end()) return;
      at.push_back(static_cast<size_t>(found - run.asked.begin()));
    }
    if (std::ranges::find(sizes, at) == sizes.end()) sizes.push_back(std::move(at));
  };
  for (const uint64_t asked : runs.front().asked)
    addIfAll([&](const SimulatedRun& /*run*/) { return asked; });
  // The channels' shares of the memory may hold different numbers of pages.
  addIfAll([](const SimulatedRun& run) { return run.asked_chosen; });
  return sizes;
}

// Requires: the runs are of the channels of one picture.
std::vector<SimulationRow> sumOfRuns(std::span<const SimulatedRun> runs) {
  std::vector<SimulationRow> sums;
  for (const std::vector<size_t>& at : commonSizes(runs)) {
    const size_t policies = runs.front().rows.size() / runs.front().asked.size();
    for (size_t policy = 0; policy < policies; ++policy) {
      SimulationRow sum = runs.front().rows[at.front() * policies + policy];
      for (size_t i = 1; i < runs.size(); ++i) add(sum, runs[i].rows[at[i] * policies + policy]);
      sum.channel = kSumOfChannels;
      sums.push_back(std::move(sum));
    }
  }
  return sums;
}

// openTurn(), which knows volumes alone.
Turns openTurns(const TurnArguments& turn, const Outputs& outputs) {
  try {
    return openTurn(turn, outputs);
  } catch (const UnknownFormat& error) {
    fail(
        "{}; nor a trace: text or binary of sluice, .csv, .oracleGeneral, .bin or .din, or name "
        "its --format",
        error.what());
  }
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
  outputs.reads(arguments.turn.volume.asked.over);
  outputs.reads(filesOf(arguments.turn.look));
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
      runs.push_back(
          runOf(arguments, *source, {.trace = is_named ? file : ""}, arguments.export_file));
    }
    return runs;
  }
  std::vector<std::optional<Vec3i>> sizes(arguments.page_sizes.begin(), arguments.page_sizes.end());
  if (sizes.empty()) sizes.emplace_back();
  for (const std::optional<Vec3i>& size : sizes) {
    TurnArguments turn = arguments.turn;
    if (size) turn.resources.page_vox = *size;
    const Turns turns = openTurns(turn, outputs);
    const std::vector<std::string> files = exportFiles(arguments, turns);
    for (size_t i = 0; i < turns.size(); ++i) {
      const ShownChannel* const channel = turns[i]->channel();
      runs.push_back(runOf(arguments, *turns[i],
                           {.page = is_named ? printPageSize(*size) : "",
                            .channel = channel != nullptr ? channel->id() : ""},
                           files[i]));
    }
  }
  return runs;
}

std::vector<SimulationRow> sumOfChannels(std::span<const SimulatedRun> runs) {
  std::vector<SimulationRow> sums;
  while (!runs.empty()) {
    const std::string& page = runs.front().page;
    const auto end =
        std::ranges::find_if(runs, [&](const SimulatedRun& run) { return run.page != page; });
    const auto count = static_cast<size_t>(end - runs.begin());
    if (count > 1 && !runs.front().channel.empty() && !runs.front().rows.empty())
      for (SimulationRow& sum : sumOfRuns(runs.first(count))) sums.push_back(std::move(sum));
    runs = runs.subspan(count);
  }
  return sums;
}

}  // namespace sluice
