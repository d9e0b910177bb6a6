// Rows as csv and json; the names are those that scripts rely on.
#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "cache/simulate/simulator.h"

namespace sluice {
namespace {

nlohmann::json jsonOf(const auto& value) {
  return value;
}
nlohmann::json jsonOf(const std::optional<uint64_t>& value) {
  return value ? nlohmann::json(*value) : nlohmann::json();
}

// Empty if there is no value.
template <class Value>
std::string textOf(const Value& value) {
  return fmt::format("{}", value);
}
std::string textOf(const std::optional<uint64_t>& value) {
  return value ? fmt::format("{}", *value) : std::string();
}

template <class Visit>
void visitFields(const SimulationRow& r, Visit&& visit) {
  visit("pages", r.pages);
  visit("requests", r.requests);
  visit("hits", r.hits);
  visit("misses", r.misses);
  visit("compulsory", r.compulsory);
  visit("capacity", r.capacity);
  visit("conflict", r.conflict);
  visit("bytes_moved", r.bytes.moved);
  visit("bytes_needed", r.bytes.needed);
  visit("bytes_rounding", r.bytes.rounding());
  visit("bytes_extended", r.bytes.extended);
  visit("bytes_empty", r.bytes.empty);
  visit("chunk_requests", r.chunks.requests);
  visit("chunk_misses", r.chunks.misses);
  visit("loads", r.chunks.loads);
  visit("redundant_loads", r.chunks.redundant_loads);
  visit("evictions", r.chunks.evictions);
  visit("failures", r.failures);
  visit("bytes_failed", r.failed_bytes);
  visit("pages_loaded", r.pages_loaded);
  visit("modelled_seconds", r.modelled_seconds);
  visit("planned_pages", r.planned_pages);
  visit("miss_ratio", r.missRatio());
}

// A field of a csv file (RFC 4180).
std::string quoted(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string out = "\"";
  for (const char c : text) out += c == '"' ? std::string("\"\"") : std::string(1, c);
  return out + '"';
}

// The labels that tell runs apart, as far as some row has them.
using Label = std::pair<const char*, std::string SimulationRow::*>;
std::vector<Label> labelsOf(std::span<const SimulationRow> rows) {
  std::vector<Label> labels;
  for (const Label& label :
       {Label{"trace", &SimulationRow::trace}, Label{"page", &SimulationRow::page},
        Label{"channel", &SimulationRow::channel}})
    if (std::any_of(rows.begin(), rows.end(),
                    [&](const SimulationRow& row) { return !(row.*label.second).empty(); }))
      labels.push_back(label);
  return labels;
}

}  // namespace

std::string toCsv(std::span<const SimulationRow> rows) {
  std::string out = "policy";
  visitFields(SimulationRow{},
              [&](const char* field, const auto&) { out += fmt::format(",{}", field); });
  const std::vector<Label> labels = labelsOf(rows);
  for (const Label& label : labels) out += fmt::format(",{}", label.first);
  out += '\n';
  for (const SimulationRow& row : rows) {
    out += name(row.policy);
    visitFields(row, [&](const char*, const auto& value) { out += ',' + textOf(value); });
    for (const Label& label : labels) out += ',' + quoted(row.*label.second);
    out += '\n';
  }
  return out;
}

nlohmann::json rowsJson(std::span<const SimulationRow> rows) {
  nlohmann::json all = nlohmann::json::array();
  for (const SimulationRow& row : rows) {
    nlohmann::json& object = all.emplace_back();
    object["policy"] = name(row.policy);
    visitFields(row, [&](const char* field, const auto& value) { object[field] = jsonOf(value); });
  }
  return all;
}

}  // namespace sluice
