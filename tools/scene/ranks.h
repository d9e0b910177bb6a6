// Ranks: a command that several processes run together, started by mpirun, mpiexec or srun.
//
// Rank 0 alone prints and writes. When a rank fails all end, and rank 0 names it and the reason in
// one line; if a signal kills a rank, the launcher reports it and ends the others.
#pragma once

#include <nlohmann/json.hpp>

#include <functional>

#include "src/parallel/communication/mpi_ranks.h"
#include "src/parallel/communication/team.h"
#include "src/parallel/compositing.h"
#include "tools/options/arguments.h"

namespace sluice {

// Reads the environment of this process. Standard output of all ranks but 0 is discarded from now
// on. To be called once, first.
Launch beginRanks();

// Runs `body` as the rank that this process is; null if it is alone. Gives the exit status. Throws
// Error: not of this rank alone, or of ranks that cannot meet; Interrupted.
int onRanks(const std::function<int(Team* team)>& body);

// Handles a command line that this rank refuses: tells the other ranks, so that none of them waits
// for this one, and rank 0 prints the line. Gives the exit status: `status` if all ranks refuse
// theirs for this reason. Throws nothing.
int refuseTogether(const Launch& launch, const std::string& line, int status);

// Limits a rank to a fair share of the machine's memory and processors among the ranks on it,
// unless the user sets these. All but rank 0 are quiet.
void shareMachine(Team& team, ResourceArguments& resources);

// A rank's part of a report, and the ranks' sums of blocks, samples and bytes.
nlohmann::json rankJson(const nlohmann::json& report, const CompositingReport& parts);
// `report` is rank 0's of a scene; puts sums in its frames and `ranks`. All call; gives rank 0's.
void gatherReport(Team& team, const CompositingReport& parts, nlohmann::json& report);

}  // namespace sluice
