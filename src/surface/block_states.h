// BlockStates: which blocks of a level the surface passes through, from min-max arrays alone.
//
// Blocks are listed only if they differ from the others, as in the min-max arrays: a volume that is
// mostly background costs only its other blocks. Immutable once made.
#pragma once

#include <cstdint>
#include <vector>

#include "src/base/sources/volume_levels.h"
#include "src/surface/inside_set.h"
#include "src/volume/block_layout.h"
#include "src/volume/ranges/slice_ranges.h"

namespace sluice {

struct BlockStates {
  struct Block {
    int64_t id = 0;
    RangeState state = RangeState::kMixed;
  };
  BlockLayout layout;
  RangeState others = RangeState::kOutside;  // of the blocks that are not listed: never kMixed
  std::vector<Block> blocks;                 // ids ascending

  RangeState stateOf(int64_t id) const;
};

// `closed_at`: cells whose border the surface is closed along, in a closed surface: blocks at that
// border are mixed unless all of their voxels are outside. Null: it stays open.
BlockStates blockStates(const SliceRanges& ranges, const InsideSet& inside, const Box3* closed_at);

// The same for a coarser level, of which no ranges are known: its values lie between those of the
// finest voxels that they are made of. `values`: how they were made; if that is not known, every
// block is mixed. Requires: `finest` knows all its blocks.
BlockStates blockStates(const SliceRanges& finest, const InsideSet& inside, const Box3* closed_at,
                        const BlockLayout& level, const LevelPlacement& placement,
                        LevelValues values);

}  // namespace sluice
