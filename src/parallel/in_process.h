// Ranks that are threads of this process: for tests, and to measure what sharing out takes without
// MPI.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "src/parallel/team.h"

namespace sluice {

// A communicator for each rank; they end together.
std::vector<std::unique_ptr<Communicator>> inProcessRanks(int ranks);

// Runs `body` for each of so many ranks, each on a thread of its own; gives why it ended, one line
// a rank, empty where all is well. What `body` throws is a failure of that rank.
std::vector<std::string> runInProcess(int ranks, const std::function<void(Team& team)>& body,
                                      const StopToken& stop = {});

}  // namespace sluice
