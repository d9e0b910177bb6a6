#include "src/parallel/communication/mpi_ranks.h"

#include <dlfcn.h>

#include <array>
#include <charconv>
#include <string_view>

#include "src/base/error.h"
#include "src/base/files/program_module.h"
#include "src/parallel/communication/mpi_module.h"

namespace sluice {
namespace {

constexpr int kMostRanks = 1 << 20;

struct Launcher {
  const char* rank;
  const char* ranks;
  MpiKind kind;
};
// Open MPI's own; MPICH's (and those of its kin, and of srun with pmi2); srun's with pmix, for Open
// MPI.
constexpr std::array<Launcher, 3> kLaunchers = {
    {{"OMPI_COMM_WORLD_RANK", "OMPI_COMM_WORLD_SIZE", MpiKind::kOpenMpi},
     {"PMI_RANK", "PMI_SIZE", MpiKind::kMpich},
     {"PMIX_RANK", "SLURM_STEP_NUM_TASKS", MpiKind::kOpenMpi}}};

// -1 if it is no number.
int numberIn(const char* text) {
  if (text == nullptr) return -1;
  const std::string_view digits(text);
  int number = -1;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), number);
  if (error != std::errc() || end != digits.data() + digits.size()) return -1;
  return number > kMostRanks ? -1 : number;
}

SharedLibrary moduleFor(MpiKind kind) {
  const bool is_open = kind == MpiKind::kOpenMpi;
  const std::string hint = fmt::format(
      "sluice's module for {}; install the package sluice-mpi, build sluice on a machine with {}, "
      "or start it without a launcher",
      name(kind), is_open ? "libopenmpi-dev" : "libmpich-dev");
  return openModule({is_open ? "sluice_openmpi.so" : "sluice_mpich.so", hint, kMpiModuleVersionOf,
                     kMpiModuleVersion});
}

// The MPI that this program is linked to, by what it says of itself.
MpiKind kindInProcess() {
  using VersionOf = int(char* text, int* length);
  auto* const version_of =
      reinterpret_cast<VersionOf*>(dlsym(RTLD_DEFAULT, "MPI_Get_library_version"));
  if (version_of == nullptr)
    failSystem(
        "expected a program that is linked to MPI, found none; ranks share a communicator of it");
  constexpr size_t kMostText = 8192;  // MPICH's limit, which is the larger one
  std::string text(kMostText, '\0');
  int length = 0;
  version_of(text.data(), &length);
  return text.starts_with("Open MPI") ? MpiKind::kOpenMpi : MpiKind::kMpich;
}

}  // namespace

const char* name(MpiKind kind) {
  return kind == MpiKind::kOpenMpi ? "Open MPI" : "MPICH";
}

Launch launchOf(const std::function<const char*(const char* variable)>& environment) {
  for (const Launcher& launcher : kLaunchers) {
    const int rank = numberIn(environment(launcher.rank));
    const int ranks = numberIn(environment(launcher.ranks));
    // A launcher may have started a single process, which draws alone and needs no MPI.
    if (rank >= 0 && ranks > 1 && rank < ranks) return {rank, ranks, launcher.kind};
  }
  // The launcher srun sets these even if it was told of no MPI: processes that cannot meet would
  // each draw the whole picture.
  const int rank = numberIn(environment("SLURM_PROCID"));
  const int ranks = numberIn(environment("SLURM_STEP_NUM_TASKS"));
  if (rank >= 0 && ranks > 1 && rank < ranks) return {rank, ranks};
  return {};
}

std::unique_ptr<Communicator> joinRanks(const Launch& launch) {
  if (!launch.kind)
    failSystem(
        "started {} times by srun without MPI, so that the ranks cannot meet; give srun --mpi=pmix "
        "or --mpi=pmi2, or use mpirun",
        launch.ranks);
  std::unique_ptr<Communicator> ranks;
  // The module's own error does not tell that the program was started as ranks.
  try {
    moduleFor(*launch.kind).get<JoinMpi*>(kJoinMpi)(ranks);
  } catch (const Error& error) {
    failAs(error.kind(), "started as {} ranks of {}, which do not meet: {}", launch.ranks,
           name(*launch.kind), error.what());
  }
  SLUICE_CHECK_EQ(ranks->ranks(), launch.ranks);
  return ranks;
}

std::unique_ptr<Communicator> shareRanks(int fortran_communicator) {
  std::unique_ptr<Communicator> ranks;
  moduleFor(kindInProcess()).get<ShareMpi*>(kShareMpi)(fortran_communicator, ranks);
  return ranks;
}

}  // namespace sluice
