#include "tools/pages/rows_section.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <set>
#include <string_view>

#include "tools/pages/html_page.h"
#include "tools/pages/run_page.h"

namespace sluice {
namespace {

using nlohmann::json;

constexpr size_t kMostBars = 60;
// Fields of reports that have a section of their own or tell how a run was made.
constexpr std::array<std::string_view, 16> kElsewhere = {
    "options",      "volume",         "look",
    "gl",           "levels",         "frames",
    "blocks",       "command",        "output",
    "version",      "device",         "transfer",
    "memory_bytes", "peak_rss_bytes", "peak_anonymous_bytes",
    "sluice"};

void collect(const json& value, const std::string& name, Leaves& out) {
  if (value.is_object()) {
    for (const auto& [key, part] : value.items())
      collect(part, name.empty() ? key : fmt::format("{}.{}", name, key), out);
  } else if (!value.is_array() && !value.is_null()) {
    out.emplace_back(name, value);
  }
}

// Names of columns in the order of their first row.
std::vector<std::string> columnsOf(const std::vector<Leaves>& rows) {
  std::vector<std::string> columns;
  std::set<std::string> seen;
  for (const Leaves& row : rows)
    for (const auto& [name, value] : row)
      if (seen.insert(name).second) columns.push_back(name);
  // The column that identifies the row comes first.
  std::stable_partition(columns.begin(), columns.end(), [&rows](const std::string& column) {
    for (const Leaves& row : rows)
      for (const auto& [name, value] : row)
        if (name == column) return value.is_string();
    return false;
  });
  return columns;
}

const json* find(const Leaves& row, const std::string& column) {
  const auto at = std::find_if(row.begin(), row.end(),
                               [&column](const auto& leaf) { return leaf.first == column; });
  return at == row.end() ? nullptr : &at->second;
}

bool isSpeed(const std::string& column) {
  return isRate(column) || column.ends_with("seconds") || column.starts_with("seconds.");
}

// A bar a row and column of speeds that share a unit.
std::string speedsOf(const std::vector<Leaves>& rows, const std::vector<std::string>& columns) {
  std::string out;
  for (const bool is_rate : {true, false}) {
    std::vector<Bar> bars;
    for (size_t i = 0; i < rows.size(); ++i) {
      int hue = 0;
      for (const std::string& column : columns) {
        if (!isSpeed(column)) continue;
        const json* value = find(rows[i], column);
        if (isRate(column) != is_rate || value == nullptr || !value->is_number()) continue;
        bars.push_back({rowLabel(rows[i], i) + " " + column,
                        readable(column, *value),
                        {{std::max(value->get<double>(), 0.0), hue++, column}}});
      }
    }
    // More bars tell nothing at a glance; the table has the numbers.
    if (!bars.empty() && bars.size() <= kMostBars)
      out += fmt::format("<h3>{}</h3>\n",
                         is_rate ? "Rates: longer is faster" : "Seconds: shorter is faster") +
             barsSvg(bars);
  }
  return out;
}

std::string tableOf(const std::string& name, const json& list) {
  std::vector<Leaves> rows;
  for (const json& row : list) rows.push_back(leavesOf(row));
  const std::vector<std::string> columns = columnsOf(rows);
  std::vector<HtmlRow> cells;
  for (const Leaves& row : rows) {
    HtmlRow line;
    for (const std::string& column : columns) {
      const json* value = find(row, column);
      line.push_back(value == nullptr ? "" : readable(column, *value));
    }
    cells.push_back(std::move(line));
  }
  return fmt::format("<h2>{}</h2>\n", escapeHtml(name)) + speedsOf(rows, columns) +
         htmlTable(columns, cells);
}

}  // namespace

Leaves leavesOf(const json& object) {
  Leaves out;
  collect(object, "", out);
  return out;
}

bool isTable(const json& value) {
  return value.is_array() && !value.empty() &&
         std::all_of(value.begin(), value.end(), [](const json& row) { return row.is_object(); });
}

std::string rowLabel(const Leaves& row, size_t number) {
  for (const auto& [name, value] : row)
    if (value.is_string()) {
      const auto text = value.get<std::string>();
      return text.substr(text.find_last_of('/') + 1);
    }
  return fmt::format("{}", number);
}

bool isRate(const std::string& name) {
  return name.starts_with("fps.") || name.find(".fps.") != std::string::npos ||
         name.ends_with("_per_second");
}

std::string rowsSection(const json& report) {
  std::string out;
  std::vector<std::array<std::string, 2>> facts;
  json plain = json::object();
  for (const auto& [name, part] : report.items()) {
    if (std::find(kElsewhere.begin(), kElsewhere.end(), name) != kElsewhere.end()) continue;
    if (isTable(part))
      out += tableOf(name, part);
    else
      plain[name] = part;
  }
  for (const auto& [name, value] : leavesOf(plain)) facts.push_back({name, readable(name, value)});
  return facts.empty() ? out : "<h2>Measured</h2>\n" + htmlFacts(facts) + out;
}

}  // namespace sluice
