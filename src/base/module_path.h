// Where the program's modules are: libraries of ours that are opened at run time, because what they
// bring is large (OpenVDB) or not the same everywhere (MPI).
#pragma once

#include <string>
#include <string_view>

namespace sluice {

// The absolute path of a module, in a place that was fixed when the program was built: one for the
// program in its build folder, one for those that are linked to the installed library, and one for
// the installed program. Nothing beside a program that was copied elsewhere, and nothing relative
// to any folder, is ever opened.
std::string modulePath(std::string_view file);

}  // namespace sluice
