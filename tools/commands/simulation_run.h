// The work of `sluice simulate`: each trace, or the turn around each channel of a volume with each
// page size, through policies and cache sizes. Each of these is a run; runs follow one another, so
// that only one trace is in memory at a time.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "cache/simulate/prefetch.h"
#include "cache/simulate/simulation_report.h"
#include "tools/command_line/outputs.h"
#include "tools/scene/turn.h"

namespace sluice {

struct SimulateArguments {
  TurnArguments turn;             // its volume names the traces, too
  std::vector<Vec3i> page_sizes;  // for volumes, a run each; empty: the volume's own
  std::optional<TraceFormat> format;
  uint64_t page_bytes = 4096;
  std::vector<PolicyKind> policies;
  std::vector<uint64_t> sizes;
  std::string machine;
  bool pins = true;
  bool by_page = false;
  std::optional<PrefetchModel> prefetch;
  std::optional<double>
      sample_rate;  // share of the chunks: LRU's approximate curve and nothing else
  std::string html_file, csv_file, export_file, report_file;
  bool force = false;
  bool json = false;

  bool isTrace() const { return format || isTraceFile(turn.volume.inputs.front()); }
  bool wantsPage() const;  // --html, or --report with a page's name
  size_t runs() const;     // how many, for each channel
};

// LRU's miss ratio by cache size, from a sample of the chunks (SHARDS) or exact.
struct LruCurve {
  MissRatioCurve curve;  // its stated_error: the mean over sizes, in miss ratio; 0 if exact
  double sampling_rate = 1;
  uint64_t sampled_chunks = 0;  // 0 if exact
};

struct SimulatedRun {
  std::string title;
  std::string trace, page, channel;  // the values in its rows
  std::vector<std::pair<std::string, std::string>> facts;
  SimulationConfig chosen;
  uint64_t page_bytes = 0, resized = 0;
  bool is_pinned = false;
  std::vector<SimulationRow> rows;  // every policy at every size, sizes in the outer loop
  std::vector<uint64_t> sizes;      // of the rows
  std::vector<uint64_t> asked;      // the sizes that were asked for, see ReplaySource
  uint64_t asked_chosen = 0;        // of `chosen`
  std::optional<LruCurve> lru;      // none if the requests differ from size to size
  std::optional<PrefetchResult> prefetch;
  std::optional<SimulationReport> report;  // if a page is wanted
  std::string export_file;                 // the file of --export; may be empty
  std::vector<std::string> warnings;       // to be printed
  std::vector<std::string> opening_notes;  // printed already
};

// Files that are read and written, by the options' names.
Outputs outputsOf(const SimulateArguments& arguments);

// The channel of a sum in tables.
inline constexpr const char* kSumOfChannels = "sum";
// All caches of the channels together: rows for the sizes that each channel has, and for the cache
// that the renderer gives each. Empty if there is only one channel.
std::vector<SimulationRow> sumOfChannels(std::span<const SimulatedRun> runs);

// Reads, replays and, for --export, writes the requests. Throws Error: a damaged or empty trace, a
// volume that cannot be read, a cache too small to plan for, a sample without chunks.
std::vector<SimulatedRun> simulateRuns(const SimulateArguments& arguments);

}  // namespace sluice
