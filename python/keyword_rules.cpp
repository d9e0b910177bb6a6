#include "python/keyword_rules.h"

#include <fmt/format.h>

#include <algorithm>

#include "src/base/field_names.h"
#include "src/options/option_rules.h"
#include "src/options/option_table.h"

namespace sluice::python {
namespace {

std::string valueOf(std::string_view word) {
  if (word == "on") return "True";
  return word == "off" ? "False" : fmt::format("'{}'", word);
}

std::string keywordIn(std::string_view option) {
  for (const OptionEntry& entry : optionTable())
    for (size_t i = 0; i < entry.kind.flags.size(); ++i)
      if (entry.kind.flags[i] == option)
        return keywordOf(entry) + "=" + valueOf(entry.kind.words[i]);
  return keywordOf(option);
}

// The frame of Python that called the package, as a level of the stack: its line is shown with a
// warning.
int callersLevel() {
  const auto isOurs = [](const py::object& frame) {
    const auto name = py::str(frame.attr("f_globals").attr("get")("__name__")).cast<std::string>();
    return name == "sluice" || name.starts_with("sluice.");
  };
  py::object frame = py::module_::import("sys").attr("_getframe")();
  int level = 1;
  for (; !frame.is_none() && isOurs(frame); frame = frame.attr("f_back")) ++level;
  return level;
}

// The option of the command line that the keyword's value stands for; nullopt: it asks for none.
std::optional<std::string> optionOf(const std::string& keyword, const py::handle& value) {
  if (value.is_none() || value.is(py::bool_(false))) return std::nullopt;
  for (const OptionEntry& entry : optionTable()) {
    if (keywordOf(entry) != keyword || entry.kind.flags.empty()) continue;
    for (size_t i = 0; i < entry.kind.flags.size(); ++i)
      if (value.is(py::bool_(true)) ? entry.kind.words[i] == "on"
                                    : value.equal(py::str(std::string(entry.kind.words[i]))))
        return entry.kind.flags[i].empty() ? std::nullopt
                                           : std::optional(std::string(entry.kind.flags[i]));
    return std::nullopt;
  }
  std::string option = "--" + keyword;
  std::replace(option.begin(), option.end(), '_', '-');
  return option;
}

}  // namespace

std::string inKeywords(std::string_view text) {
  return renamed(std::string(text), keywordIn);
}

void warn(const std::vector<std::string>& lines) {
  for (const std::string& line : lines)
    if (PyErr_WarnEx(PyExc_UserWarning, inKeywords(line).c_str(), callersLevel()) != 0)
      throw py::error_already_set();
}

std::set<std::string> givenOptions(const py::dict& keywords) {
  std::set<std::string> given;
  for (const auto& [keyword, value] : keywords)
    if (const auto option = optionOf(keyword.cast<std::string>(), value)) given.insert(*option);
  return given;
}

void requirePairs(const py::kwargs& keywords) {
  const auto given = [&](const std::string& keyword) {
    if (!keywords.contains(keyword.c_str())) return false;
    const py::object value = keywords[keyword.c_str()];
    return !value.is_none() && !value.is(py::bool_(false));
  };
  for (const auto& pair : optionsApart()) {
    const std::string one = keywordOf(pair.one), other = keywordOf(pair.other);
    if (given(one) && given(other))
      throw py::type_error(fmt::format("{} and {} do not go together", one, other));
  }
  for (const auto& pair : optionNeeds()) {
    const std::string one = keywordOf(pair.one), needed = keywordOf(pair.other);
    if (given(one) && !given(needed))
      throw py::type_error(fmt::format("{} requires {}", one, needed));
  }
}

void requireNoConflict(const ViewState& state) {
  if (const auto conflict = conflictIn(state)) throw py::type_error(inKeywords(*conflict));
}

}  // namespace sluice::python
