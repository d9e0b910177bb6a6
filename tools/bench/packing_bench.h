// sluice bench packing: the gain from compressing a volume's blocks in memory, by codec.
#pragma once

#include <nlohmann/json.hpp>

#include "tools/options/arguments.h"

namespace sluice {

// {"rows": [{"codec", "level", "ratio", "pack_bytes_per_second", "unpack_bytes_per_second"}]}, on
// one thread, over blocks that are not one value, at most 64 MiB of them. Throws Error.
nlohmann::json benchPacking(const VolumeArguments& volume, const ResourceArguments& resources);
void printPacking(const nlohmann::json& report);

}  // namespace sluice
