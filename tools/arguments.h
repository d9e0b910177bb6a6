// What commands share of their arguments, with the defaults: what the library is asked for, and
// what is the program's alone.
#pragma once

#include <string>

#include "src/library/requests.h"

namespace sluice {

struct ResourceArguments : MachineOptions {
  std::string index_dir;  // of the indices of all volumes; empty: as tools/environment.h says
  bool quiet = false;     // no progress, no warnings
};

}  // namespace sluice
