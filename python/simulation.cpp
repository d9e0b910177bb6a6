#include "python/simulation.h"

#include <fmt/format.h>
#include <pybind11/pybind11.h>

#include <nlohmann/json.hpp>

#include "cache/simulate/simulation_report.h"
#include "cache/simulate/simulator.h"
#include "cache/trace/prepared_trace.h"
#include "cache/trace/trace.h"
#include "src/base/error.h"

namespace sluice::python {
namespace {

// Sizes for a table begin with those around it, as those of `sluice simulate` do.
constexpr uint64_t kUsualPages = 256;

PreparedTrace traceOf(const SimulationRequest& request) {
  std::optional<TraceFormat> format;
  if (request.format) {
    format = parseTraceFormat(*request.format);
    if (!format)
      failRequest("format: expected text, binary, csv, oracleGeneral or din, found {}",
                  *request.format);
  }
  if (request.page_bytes < 1) failRequest("page_bytes: expected at least 1, found 0");
  const auto reader = openTrace(request.trace, format, request.page_bytes);
  TracePreparer preparer(reader->pageBytes(), reader->carriesClusters());
  TraceRecord record;
  size_t count = 0;
  for (; reader->next(record); ++count) preparer.add(record);
  if (count == 0) fail("{}: the trace is empty: it holds no requests", request.trace);
  return preparer.finish();
}

std::vector<PolicyKind> policiesOf(const std::vector<std::string>& names) {
  if (names.empty()) return {allPolicies().begin(), allPolicies().end()};
  std::vector<PolicyKind> kinds;
  for (const std::string& word : names) {
    const std::optional<PolicyKind> kind = parsePolicy(word);
    if (!kind) {
      std::vector<std::string_view> known;
      for (const PolicyKind each : allPolicies()) known.push_back(name(each));
      throw pybind11::value_error(
          fmt::format("policies: expected some of {}, found '{}'", fmt::join(known, ", "), word));
    }
    kinds.push_back(*kind);
  }
  return kinds;
}

}  // namespace

std::string simulatedRows(const SimulationRequest& request) {
  const std::vector<PolicyKind> policies = policiesOf(request.policies);
  for (const uint64_t pages : request.sizes)
    if (pages < 1) failRequest("sizes: expected at least one page, found 0");
  const PreparedTrace trace = traceOf(request);
  const std::vector<uint64_t> sizes =
      request.sizes.empty() ? defaultSizes(trace, kUsualPages) : request.sizes;
  SimulationConfig config;
  config.pin_clusters = request.pins;
  return nlohmann::json{{"rows", rowsJson(simulateTable(trace, policies, sizes, config))}}.dump();
}

}  // namespace sluice::python
