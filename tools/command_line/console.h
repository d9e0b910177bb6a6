// The one place that prints. Results go to standard output, where a failure is an Error: a script
// must not take half an answer for a whole one. Errors, warnings and progress go to standard error,
// where a failure has nobody left to tell and changes nothing.
#pragma once

#include <fmt/format.h>

#include <string>
#include <string_view>
#include <utility>

namespace sluice {

// Makes the three standard streams usable: one that was closed at the start is opened on
// /dev/null, standard output so that writing fails. Otherwise the next file opened would take its
// number. Called once, first.
void openStandardStreams();

// Text as it is. Throws Error when standard output takes no more.
void sayText(std::string_view text);

template <class... Values>
void say(fmt::format_string<Values...> format, Values&&... values) {
  sayText(fmt::format(format, std::forward<Values>(values)...));
}

// "sluice: LINE", in one line whatever it holds. Control characters become spaces.
void printError(std::string line);
// "sluice: warning: LINE"
void printWarning(const std::string& line);

// Everything printed has arrived. Throws Error otherwise (a full device, a closed stream).
void finishOutput();

}  // namespace sluice
