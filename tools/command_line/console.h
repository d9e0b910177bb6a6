// The one place that prints. Results go to standard output, and a failure to write them is an
// Error: a script must not take half an answer for a whole one. Errors, warnings and progress go to
// standard error; a failure to write them is ignored, since nobody is left to tell.
#pragma once

#include <fmt/format.h>
#include <nlohmann/json_fwd.hpp>

#include <string>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <vector>

#include "src/base/files/shell_word.h"

namespace sluice {

// Makes the three standard streams usable: one that was closed at the start is opened on
// /dev/null, standard output so that writing fails. Otherwise the next file opened would take its
// number. Called once, first.
void openStandardStreams();

// Text of ours, lines and all; control characters other than newlines and tabs become escapes.
// Throws Error when standard output takes no more.
void sayText(std::string_view text);
// Prints a report as JSON on several lines.
void sayJson(const nlohmann::json& report);

// A value as say() prints it: file names and other texts may come from anywhere, and must not begin
// a line of their own or reach the terminal as a command to it.
template <class Value>
auto shownValue(const Value& value) {
  if constexpr (std::is_convertible_v<const Value&, std::string_view>)
    return shownName(value);
  else
    return value;
}

// Lines of ours around values; a text that has control characters is printed as $'...' (shownName).
template <class... Values>
void say(fmt::format_string<Values...> format, Values&&... values) {
  const std::tuple<decltype(shownValue(values))...> shown{shownValue(values)...};
  sayText(std::apply(
      [&](const auto&... each) {
        return fmt::vformat(fmt::string_view(format), fmt::make_format_args(each...));
      },
      shown));
}

// "sluice: LINE", in one line whatever it holds: control characters become escapes such as \n.
void printError(std::string line);
// "sluice: warning: LINE"
void printWarning(const std::string& line);
// The same of the lines that were not `said` yet, to which they are added.
void printNewWarnings(const std::vector<std::string>& lines, std::vector<std::string>& said);
// "sluice: LINE", of something that is as it should be.
void printNotice(const std::string& line);

// Everything printed has arrived. Throws Error otherwise (a full device, a closed stream).
void finishOutput();

}  // namespace sluice
