// Ranks that a launcher has started: mpirun, mpiexec or srun, of Open MPI or of MPICH.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "src/parallel/communicator.h"

namespace sluice {

enum class MpiKind { kOpenMpi, kMpich };
const char* name(MpiKind kind);  // "Open MPI", "MPICH"

// What a launcher says to each process that it starts.
struct Launch {
  int rank = 0, ranks = 1;
  // Of the launcher; unset: it knows nothing of MPI (srun without a plugin for it), or there is
  // none.
  bool has_kind = false;
  MpiKind kind = MpiKind::kOpenMpi;
};
// From the variables of the environment, asked by name; null where one is not set. Of variables
// that make no sense nothing is said: one rank. Pure.
Launch launchOf(const std::function<const char*(const char* variable)>& environment);

// Meets the others. Throws Error: not built for this MPI, or the MPI does not begin.
std::unique_ptr<Communicator> joinRanks(const Launch& launch);

}  // namespace sluice
