// A trace as others write them, for replays of more requests than a small picture has.
#pragma once

#include <fmt/format.h>

#include <cstdint>
#include <string>

namespace sluice {

// Requests of 2000 chunks, some far oftener than others, by a rule that repeats late.
inline std::string skewedCsv(int requests) {
  std::string csv;
  uint64_t state = 7;
  for (int i = 0; i < requests; ++i) {
    state = state * 6364136223846793005u + 1442695040888963407u;
    const double draw = static_cast<double>(state >> 11) * 0x1p-53;
    csv += fmt::format("{},{},4096\n", i / 100, static_cast<int>(2000 * draw * draw * draw));
  }
  return csv;
}

}  // namespace sluice
