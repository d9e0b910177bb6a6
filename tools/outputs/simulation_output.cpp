#include "tools/outputs/simulation_output.h"

#include <fmt/format.h>

#include <algorithm>

#include "src/base/values/bytes.h"
#include "tools/command_line/console.h"

namespace sluice {
namespace {

using nlohmann::json;

// The labels of a run or of a row, if there are several. Channels are numbers, "over" or "sum".
void addLabels(json& object, const auto& labelled) {
  if (!labelled.trace.empty()) object["trace"] = labelled.trace;
  if (!labelled.page.empty()) object["page"] = labelled.page;
  const std::string& channel = labelled.channel;
  if (channel.empty()) return;
  const bool is_number = channel.find_first_not_of("0123456789") == std::string::npos;
  object["channel"] = is_number ? json::parse(channel) : json(channel);
}

json labelledRows(std::span<const SimulationRow> rows) {
  json labelled = rowsJson(rows);
  for (size_t i = 0; i < rows.size(); ++i) addLabels(labelled[i], rows[i]);
  return labelled;
}

// At every size at which the miss ratio changes, thinned evenly to a limit.
json lruCurveJson(const LruCurve& lru) {
  constexpr size_t kMostPoints = 1000;
  const std::vector<MissRatioCurve::Step>& steps = lru.curve.steps;
  const size_t count = std::min(kMostPoints, steps.size());
  json pages = json::array(), ratios = json::array();
  for (size_t i = 0; i < count; ++i) {
    // The first and the last one always stay.
    const MissRatioCurve::Step& step = steps[count < 2 ? 0 : i * (steps.size() - 1) / (count - 1)];
    pages.push_back(step.pages);
    ratios.push_back(lru.curve.missRatioAt(step.pages));
  }
  return {{"policy", "lru"},
          {"kind", lru.sampled_chunks > 0 ? "sampled" : "exact"},
          {"sampling_rate", lru.sampling_rate},
          {"sampled_chunks", lru.sampled_chunks},
          {"stated_error", lru.curve.stated_error},
          {"pages", pages},
          {"miss_ratio", ratios}};
}

// The rows of each policy in the order of their sizes.
void addSimulatedCurves(const SimulatedRun& run, json& curves) {
  std::vector<PolicyKind> done;
  for (const SimulationRow& first : run.rows) {
    if (std::count(done.begin(), done.end(), first.policy) > 0) continue;
    done.push_back(first.policy);
    json curve{{"policy", name(first.policy)}, {"kind", "simulated"}};
    for (const SimulationRow& row : run.rows)
      if (row.policy == first.policy) {
        curve["pages"].push_back(row.pages);
        curve["miss_ratio"].push_back(row.missRatio());
      }
    addLabels(curve, run);
    curves.push_back(std::move(curve));
  }
}

json prefetchJson(const PrefetchResult& result, PrefetchModel model) {
  const std::optional<double> accuracy = result.accuracy();
  return {{"model", name(model)},          {"accuracy", accuracy ? json(*accuracy) : json()},
          {"coverage", result.coverage()}, {"pollution", result.pollution()},
          {"misses", result.misses},       {"misses_without", result.misses_without}};
}

json factsJson(const SimulatedRun& run) {
  return {{"page_bytes", run.page_bytes},
          {"chosen", {{"policy", name(run.chosen.policy)}, {"pages", run.chosen.pages}}},
          {"pinned", run.is_pinned},
          {"resized", run.resized}};
}

// Channels and page sizes may have the same lines.
std::vector<std::string> warningsOf(std::span<const SimulatedRun> runs) {
  std::vector<std::string> lines;
  for (const SimulatedRun& run : runs)
    for (const auto* of_run : {&run.warnings, &run.opening_notes})
      for (const std::string& line : *of_run)
        if (std::ranges::find(lines, line) == lines.end()) lines.push_back(line);
  return lines;
}

std::vector<SimulationRow> allRows(std::span<const SimulatedRun> runs) {
  std::vector<SimulationRow> rows;
  for (const SimulatedRun& run : runs) rows.insert(rows.end(), run.rows.begin(), run.rows.end());
  return rows;
}

void printRows(std::span<const SimulationRow> rows) {
  say("{:<13} {:>8} {:>8} {:>10} {:>13} {:>10} {:>10} {:>10} {:>10} {:>10} {:>10} {:>9} {:>7}\n",
      "policy", "pages", "planned", "miss ratio", "page requests", "hits", "misses", "compulsory",
      "capacity", "conflict", "moved", "seconds", "failed");
  bool any_failed = false;
  for (const SimulationRow& row : rows) {
    any_failed |= row.failures > 0;
    say("{:<13} {:>8} {:>8} {:>10.4f} {:>13} {:>10} {:>10} {:>10} {:>10} {:>10} {:>10} {:>9.4f} "
        "{:>7}{}\n",
        name(row.policy), row.pages,
        row.planned_pages ? fmt::format("{}", *row.planned_pages) : "-", row.missRatio(),
        row.requests, row.hits, row.misses, row.compulsory, row.capacity, row.conflict,
        formatBytes(row.bytes.moved), row.modelled_seconds, row.failures,
        row.failures > 0 ? " !" : "");
  }
  if (any_failed)
    say("! chunk requests that do not fit the cache: the renderer would stop there; each costs "
        "its bytes every time\n");
}

void printSampled(const SimulatedRun& run) {
  say("{:>12} {:>12} {:>10}\n", "pages", "cache", "miss ratio");
  for (const uint64_t pages : run.sizes)
    say("{:>12} {:>12} {:>10.4f}\n", pages, formatBytes(pages * run.page_bytes),
        run.lru->curve.missRatioAt(pages));
}

}  // namespace

json simulationJson(std::span<const SimulatedRun> runs, const SimulateArguments& arguments) {
  json report{{"rows", labelledRows(allRows(runs))}};
  const std::vector<SimulationRow> sum = sumOfChannels(runs);
  if (!sum.empty()) report["sum"] = labelledRows(sum);
  report["command"] = "simulate";
  report["warnings"] = warningsOf(runs);
  report.update(factsJson(runs.front()));
  json& curves = report["curves"] = json::array();
  for (const SimulatedRun& run : runs) {
    if (run.lru) {
      curves.push_back(lruCurveJson(*run.lru));
      addLabels(curves.back(), run);
    }
    addSimulatedCurves(run, curves);
  }
  if (runs.size() > 1)
    for (const SimulatedRun& run : runs) {
      json& facts = report["runs"].emplace_back(factsJson(run));
      addLabels(facts, run);
      if (run.prefetch) facts["prefetch"] = prefetchJson(*run.prefetch, *arguments.prefetch);
    }
  if (runs.front().prefetch)
    report["prefetch"] = prefetchJson(*runs.front().prefetch, *arguments.prefetch);
  return report;
}

std::string simulationCsv(std::span<const SimulatedRun> runs) {
  std::vector<SimulationRow> rows = allRows(runs);
  for (SimulationRow& sum : sumOfChannels(runs)) rows.push_back(std::move(sum));
  return toCsv(rows);
}

void printSimulation(const SimulatedRun& run, const SimulateArguments& arguments) {
  say("{}\n", run.title);
  for (const auto& [what, value] : run.facts) say("  {}: {}\n", what, value);
  if (arguments.sample_rate)
    printSampled(run);
  else
    printRows(run.rows);
  if (run.prefetch) {
    const std::optional<double> accuracy = run.prefetch->accuracy();
    say("prefetch {}: accuracy {}, coverage {:.3f}, pollution {:.4f}\n", name(*arguments.prefetch),
        accuracy ? fmt::format("{:.3f}", *accuracy) : "-", run.prefetch->coverage(),
        run.prefetch->pollution());
  }
}

void printSum(std::span<const SimulatedRun> runs) {
  const std::vector<SimulationRow> rows = sumOfChannels(runs);
  // A table for each page size.
  for (auto first = rows.begin(); first != rows.end();) {
    const auto end = std::find_if(
        first, rows.end(), [&](const SimulationRow& row) { return row.page != first->page; });
    say("all channels together{}\n", first->page.empty() ? "" : ", pages of " + first->page);
    printRows({first, end});
    first = end;
  }
}

}  // namespace sluice
