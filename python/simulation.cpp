#include "python/simulation.h"

#include <fmt/format.h>

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
  if (count == 0) fail("{}: the trace holds no requests; is it cut?", request.trace);
  return preparer.finish();
}

std::vector<PolicyKind> policiesOf(const std::vector<std::string>& names) {
  std::vector<PolicyKind> kinds;
  for (const std::string& word : names) {
    const std::optional<PolicyKind> kind = parsePolicy(word);
    if (!kind) failRequest("policies: no policy is called {}", word);
    kinds.push_back(*kind);
  }
  if (!kinds.empty()) return kinds;
  kinds.assign(onlinePolicies().begin(), onlinePolicies().end());
  kinds.insert(kinds.end(), {PolicyKind::kBelady, PolicyKind::kBeladyPages});
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
  return toJson(simulateTable(trace, policies, sizes, config));
}

}  // namespace sluice::python
