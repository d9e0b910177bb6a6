// Manual pages in the language of man(7), made of the text of --help.
#pragma once

#include <string>

#include "tools/manual/command_text.h"

namespace sluice {

// "sluice-bench-render.1"
std::string manualPageName(const CommandText& command);

// The page of a command of `program`, which may be the program itself.
std::string manualPage(const CommandText& command, const CommandText& program);

}  // namespace sluice
