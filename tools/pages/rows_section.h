// What benches measured, as tables and bars, whatever their columns are. Pure functions.
#pragma once

#include <nlohmann/json.hpp>

#include <string>
#include <utility>
#include <vector>

namespace sluice {

// Tables of the report's lists of objects, with bars of what they say of times and frame rates, and
// facts of its other numbers; empty where it has neither.
std::string rowsSection(const nlohmann::json& report);

// The leaves of an object that are numbers, text or truths, as names with dots and values, in the
// order of the JSON; lists are left out.
using Leaves = std::vector<std::pair<std::string, nlohmann::json>>;
Leaves leavesOf(const nlohmann::json& object);

// Whether a list, not empty, of objects.
bool isTable(const nlohmann::json& value);
// What a row is of: its first text, of a path the file's name; else its number.
std::string rowLabel(const Leaves& row, size_t number);
// Whether a name is one of rates (`fps.ess`, `samples_per_second`), of which more is better.
bool isRate(const std::string& name);

}  // namespace sluice
