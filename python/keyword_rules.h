// Names of keywords, and which keywords do not go together: the rules of the command line
// (src/options/option_rules.h) in the words of Python.
#pragma once

#include <pybind11/pybind11.h>

#include <algorithm>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "src/options/view_state.h"

namespace sluice::python {

namespace py = pybind11;

inline std::string keywordOf(std::string_view option) {
  std::string keyword(option.substr(option.find_first_not_of('-')));
  std::replace(keyword.begin(), keyword.end(), '-', '_');
  return keyword;
}
// This takes an entry of the table of options.
inline std::string keywordOf(const auto& entry) {
  return keywordOf(entry.option.empty() ? entry.key : entry.option);
}

// The text with keywords for the options that it names, a flag with the value that it stands for:
// "shade=False".
std::string inKeywords(std::string_view text);

// Gives each line to Python's warnings, with keywords for the options that it names and the line of
// the package's caller. Throws what their filter makes of them. Requires: the interpreter's lock is
// held.
void warn(const std::vector<std::string>& lines);

// The options of the command line that the keywords stand for: "--fov" for fov=50, and none for
// None and False.
std::set<std::string> givenOptions(const py::dict& keywords);

// Throws TypeError for two keywords that exclude each other, or one without another that it needs.
void requirePairs(const py::kwargs& keywords);

// Throws TypeError for a value that has no effect beside the others.
void requireNoConflict(const ViewState& state);

}  // namespace sluice::python
