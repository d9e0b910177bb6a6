// The numbers in the names of a series' files.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <vector>

namespace sluice {

// The first and the last number of files, in order, that differ in one number alone. nullopt: no
// such series.
std::optional<std::array<int64_t, 2>> numbersOf(const std::vector<std::filesystem::path>& files);

}  // namespace sluice
