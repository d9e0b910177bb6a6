// The texture-cache simulator for Python.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace sluice::python {

struct SimulationRequest {
  std::string trace;
  std::vector<std::string> policies;  // empty: all
  std::vector<uint64_t> sizes;        // pages; empty: powers of two up to the size that holds all
  std::optional<std::string> format;  // unset: by content and name
  uint64_t page_bytes = 4096;         // if the format does not tell
  bool pins = true;                   // the chunks of a cluster, if the trace has clusters
};

// The rows as JSON text, with the names of `sluice simulate --json`. Throws Error.
std::string simulatedRows(const SimulationRequest& request);

}  // namespace sluice::python
