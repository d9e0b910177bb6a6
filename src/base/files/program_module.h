// The program's modules: libraries of ours that are opened at run time, because what they bring is
// large (OpenVDB) or differs from machine to machine (MPI).
//
// A module is looked for beside the file that this code runs from (the program, or Python's
// extension module), and in PREFIX/lib/sluice for a program in PREFIX/bin. A build folder and an
// installed prefix may therefore lie anywhere, and may be moved. Nothing relative to the current
// folder is ever opened.
#pragma once

#include <string>
#include <string_view>

#include "src/base/files/shared_library.h"

namespace sluice {

struct ProgramModule {
  std::string file;              // "sluice_web.so"
  std::string hint;              // what it is for and what to install, for the message
  const char* version_function;  // its function, of the type const char*(), that gives its version
  std::string_view version;      // the expected one
};

// Opens the module. Throws Error if there is none, if it belongs to another version, or if it lies
// where somebody could have put it who could not have replaced the program itself.
SharedLibrary openModule(const ProgramModule& module);

}  // namespace sluice
