// CutSummary: which levels of resolution the blocks of a picture are of. Plain data.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "src/base/sources/volume_levels.h"

namespace sluice {

// The spreads of coarse voxels (volume_levels.h) in units of values: how much the finest values
// differ below the voxels that are shown. Of labels: the share, up to 1, of the finest voxels that
// have another label.
struct StandingSpread {
  double largest = 0, mean = 0;
};

struct CutSummary {
  struct Level {
    int level = 0;
    int64_t blocks = 0;  // blocks drawn at this level
    int64_t cells = 0;   // finest cells in their object boxes
  };
  std::vector<Level> levels;  // the levels that are drawn, the finest first
  // The share of the finest cells showing something that lies in regions drawn at a coarser level.
  double coarse_share = 0;
  // Whether all coarser ones have spreads beside their means, or shares beside their labels: what
  // is drawn of them is what their finest voxels look like on average.
  bool has_spreads = false;
  LevelValues values = LevelValues::kUnknown;  // what the voxels of coarser levels are
  // False: a budget or the time ended the refinement before the pixel error was reached.
  bool is_final = true;
  // The data of finer blocks was not in memory in time: a later picture shows them.
  bool will_improve = false;
  // Coarser blocks in the picture below which the finest level shows something thinner than two of
  // their voxels: they may show next to nothing of it.
  int64_t thin_blocks = 0;
  // With surfaces, this is the change of thin_blocks by the voxels that were read. Blocks that lose
  // part of a surface (lost_surfaces.h) are added, and blocks that lose nothing are taken away.
  // Unset before the reading, and without surfaces.
  std::optional<int64_t> thin_change;
  // The spread or share of the blocks whose voxels were read; unset before that, and without.
  std::optional<StandingSpread> spread;
};

}  // namespace sluice
