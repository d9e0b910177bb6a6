// Ranks that are threads of this process: for tests, and to measure the cost of sharing without
// MPI.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "src/parallel/communication/team.h"

namespace sluice {

// A communicator for each rank; they end together.
std::vector<std::unique_ptr<Communicator>> inProcessRanks(int ranks);

// Runs `body` for each of `ranks` ranks, each on a thread of its own. Returns the reasons why ranks
// failed, one line a rank; empty if none did. An exception from `body` is a failure of that rank.
std::vector<std::string> runInProcess(int ranks, const std::function<void(Team& team)>& body,
                                      const StopToken& stop = {});

}  // namespace sluice
