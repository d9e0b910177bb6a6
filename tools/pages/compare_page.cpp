#include "tools/pages/compare_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>
#include <set>
#include <string_view>

#include "tools/pages/html_page.h"
#include "tools/pages/rows_section.h"
#include "tools/pages/run_page.h"

namespace sluice {
namespace {

using nlohmann::json;

// These members say what was asked for. Their numbers are no measurements.
constexpr std::array<std::string_view, 5> kMadeBy = {"options", "volume", "look", "gl", "version"};
// More bars than this are no help to the eye; the table below has all numbers.
constexpr size_t kMostSpeeds = 40;

Leaves measuredOf(const json& report) {
  Leaves out;
  const auto append = [&out](const std::string& prefix, const json& object) {
    for (auto& [name, value] : leavesOf(object))
      if (value.is_number()) out.emplace_back(prefix + name, value);
  };
  for (const auto& [name, part] : report.items()) {
    if (std::find(kMadeBy.begin(), kMadeBy.end(), name) != kMadeBy.end()) continue;
    if (isTable(part))
      for (size_t i = 0; i < part.size(); ++i)
        append(fmt::format("{}.{}.", name, rowLabel(leavesOf(part[i]), i)), part[i]);
    else if (part.is_object())
      append(name + ".", part);
    else if (part.is_number())
      out.emplace_back(name, part);
  }
  return out;
}

// The options that differ between the runs.
std::string optionsSection(std::span<const NamedReport> runs) {
  std::map<std::string, std::vector<std::string>> options;
  for (size_t run = 0; run < runs.size(); ++run) {
    const json asked = runs[run].report.value("options", json::object());
    for (const auto& [name, value] : asked.items()) {
      auto& values = options[name];
      values.resize(runs.size());
      values[run] = value.is_string() ? value.get<std::string>() : value.dump();
    }
  }
  std::vector<HtmlRow> rows;
  for (const auto& [name, values] : options) {
    // An option that all runs share explains no difference between them.
    if (std::set<std::string>(values.begin(), values.end()).size() == 1) continue;
    HtmlRow row{name};
    row.insert(row.end(), values.begin(), values.end());
    rows.push_back(std::move(row));
  }
  if (rows.empty()) return "<p>All were asked for the same.</p>\n";
  HtmlRow heads{"option"};
  for (const NamedReport& run : runs) heads.push_back(run.name);
  return "<h2>Asked differently</h2>\n" + htmlTable(heads, rows);
}

bool isSpeedName(const std::string& name) {
  return isRate(name) || name.ends_with("seconds") || name.find("seconds.") != std::string::npos;
}

// Times and rates that all runs have, a group of bars each: scales differ from one to the next.
std::string speedsSection(std::span<const NamedReport> runs,
                          std::span<const ComparedNumber> numbers) {
  std::string out;
  size_t shown = 0;
  for (const ComparedNumber& number : numbers) {
    const bool everywhere = std::all_of(number.values.begin(), number.values.end(),
                                        [](const json& value) { return !value.is_null(); });
    if (!everywhere || !isSpeedName(number.name) || shown == kMostSpeeds) continue;
    ++shown;
    std::vector<Bar> bars;
    for (size_t run = 0; run < runs.size(); ++run)
      bars.push_back({runs[run].name,
                      readable(number.name, number.values[run]) + "  " + ratioText(number, run),
                      {{std::max(number.values[run].get<double>(), 0.0), static_cast<int>(run),
                        runs[run].name}}});
    out += fmt::format("<h3>{}{}</h3>\n", escapeHtml(number.name),
                       isRate(number.name) ? ": longer is faster" : "") +
           barsSvg(bars);
  }
  return out.empty() ? "" : "<h2>Times and rates</h2>\n" + out;
}

}  // namespace

std::vector<ComparedNumber> compared(std::span<const NamedReport> runs) {
  std::vector<ComparedNumber> numbers;
  std::map<std::string, size_t> places;
  for (size_t run = 0; run < runs.size(); ++run)
    for (auto& [name, value] : measuredOf(runs[run].report)) {
      // Rows keep the order in which the first run that has them tells them.
      const auto [place, is_new] = places.try_emplace(name, numbers.size());
      if (is_new) numbers.push_back({name, std::vector<json>(runs.size())});
      numbers[place->second].values[run] = value;
    }
  return numbers;
}

std::string ratioText(const ComparedNumber& number, size_t run) {
  const json &first = number.values.front(), &value = number.values[run];
  if (run == 0 || !first.is_number() || !value.is_number() || first.get<double>() == 0) return "";
  return fmt::format("x {:.3g}", value.get<double>() / first.get<double>());
}

std::string comparePage(std::span<const NamedReport> runs) {
  const std::vector<ComparedNumber> numbers = compared(runs);
  HtmlRow heads{"number"};
  for (size_t run = 0; run < runs.size(); ++run) {
    heads.push_back(runs[run].name);
    if (run > 0) heads.push_back("of the first");
  }
  std::vector<HtmlRow> rows;
  for (const ComparedNumber& number : numbers) {
    HtmlRow row{number.name};
    for (size_t run = 0; run < runs.size(); ++run) {
      const json& value = number.values[run];
      row.push_back(value.is_null() ? "" : readable(number.name, value));
      if (run > 0) row.push_back(ratioText(number, run));
    }
    rows.push_back(std::move(row));
  }
  std::string title = "sluice";
  for (const NamedReport& run : runs)
    title += (&run == runs.data() ? ": " : " against ") + run.name;
  return htmlPage(title, "",
                  optionsSection(runs) + speedsSection(runs, numbers) + "<h2>All numbers</h2>\n" +
                      htmlTable(heads, rows));
}

}  // namespace sluice
