// Finds mistakes in a command line before it is parsed. The message for an unknown command or
// option suggests the one that was probably meant; the message for an option given twice or without
// its value names the option.
#pragma once

#include <CLI/CLI.hpp>

#include <fmt/format.h>

#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace sluice {

// Throws the error of options that do not go together, which only a command itself can find. It
// ends the program with the status of wrong usage.
template <class... Args>
[[noreturn]] void failUsage(fmt::format_string<Args...> text, Args&&... args) {
  throw CLI::ValidationError(fmt::format(text, std::forward<Args>(args)...));
}

// The message, one line without its end; nullopt if every word is in place. Values are not checked.
std::optional<std::string> wrongUsage(const CLI::App& program,
                                      const std::vector<std::string>& words);

}  // namespace sluice
