// The program: all commands on one command line, and the exit status.
#pragma once

#include <CLI/CLI.hpp>

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "tools/commands/commands.h"

namespace sluice {

struct CommandLine {
  std::unique_ptr<CLI::App> program;
  std::vector<std::pair<const CLI::App*, Command>> commands;
};
// Every command with its options.
CommandLine makeCommandLine();

// Runs `words` (without the program's name): prints results on standard output, and errors as one
// line on standard error. Throws nothing.
int runProgram(const std::vector<std::string>& words);

}  // namespace sluice
