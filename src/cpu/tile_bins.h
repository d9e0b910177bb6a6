// TileBins: for each tile of a picture, which boxes may be seen in it, in the order in which they
// were given. Pure function.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "src/cpu/kernels/kernel_values.h"

namespace sluice {

struct TileBins {
  // Tile t has boxes[first[t]] .. boxes[first[t + 1]].
  std::vector<size_t> first;
  std::vector<uint32_t> boxes;

  std::span<const uint32_t> of(int64_t tile) const {
    const auto t = static_cast<size_t>(tile);
    return {boxes.data() + first[t], first[t + 1] - first[t]};
  }
};

// Bins for `tiles_up` of the picture's rows of tiles, from row `lowest` on.
TileBins tileBins(std::span<const KernelBox> boxes, int tiles_across, int tiles_up, int lowest = 0);

}  // namespace sluice
