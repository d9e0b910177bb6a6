#include "python/keyword_rules.h"

#include <fmt/format.h>

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

}  // namespace

std::string inKeywords(std::string_view text) {
  return renamed(std::string(text), keywordIn);
}

void warn(const std::vector<std::string>& lines) {
  constexpr int kCallerOfThePackage = 2;
  for (const std::string& line : lines)
    if (PyErr_WarnEx(PyExc_UserWarning, inKeywords(line).c_str(), kCallerOfThePackage) != 0)
      throw py::error_already_set();
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
