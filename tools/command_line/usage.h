// What is wrong with the words of a command line, found before they are parsed: an unknown command
// or option is answered with the one that was probably meant, an option twice or without its value
// by its name.
#pragma once

#include <CLI/CLI.hpp>

#include <optional>
#include <string>
#include <vector>

namespace sluice {

// One line without its end; nullopt when every word has its place. Values are not looked at.
std::optional<std::string> wrongUsage(const CLI::App& program,
                                      const std::vector<std::string>& words);

}  // namespace sluice
