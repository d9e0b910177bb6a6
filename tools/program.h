// The program: all commands on one command line, and the exit status.
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "tools/commands/commands.h"

namespace sluice {

struct CommandLine {
  std::unique_ptr<CLI::App> program;
  std::vector<std::pair<const CLI::App*, Command>> commands;
};
// The command that is called `only`, with its options; if none is, all commands. To make all takes
// longer than starting the program.
CommandLine makeCommandLine(std::string_view only = {});

// Runs `words` (without the program's name): prints results on standard output, and errors as one
// line on standard error. Throws nothing.
int runProgram(const std::vector<std::string>& words);

}  // namespace sluice
