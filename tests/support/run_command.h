// Other people's programs (nifti_tool, vdb_print, python3), and our own, from a test.
#pragma once

#include <string>
#include <string_view>

namespace sluice {

struct CommandResult {
  int status = 0;      // the exit status; 128 + n when signal n ended it
  std::string output;  // standard output and standard error together
};

// Runs a line of sh. Throws Error when no process can be started.
CommandResult runCommand(const std::string& line);

// Whether a program of this name is on the PATH; a test that needs it skips by name otherwise.
bool haveProgram(std::string_view name);

// The text in single quotes, safe as one word of runCommand's line.
std::string shellQuoted(std::string_view text);

}  // namespace sluice
