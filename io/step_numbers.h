// The numbers in the names of a series' files; see also stepOfNumber() (open_volume.h).
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "src/base/sources/volume_source.h"

namespace sluice {

// The numbers of the first and the last file of a series of a file a step. nullopt: no such series.
std::optional<std::array<int64_t, 2>> numbersOfSteps(VolumeSource& source);

}  // namespace sluice
