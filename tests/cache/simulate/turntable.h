// The trace of a turntable and its report, for tests of the simulator's output.
#pragma once

#include <string>
#include <vector>

#include "cache/simulate/simulation_report.h"

namespace sluice {

// A turntable: 24 clusters of a few chunks, the order turning round half way.
inline Trace turntable() {
  Trace trace;
  for (uint32_t frame = 0; frame < 12; ++frame) {
    for (uint32_t i = 0; i < 24; ++i) {
      const uint32_t cluster = frame < 6 ? i : 23 - i;
      for (uint32_t c = 0; c < 1 + cluster % 5; ++c) {
        TraceRecord r{cluster * 8 + c, 8 + (cluster * 7 + c * 5) % 40, cluster, frame, {}};
        r.bytes.moved = r.pages * trace.page_bytes;
        r.bytes.needed = r.bytes.moved / 2;
        r.bytes.extended = r.bytes.moved / 8;
        r.bytes.empty = r.bytes.moved / 4;
        trace.records.push_back(r);
      }
    }
  }
  return trace;
}

inline SimulationReport reportOf(const Trace& trace, uint64_t pages) {
  std::vector<PolicyKind> policies(onlinePolicies().begin(), onlinePolicies().end());
  policies.push_back(PolicyKind::kBelady);
  policies.push_back(PolicyKind::kBeladyPages);
  const PreparedTrace prepared = prepare(trace);
  const SimulationConfig chosen{PolicyKind::kLru, pages};
  return makeReport(prepared, "<turn & table>",
                    simulateTable(prepared, policies, defaultSizes(prepared, pages), chosen), true,
                    chosen);
}

}  // namespace sluice
