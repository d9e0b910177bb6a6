// Ranks: a command that several processes run together, started by mpirun, mpiexec or srun.
//
// Rank 0 alone prints and writes. When a rank fails all end, and rank 0 says in one line which and
// why; one that a signal kills is the launcher's to say, which ends the others.
#pragma once

#include <nlohmann/json.hpp>

#include <functional>

#include "src/parallel/mpi_ranks.h"
#include "src/parallel/rank_share.h"
#include "src/parallel/team.h"
#include "tools/arguments.h"

namespace sluice {

// What the environment says of this process; standard output of all but rank 0 leads nowhere from
// now on. Called once, first.
Launch beginRanks();

// Runs `body` as the rank that this process is; null where it is alone. Gives the exit status.
// Throws Error: not of this rank alone, or of ranks that cannot meet; Interrupted.
int onRanks(const std::function<int(Team* team)>& body);

// For a command line that this rank refuses: tells the other ranks, so that none of them waits for
// this one, and rank 0 prints the line. Gives the exit status: `status` if all ranks refuse theirs
// for this reason. Throws nothing.
int refuseTogether(const Launch& launch, const std::string& line, int status);

// What one rank takes of this machine where the user does not say: a fair share of memory and
// processors among the ranks on it. All but rank 0 are quiet.
void shareMachine(Team& team, ResourceArguments& resources);

// One rank's part of a report, and what they are together: sums of blocks, samples and bytes.
nlohmann::json rankJson(const nlohmann::json& report, const RankShare& share);
// `report` is rank 0's of a scene; puts sums in its frames and `ranks`. All call; gives rank 0's.
void gatherReport(Team& team, const RankShare& share, nlohmann::json& report);

}  // namespace sluice
