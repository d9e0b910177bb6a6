// The commands of the parser, and what it says of words.
#pragma once

#include <CLI/CLI.hpp>

#include <set>
#include <string>
#include <vector>

#include "tools/command_line/usage.h"
#include "tools/program.h"

namespace sluice {

struct Place {
  const CLI::App* app;
  std::vector<std::string> words;  // words that lead there: "bench", "render"
};

inline void collect(const CLI::App& app, const std::vector<std::string>& words,
                    std::vector<Place>& places) {
  const auto commands = app.get_subcommands([](const CLI::App*) { return true; });
  if (commands.empty()) places.push_back({&app, words});
  for (const CLI::App* command : commands) {
    std::vector<std::string> longer = words;
    longer.push_back(command->get_name());
    collect(*command, longer, places);
  }
}

inline std::vector<Place> commandsOf(const CommandLine& line) {
  std::vector<Place> places;
  collect(*line.program, {}, places);
  return places;
}

// The program's complaint about these words; empty: they are accepted. Missing arguments do not
// count.
inline std::string complaint(const CommandLine& line, const std::vector<std::string>& words) {
  if (const auto wrong = wrongUsage(*line.program, words)) return *wrong;
  try {
    line.program->parse(std::vector<std::string>(words.rbegin(), words.rend()));
  } catch (const CLI::RequiredError&) {
  } catch (const CLI::RequiresError&) {
  } catch (const CLI::ParseError& error) {
    return error.what();
  }
  return "";
}
inline std::string complaint(const std::vector<std::string>& words) {
  return complaint(makeCommandLine(), words);
}

// Whether the command takes the option only to say that it ignores it (takeIdleOptions()).
inline bool isIdle(const CLI::App& command, const CLI::Option& option) {
  const std::set<std::string> some{"info", "prepare", "packing", "view"};
  return option.get_group().empty() && some.contains(command.get_name());
}

}  // namespace sluice
