// sluice bench algorithms: Tong's Table 1 for any set of volumes, and the bytes that the texture
// cache moved.
#pragma once

#include <nlohmann/json.hpp>

#include "tools/bench/volumes_bench.h"

namespace sluice {

// {"rows": [...]}: one object a volume, the names of the interface. Throws Error.
nlohmann::json benchAlgorithms(const VolumesBench& bench);
void printAlgorithms(const nlohmann::json& report);

}  // namespace sluice
