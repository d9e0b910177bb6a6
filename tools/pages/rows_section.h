// Measurements of benches as tables and bars, whatever their columns are. Pure functions.
#pragma once

#include <nlohmann/json.hpp>

#include <string>
#include <utility>
#include <vector>

namespace sluice {

// Tables of the report's lists of objects, with bars for times and frame rates, and facts of its
// other numbers; empty if it has neither.
std::string rowsSection(const nlohmann::json& report);

// The leaves of an object that are numbers, text or truths, as names with dots and values, in the
// order of the JSON; lists are left out.
using Leaves = std::vector<std::pair<std::string, nlohmann::json>>;
Leaves leavesOf(const nlohmann::json& object);

// Whether a list, not empty, of objects.
bool isTable(const nlohmann::json& value);
// The label of a row: its first text (of a path, the file's name), or else its number.
std::string rowLabel(const Leaves& row, size_t number);
// Whether a name is a rate (`fps.ess`, `samples_per_second`), of which more is better.
bool isRate(const std::string& name);

}  // namespace sluice
