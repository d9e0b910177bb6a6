// CutSummary: which levels of resolution the blocks of a picture are of. Plain data.
#pragma once

#include <cstdint>
#include <vector>

namespace sluice {

struct CutSummary {
  struct Level {
    int level = 0;
    int64_t blocks = 0;  // blocks drawn at this level
    int64_t cells = 0;   // finest cells in their object boxes
  };
  std::vector<Level> levels;  // the levels that are drawn, the finest first
  // The share of the finest cells showing something that lies in regions drawn at a coarser level.
  double coarse_share = 0;
  // Whether all coarser ones have spreads beside their means: what is drawn of them is what their
  // finest voxels look like on average.
  bool has_spreads = false;
  // False: a budget ended the refinement before the pixel error was reached.
  bool is_final = true;
};

}  // namespace sluice
