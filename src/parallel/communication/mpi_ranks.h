// Ranks that a launcher has started: mpirun, mpiexec or srun, of Open MPI or of MPICH.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "src/parallel/communication/communicator.h"

namespace sluice {

enum class MpiKind { kOpenMpi, kMpich };
const char* name(MpiKind kind);  // "Open MPI", "MPICH"

// The information that a launcher gives to each process that it starts.
struct Launch {
  int rank = 0, ranks = 1;
  // The launcher's MPI. Unset if it knows nothing of MPI (srun without a plugin for it), or if
  // there is no launcher.
  std::optional<MpiKind> kind = {};
};
// Reads environment variables by name; `environment` returns null for one that is not set.
// Malformed variables are ignored (treated as one rank). Pure.
Launch launchOf(const std::function<const char*(const char* variable)>& environment);

// Meets the others. Throws Error: not built for this MPI, or the MPI does not begin.
std::unique_ptr<Communicator> joinRanks(const Launch& launch);

// The ranks of a communicator of this program, which is linked to an MPI and has begun it: the
// number that MPI_Comm_c2f() gives. All of its ranks call. Throws Error: no MPI in this process, or
// none that sluice was built for.
std::unique_ptr<Communicator> shareRanks(int fortran_communicator);

}  // namespace sluice
