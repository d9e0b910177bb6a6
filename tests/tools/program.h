// Runs the program as a user does, with an index folder of its own.
#pragma once

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cstdlib>
#include <string>
#include <string_view>

#include "src/base/error.h"
#include "tests/support/run_command.h"
#include "tests/support/temp_folder.h"

namespace sluice {

class Program {
 public:
  // Covers the programs that the test itself starts, too: nothing goes into the user's cache
  // folder.
  Program() { setenv("XDG_CACHE_HOME", (folder / "cache").c_str(), 1); }

  // `arguments` is a line of sh. Indices go into the folder.
  CommandResult run(const std::string& arguments) const {
    return runCommand("cd " + shellQuoted(folder.path().string()) +
                      " && XDG_CACHE_HOME=\"$PWD/cache\" " SLUICE_PROGRAM " " + arguments);
  }
  // Another command of sh.
  CommandResult inFolder(const std::string& command) const {
    return runCommand("cd " + shellQuoted(folder.path().string()) + " && " + command);
  }
  // The same as run(), sent a signal ("INT") as soon as `until`, a test of sh, holds: a machine
  // under load may take long to get there. `$pid` is the program's. The status is 0 when it ended
  // before.
  CommandResult signalled(const std::string& arguments, const std::string& signal,
                          const std::string& until, const std::string& first = "") const {
    // sh has its background jobs ignore SIGINT.
    return runCommand(
        "cd " + shellQuoted(folder.path().string()) + " && export XDG_CACHE_HOME=\"$PWD/cache\"; " +
        first + "env --default-signal=INT " SLUICE_PROGRAM " " + arguments +
        " & pid=$!; while kill -0 $pid 2>/dev/null && ! { " + until +
        "; } 2>/dev/null; do sleep 0.01; done; kill -" + signal + " $pid 2>/dev/null; wait $pid");
  }
  // Requires: the command prints one JSON object, behind warnings if any.
  nlohmann::json json(const std::string& arguments) const {
    const CommandResult result = run(arguments + " --json");
    const size_t begin = std::min(result.output.find('{'), result.output.size());
    nlohmann::json parsed =
        nlohmann::json::parse(std::string_view(result.output).substr(begin), nullptr, false);
    if (result.status != 0 || parsed.is_discarded()) throw Error(result.output);
    return parsed;
  }
  bool exists(const std::string& name) const { return std::filesystem::exists(folder / name); }

  const TempFolder folder;
};

inline bool isOneLine(const std::string& text) {
  return !text.empty() && std::count(text.begin(), text.end(), '\n') == 1 && text.back() == '\n';
}

// A volume that every test can afford.
inline constexpr const char* kSmall = "synth:shells,dims=48x40x36";

}  // namespace sluice
