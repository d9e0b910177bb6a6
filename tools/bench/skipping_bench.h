// sluice bench skipping: Li's Table 1 for any set of volumes: frames a second of every block drawn
// whole with every sample lit and blended, as without any skipping (Basic), and of the visible
// growing boxes alone (ESS), whose rays go on over samples that show nothing.
#pragma once

#include <nlohmann/json.hpp>

#include "tools/bench/volumes_bench.h"

namespace sluice {

// {"rows": [...], "mean_speedup": ...}: one object a volume, with the names of the interface; in
// addition samples and boxes, whole blocks whose rays go on as well ("whole"), and object boxes
// (drawn by `--partition blocks`). The ways take turns frame by frame, so that a machine that
// drifts favours none. Throws Error.
nlohmann::json benchSkipping(const VolumesBench& bench);
void printSkipping(const nlohmann::json& report);

}  // namespace sluice
