// Finds mistakes in a command line before it is parsed. The message for an unknown command or
// option suggests the one that was probably meant; the message for an option given twice or without
// its value names the option.
#pragma once

#include <CLI/CLI.hpp>

#include <optional>
#include <string>
#include <vector>

namespace sluice {

// The message, one line without its end; nullopt if every word is in place. Values are not checked.
std::optional<std::string> wrongUsage(const CLI::App& program,
                                      const std::vector<std::string>& words);

}  // namespace sluice
