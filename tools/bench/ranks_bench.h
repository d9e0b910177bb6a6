// sluice bench ranks: the gain from sharing a picture among ranks. Started by mpirun it measures
// that run's ranks; alone it has ranks of threads, each with a thread, a device and a budget of its
// own, and one process with one thread to compare with.
#pragma once

#include <nlohmann/json.hpp>

#include <vector>

#include "src/parallel/team.h"
#include "src/render/camera/frame_options.h"
#include "tools/options/arguments.h"

namespace sluice {

struct RanksBench {
  VolumeArguments volume;
  LookArguments look;
  FrameOptions frame;
  ResourceArguments resources;
  std::vector<int> ranks = {1, 2};  // alone
  int frames = 9;                   // measured, of a turn, after 2 warm ones
};

// `rows` [{`ranks`, `frame_seconds`{`median`,`min`,`max`}, `draw_seconds`, `exchange_seconds`,
// `compose_seconds`, `gather_seconds`, `part_bytes`, `sent_bytes`, `speedup`}]: medians of rank 0,
// speedup against the row of one. `team` is null for a single process. Throws Error. With several
// ranks, rank 0 gets the report.
nlohmann::json benchRanks(const RanksBench& bench, Team* team);
void printRanks(const nlohmann::json& report);

}  // namespace sluice
