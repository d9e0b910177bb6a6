// Completions of the command line for shells, made of the text of --help. Each is a whole script
// that needs neither the program nor other completions when it runs.
#pragma once

#include <string>

#include "tools/manual/command_text.h"

namespace sluice {

std::string bashCompletion(const CommandText& program);
std::string zshCompletion(const CommandText& program);
std::string fishCompletion(const CommandText& program);

}  // namespace sluice
