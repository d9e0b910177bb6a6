#include "src/cpu/added_boxes.h"

#include <array>
#include <cstdint>
#include <map>

namespace sluice {
namespace {

using Corners = std::array<int64_t, 6>;

Corners cornersOf(const Box3& cells) {
  return {cells.lo[0], cells.lo[1], cells.lo[2], cells.hi[0], cells.hi[1], cells.hi[2]};
}

}  // namespace

std::vector<BoxDraw> joinAlike(std::span<const std::vector<BoxDraw>> of_channels) {
  std::vector<BoxDraw> all;
  std::vector<std::map<Corners, size_t>> places(of_channels.size());
  for (size_t c = 1; c < of_channels.size(); ++c)
    for (size_t i = 0; i < of_channels[c].size(); ++i)
      places[c].emplace(cornersOf(of_channels[c][i].cells), i);
  std::vector<size_t> next(of_channels.size());
  const auto append = [&](size_t c, bool joins) {
    all.push_back(of_channels[c][next[c]++]);
    all.back().channel = static_cast<uint32_t>(c);
    all.back().joins = joins;
  };
  while (next[0] < of_channels[0].size()) {
    const Corners corners = cornersOf(of_channels[0][next[0]].cells);
    std::vector<size_t> joining;
    for (size_t c = 1; c < of_channels.size(); ++c) {
      const auto found = places[c].find(corners);
      if (found == places[c].end() || found->second < next[c]) continue;
      // The boxes in front of it come first.
      while (next[c] < found->second) append(c, false);
      joining.push_back(c);
    }
    append(0, false);
    for (const size_t c : joining) append(c, true);
  }
  for (size_t c = 1; c < of_channels.size(); ++c)
    while (next[c] < of_channels[c].size()) append(c, false);
  return all;
}

}  // namespace sluice
