#include "src/parallel/mpi_ranks.h"

#include <array>
#include <charconv>
#include <string_view>

#include "src/base/error.h"
#include "src/base/files/program_module.h"
#include "src/parallel/mpi_module.h"

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

std::string moduleFor(MpiKind kind) {
  return kind == MpiKind::kOpenMpi ? "sluice_openmpi.so" : "sluice_mpich.so";
}

}  // namespace

const char* name(MpiKind kind) {
  return kind == MpiKind::kOpenMpi ? "Open MPI" : "MPICH";
}

Launch launchOf(const std::function<const char*(const char* variable)>& environment) {
  for (const Launcher& launcher : kLaunchers) {
    const int rank = numberIn(environment(launcher.rank));
    const int ranks = numberIn(environment(launcher.ranks));
    if (rank >= 0 && ranks > 1 && rank < ranks) return {rank, ranks, true, launcher.kind};
  }
  const int rank = numberIn(environment("SLURM_PROCID"));
  const int ranks = numberIn(environment("SLURM_STEP_NUM_TASKS"));
  if (rank >= 0 && ranks > 1 && rank < ranks) return {rank, ranks, false, MpiKind::kOpenMpi};
  return {};
}

std::unique_ptr<Communicator> joinRanks(const Launch& launch) {
  if (!launch.has_kind)
    fail(
        "started {} times by srun without MPI, so that the ranks cannot meet; give srun --mpi=pmix "
        "or --mpi=pmi2, or use mpirun",
        launch.ranks);
  std::unique_ptr<Communicator> ranks;
  try {
    const std::string hint = fmt::format(
        "sluice's module for {}; install the package sluice-mpi, build sluice on a machine with "
        "{}, "
        "or start it without a launcher",
        name(launch.kind), launch.kind == MpiKind::kOpenMpi ? "libopenmpi-dev" : "libmpich-dev");
    openModule({moduleFor(launch.kind), hint, kMpiModuleVersionOf, kMpiModuleVersion})
        .get<JoinMpi*>(kJoinMpi)(ranks);
  } catch (const Error& error) {
    fail("started as {} ranks of {}, which do not meet: {}", launch.ranks, name(launch.kind),
         error.what());
  }
  SLUICE_CHECK_EQ(ranks->ranks(), launch.ranks);
  return ranks;
}

}  // namespace sluice
