// Finds the program's modules: libraries of ours that are opened at run time, because what they
// bring is large (OpenVDB) or differs from machine to machine (MPI).
#pragma once

#include <string>
#include <string_view>

namespace sluice {

// The absolute path of a module. Programs that are linked to the installed library and the
// installed program have it in a place that was fixed when they were built. A program in its build
// folder, or in one that was moved, has it in its own folder, the folder of the program's file as
// the kernel names it, if nobody but the owner of that file can write to the folder or the module.
// Nothing relative to the current folder is ever opened.
std::string modulePath(std::string_view file);

}  // namespace sluice
